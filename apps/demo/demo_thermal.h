// SPDX-License-Identifier: Apache-2.0
#pragma once

// The thermal cameras of `mtf demo`, a cooled and an uncooled one: a scene of temperatures through their whole chains,
// with their noise budgets.

#include <filesystem>
#include <string>
#include <string_view>

#include "mtf/image.h"

namespace apps {

/// The sensor file of the cooled camera, camera.toml.
std::string_view demo_camera();
/// Its scene, thermal.exr: temperatures in K of a landscape.
mtf::Image demo_temperatures(const mtf::Image& landscape);

/// Writes thermal.exr (temperatures in K of the given landscape), camera.toml, uncooled.toml and the images of these
/// cameras, camera.exr and uncooled.exr (counts), into the folder; returns the lines of the summary. `scene` and
/// `image` become temperatures and the counts of the cooled camera, to be shown side by side.
std::string demo_thermal(const std::filesystem::path& folder, const mtf::Image& landscape, double step_um, int threads,
                         mtf::Image& scene, mtf::Image& image);

}  // namespace apps
