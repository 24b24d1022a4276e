// SPDX-License-Identifier: Apache-2.0
#pragma once

// The thermal camera of `mtf demo`: a scene of temperatures through a whole chain, with its noise budget.

#include <filesystem>
#include <string>

#include "mtf/image.h"

namespace apps {

/// Writes camera.toml, thermal.exr (temperatures in K of the given landscape) and what the camera makes of it,
/// camera.exr (counts), into the folder; returns the lines that tell of it. `scene` and `image` become what to show
/// side by side: temperatures and counts.
std::string demo_thermal(const std::filesystem::path& folder, const mtf::Image& landscape, double step_um, int threads,
                         mtf::Image& scene, mtf::Image& image);

}  // namespace apps
