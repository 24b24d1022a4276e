// SPDX-License-Identifier: Apache-2.0
#pragma once

// The 3-D scene with other weather, another engine or other materials: a heat balance of its own, in the
// background. Until it is there pictures have the temperatures before the change.

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/scene/render/picture_scene.h"

namespace apps::live {

/// A scene with its temperatures.
struct SolvedScene {
  scene::SceneFile file;
  scene::PictureOptions air;
  std::unique_ptr<scene::PictureSource> source{};
};

/// A step of the heat balance and how much of it is done, for a page: "temperatures, 50 %".
std::string stage_words(const std::string& step, double share);

/// Hears what is going on and how much of it is done, 0 to 1.
using SolveProgress = std::function<void(const std::string& step, double share)>;
/// The scene of that text. Throws what is wrong with it, and mtf::Stopped where nobody wants it any more.
using SolveScene = std::function<std::shared_ptr<SolvedScene>(const std::string& text, const SolveProgress& progress)>;

class SolvedScenes {
 public:
  SolvedScenes(std::string start_text, std::shared_ptr<SolvedScene> start, SolveScene solve);
  ~SolvedScenes();
  SolvedScenes(const SolvedScenes&) = delete;
  SolvedScenes& operator=(const SolvedScenes&) = delete;

  struct Found {
    std::shared_ptr<SolvedScene> scene{};  ///< null: it is being worked out, or waits for another one
    std::string waiting{};                 ///< what is going on: "temperatures, 50 %, 9 s"
  };
  /// The scene of that text, "" for the start, for a page of the browser. One that is not known begins to be worked
  /// out; that ends the one that the same page has asked for before, while another page's is waited for. Throws what
  /// has ended that scene's heat balance. From several threads.
  Found find(const std::string& text, const std::string& tab);
  const std::shared_ptr<SolvedScene>& start() const { return start_; }

 private:
  struct Work;
  struct Known {
    std::string text;
    std::shared_ptr<SolvedScene> scene;
  };
  void take_finished();
  /// Ends it, without waiting for that.
  void end_work();

  std::string start_text_;
  std::shared_ptr<SolvedScene> start_;
  SolveScene solve_;
  std::mutex mutex_;
  std::vector<Known> known_{};  ///< the last ones that were worked out, the newest at the end
  std::shared_ptr<Work> work_{};
  std::vector<std::shared_ptr<Work>> ended_{};  ///< until their threads have noticed
};

}  // namespace apps::live
