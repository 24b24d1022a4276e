// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture of facets in false colours, seen by the camera of the scene, for the eye.

#include <span>
#include <string>

#include "apps/scene/heat/heat_scene.h"

namespace apps::scene {

/// Whether a facet is in the picture. Throws UsageError for a camera whose view is not defined.
bool camera_sees(const HeatScene& scene, const CameraSection& camera);

/// Writes a PNG of 1280 x 960 pixels, 40 degrees wide, with a bar of temperatures. What the camera does not see of the
/// scene, and the sky, is black.
void write_scene_picture(const std::string& path, const HeatScene& scene, const CameraSection& camera,
                         std::span<const double> facet_k, const std::string& caption);

}  // namespace apps::scene
