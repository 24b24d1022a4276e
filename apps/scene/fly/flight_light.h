// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene in the light of one time: what a flight makes once for some time of the scene's clock.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "apps/scene/render/picture_scene.h"
#include "mtf/settings.h"
#include "radiometry/render/renderer.h"

namespace apps::scene {

/// What light depends on.
struct LightKey {
  std::int64_t interval = 0;  ///< of the scene's clock
  std::string response{};
  radiometry::Interval band{};
  std::optional<mtf::SettingsTable> air{};  ///< [atmosphere] of the sensor file

  bool operator==(const LightKey& other) const { return interval == other.interval && same_but_for_time(other); }
  bool same_but_for_time(const LightKey& other) const {
    return response == other.response && band.lo_um == other.band.lo_um && band.hi_um == other.band.hi_um &&
           air == other.air;
  }
};

/// A scene in one light, and what draws it.
struct Light {
  LightKey key;
  PictureScene scene;
  double temperatures_utc_s = 0.0;
  std::unique_ptr<radiometry::render::Renderer> renderer{};
};

}  // namespace apps::scene
