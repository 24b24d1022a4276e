// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/fly/look_ahead.h"

#include <algorithm>
#include <chrono>

#include "mtf/error.h"
#include "mtf/work/stop.h"

namespace apps::scene {

namespace render = radiometry::render;

void LookAhead::begin(std::vector<render::Camera> cameras, std::function<std::unique_ptr<Light>()> make) {
  enough_ = false;
  found_ = std::async(std::launch::async, [this, cameras = std::move(cameras), make = std::move(make)] {
    const mtf::StopScope scope(&ended_);
    Found found;
    const std::unique_ptr<Light> copy = make();
    for (const render::Camera& camera : cameras) {
      try {
        require_above_ground(copy->scene, camera.position);
        copy->renderer->render(camera);
      } catch (const mtf::UsageError&) {  // there is no picture from there
      }
      found.looked_from.push_back(camera);
      if (enough_) break;  // not before the first one: frame after frame, all of them have their turn
    }
    found.known = copy->renderer->known();
    return found;
  });
}

void LookAhead::take(render::Renderer& renderer) {
  if (!found_.valid() || found_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  try {
    Found found = found_.get();
    renderer.learn(*found.known);
    looked_from_.insert(looked_from_.end(), found.looked_from.begin(), found.looked_from.end());
  } catch (const std::exception&) {  // such as too little memory for a copy: frames do without
  }
}

bool LookAhead::has_seen(const render::Camera& camera, double near_m) const {
  using radiometry::scene::operator-;
  constexpr double kSameDirection = 0.999;
  return std::any_of(looked_from_.begin(), looked_from_.end(), [&](const render::Camera& other) {
    return radiometry::scene::length(camera.position - other.position) < near_m &&
           radiometry::scene::dot(camera.ahead, other.ahead) > kSameDirection && camera.step_x == other.step_x &&
           camera.step_y == other.step_y && camera.width == other.width && camera.height == other.height;
  });
}

}  // namespace apps::scene
