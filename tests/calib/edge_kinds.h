// SPDX-License-Identifier: Apache-2.0
#pragma once

// Kinds of edges that measure_edge does not assume, each with its exact truth: bent edges, light scattered far, uneven
// light, stripes, blurs of other shapes than its reference. Pixels are exact: E is closed or a quadrature over its OTF,
// with the footprint of the pixel in it, and bends offset it along the normal.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/measure/measure.h"
#include "tests/calib/made_edges.h"

namespace made {

struct Kind {
  std::string name;
  Step step;
  Scene scene;
  std::function<void(mtf::Image&, const Scene&, const Step&)> spoil{};  ///< shading, stripes or other noise
};
/// Those whose name holds `part`.
std::vector<Kind> edge_kinds(std::string_view part = "");

/// What is compared: MTF at four frequencies, MTF50, FWHM, overshoot.
inline constexpr int kFigures = 7;
inline constexpr std::array<const char*, kFigures> kFigureNames{"MTF(.05)", "MTF(.1)", "MTF(.25)", "Nyquist",
                                                                "MTF50",    "FWHM",    "overshoot"};
std::array<double, kFigures> truth_of(const Step& step);
std::array<std::optional<calib::Estimate>, kFigures> figures_of(const calib::EdgeMeasurement& found);

/// Of the draws that were measured: those that state a figure, and of these those whose 95 % interval holds the truth.
struct Coverage {
  int draws = 0, refused = 0, warned = 0;
  std::array<int, kFigures> stated{}, held{};
  std::array<double, kFigures> bias{};                      ///< mean error, in stated deviations
  std::array<std::vector<double>, kFigures> sd{}, error{};  ///< of each draw
  std::vector<std::string> words{};                         ///< warnings and reasons, without their numbers
};
Coverage coverage_of(Kind kind, int draws, std::uint64_t seed);

}  // namespace made
