// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a scene file and temperatures to what radiometry/render makes pictures of: facets, finishes and temperatures of
// all sides, sky, ground and sun of the weather at that time, and the air.
//   temperatures  of the folder that `mtf heat` wrote (straight lines between its times), of a table of facets, or,
//   where
//                 neither is given, those that the regions of the file have
//   sky, sun, air picture_surroundings.h
//   ground        [ground]: of given temperature, or solved as a level surface from the start of the run; without it
//                 black and as warm as the air

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/render/picture_surroundings.h"
#include "apps/scene/render/side_temperatures.h"
#include "radiometry/render/render_scene.h"

namespace apps::scene {

struct PictureOptions {
  std::string temperatures{};                 ///< folder of `mtf heat`, or a table of facets; "": of the file
  std::optional<double> utc_s{};              ///< else the end of the table, or the start of the file
  std::optional<FacetTemperatures> solved{};  ///< in place of both
  /// [atmosphere] of the sensor file.
  std::optional<radiometry::atmosphere::Air<double>> sensor_air{};
  std::string sensor_file{};  ///< for messages
  bool air = true;            ///< false: pictures of surfaces alone
};

struct PictureScene {
  std::unique_ptr<radiometry::scene::Rays> rays;
  radiometry::render::RenderScene scene;  ///< refers to `rays`
  double utc_s = 0.0;
  std::vector<std::pair<std::string, std::string>> closures;  ///< what stands for sky, sun, ground and air: name, words
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, double>> timing_ms;
};

/// Throws UsageError for regions without a temperature (by name), times that tables and weather do not have, air in
/// both files, and as read_surfaces; RuntimeError for files that cannot be read.
PictureScene read_picture_scene(const SceneFile& file, const PictureOptions& options);

/// The same without facets, for pictures from layers: finishes of the materials in their order, and what is around
/// them. Temperatures are of no account.
PictureScene read_layer_scene(const SceneFile& file, const PictureOptions& options);

/// Throws UsageError where the camera is below the ground: it looks at the back of an open surface above it, and
/// nothing is below.
void require_above_ground(const PictureScene& picture, const radiometry::scene::Point& camera);

}  // namespace apps::scene
