// SPDX-License-Identifier: Apache-2.0
#pragma once

// The two scenes of `mtf demo`: a landscape as in a thermal image for the eye, and sine targets for measurements. Both
// are computed, square, and hold a whole number of detector pixels.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/image.h"

namespace apps {

/// In-band radiance (W m-2 sr-1, 1.7 to 6 as in the MWIR) of a landscape with a vehicle, bar and star targets and
/// point sources; edges are area-averaged over each sample. No highlight is far brighter than the rest, so that a
/// picture can show all values and still has grey values left for the bars.
mtf::Image demo_landscape(std::int64_t size);

/// One strip a target over the full width: mean + amplitude cos(pi k (i + 1/2) / size), k = `half_cycles[strip]`.
/// These cosines are continued by a reflect border and are orthogonal to one another over the width, so each target's
/// amplitude can be read off the whole frame without a window.
mtf::Image demo_sine_targets(std::int64_t size, const std::vector<int>& half_cycles, double mean, double amplitude);

/// Amplitude of cos(pi k (i + 1/2) / width) over the frame, as a share of the rows: 2/width sum_x cos(...) mean_y
/// image. k may lie beyond the width: its alias is read, with its sign.
double cosine_amplitude(mtf::ImageView<const float> image, int half_cycles);

// The thermal cameras of `mtf demo`, a cooled and an uncooled one: a scene of temperatures through their whole chains,
// with their noise budgets.

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
