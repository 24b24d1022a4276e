// SPDX-License-Identifier: Apache-2.0
#pragma once

// The views of sides that a camera will see, worked out beside frames in a copy of the scene, and taken over by the
// renderer of the frames once they are there.

#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <vector>

#include "apps/scene/fly/flight_light.h"

namespace apps::scene {

class LookAhead {
 public:
  LookAhead() = default;
  LookAhead(const LookAhead&) = delete;
  LookAhead& operator=(const LookAhead&) = delete;
  ~LookAhead() { enough_ = ended_ = true; }  // the future waits for the work

  bool is_working() const { return found_.valid(); }  ///< or has found what nobody has taken
  /// Begins to look from these cameras, in the copy that `make` makes, on a thread of its own. Not while it is working.
  void begin(std::vector<radiometry::render::Camera> cameras, std::function<std::unique_ptr<Light>()> make);
  /// The camera that is looked from now is the last one.
  void enough() { enough_ = true; }
  /// What has been found by now is known to `renderer` from here on.
  void take(radiometry::render::Renderer& renderer);
  /// Whether a camera of the same lens, within `near_m` and about in this direction, has been looked from.
  bool has_seen(const radiometry::render::Camera& camera, double near_m) const;
  void forget() { looked_from_.clear(); }  ///< the light is another one

 private:
  struct Found {
    std::shared_ptr<const radiometry::render::Renderer::Known> known{};
    std::vector<radiometry::render::Camera> looked_from{};
  };

  std::vector<radiometry::render::Camera> looked_from_{};
  std::atomic<bool> enough_{false}, ended_{false};
  std::future<Found> found_{};
};

}  // namespace apps::scene
