// SPDX-License-Identifier: Apache-2.0
#pragma once

// The thermal camera of `mtf demo`: a scene of temperatures through a whole chain, with its noise budget.

#include <filesystem>
#include <string>

#include "mtf/image.h"

namespace apps {

/// Writes camera.toml, thermal.exr (temperatures in K of the given landscape) and the image of the camera,
/// camera.exr (counts), into the folder; returns the lines of the summary. `scene` and `image` become temperatures and
/// counts, to be shown side by side.
std::string demo_thermal(const std::filesystem::path& folder, const mtf::Image& landscape, double step_um, int threads,
                         mtf::Image& scene, mtf::Image& image);

}  // namespace apps
