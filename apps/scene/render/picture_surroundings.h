// SPDX-License-Identifier: Apache-2.0
#pragma once

// What surrounds the facets of a scene in pictures of it at one time, from its weather.
//   air  [atmosphere] of the scene file, its lowest 2 km as the weather has them; or that of the sensor file, as it
//        stands there
//   sky  with layered air its clear sky, and clouds as black as the air is warm: as many as [sky] says, or as give the
//        long wave that the weather has; else a blackbody of the long wave that [sky] makes of the weather
//   sun  of the weather's direct irradiance

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/scene_file/scene_file.h"
#include "radiometry/render/render_scene.h"

namespace apps::scene {

struct PictureAir {
  /// [atmosphere] of the sensor file.
  std::optional<radiometry::atmosphere::Air<double>> of_sensor{};
  std::string sensor_file{};  ///< for messages
  bool wanted = true;         ///< false: pictures of surfaces alone
};

struct PictureSurroundings {
  radiometry::render::Sky sky;
  std::optional<radiometry::render::Sun> sun;
  std::optional<radiometry::atmosphere::Air<double>> air;
  double air_k = 0.0;                                         ///< the weather's
  std::vector<std::pair<std::string, std::string>> closures;  ///< what stands for air, sky and sun: name, words
};

/// Throws UsageError for times that the weather does not have, and for air in both files.
PictureSurroundings picture_surroundings(const SceneFile& file, double utc_s, const PictureAir& air);

}  // namespace apps::scene
