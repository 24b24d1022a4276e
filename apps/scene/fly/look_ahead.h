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

  /// True from begin() until take() has handed over what was found.
  bool is_working() const { return found_.valid(); }
  /// Starts a thread that calls `make` for a copy of the scene and renders it from each camera in turn. Only where
  /// is_working() is false.
  void begin(std::vector<radiometry::render::Camera> cameras, std::function<std::unique_ptr<Light>()> make);
  /// The thread ends once the picture that it renders now is done.
  void enough() { enough_ = true; }
  /// Gives the views that were found to `renderer`, if the thread has ended; else does nothing.
  void take(radiometry::render::Renderer& renderer);
  /// Whether a camera with the same lens and format, less than `near_m` away from this one and pointing in nearly the
  /// same direction (cosine above 0.999), has had its turn; it may be in a place that there is no picture from.
  bool has_seen(const radiometry::render::Camera& camera, double near_m) const;
  void forget() { looked_from_.clear(); }  ///< for another light, which needs views of its own

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
