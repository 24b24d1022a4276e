// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture of facets in false colours, seen by the camera of the scene, for the eye.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"

namespace apps::scene {

/// What the pixels of a picture of 1280 x 960, 40 degrees wide, show; empty when none of them shows a facet. Throws
/// UsageError for a camera whose view is not defined.
std::vector<radiometry::scene::Hit> camera_hits(const HeatScene& scene, const CameraSection& camera);

/// The name of a mesh whose closed shells the camera sees from inside in most of its pixels.
std::optional<std::string> mesh_around_camera(const HeatScene& scene, std::span<const radiometry::scene::Hit> hits);

/// Writes a PNG of these pixels with a bar of temperatures. What the camera does not see, and the sky, is black.
void write_scene_picture(const std::string& path, std::span<const radiometry::scene::Hit> hits,
                         std::span<const double> facet_k, const std::string& caption);

}  // namespace apps::scene
