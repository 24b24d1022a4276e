// SPDX-License-Identifier: Apache-2.0
#pragma once

// Facts about a region that follow from the fit of a step: how far its pixels extend, their noise, other structure; and
// the judgement made from them, whether the region holds one edge that can be measured, and if not, what to change.

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/measure.h"

namespace calib {

/// Distances a pixel below which the shape of a step is hardly known.
inline constexpr double kFewDistances = 3.0;

struct EdgeFacts {
  double length_px = 0.0;                               ///< of the edge inside the region
  double width_px = 0.0;                                ///< equivalent width of the line spread function
  double extent_dark_px = 0.0, extent_bright_px = 0.0;  ///< mean extent of the pixels on both sides
  double contrast = 0.0;                                ///< in units of EdgePixels::value, as the next three
  double noise_sd = 0.0;
  double local_noise_sd = 0.0;  ///< from differences of neighbouring pixels
  double plateau_sd = 0.0;      ///< of the pixels of the plateaus about the model
  double significance = 0.0;    ///< contrast / its standard deviation
  bool bright_is_flat = false;  ///< many pixels have the largest value, though the dark side has noise
  bool dark_is_flat = false;    ///< many pixels have the smallest value, though the bright side has noise
  /// Many pixels have the smallest and many the largest value, though the edge between them has noise.
  bool both_are_flat = false;
  /// Many pixels have the smallest and many the largest value, and the values next to these are rare: an edge spread
  /// function approaches its plateaus gradually.
  bool ends_abruptly = false;
  std::size_t outliers = 0;          ///< single pixels far from the others at their distance that were left out
  std::size_t cut = 0;               ///< pixels at a limit of the values that count as values beyond it
  std::size_t clipped = 0;           ///< other pixels at a limit: left out
  bool large_errors = false;         ///< the response is not linear in the errors of its shape
  bool unclear_diffraction = false;  ///< noise hides how much of the blur is diffraction
  double shared_noise = 0.0;         ///< largest correlation of the noise of two neighbours; 0 = independent
  double stripes = 0.0;              ///< standard deviation of the offsets of columns or rows, in that of a pixel
  double neighbour_px = 0.0;         ///< distance of another edge, beside the region; 0 = none
  double oversampling = 0.0;         ///< distinct distances a pixel, near the edge
  double far_light = 0.0, gradient = 0.0, curvature = 0.0;  ///< probabilities that the sides show these
  double far_reach_px = 0.0;                                ///< half width of the widest halo that the fit allows for

  /// Sides so short that tails of the blur may count as their plateaus.
  bool short_sides() const {
    constexpr double kWidths = 4.4;  // of the blur, 1 / (largest line spread)
    return std::min(extent_dark_px, extent_bright_px) < kWidths * width_px;
  }
  /// With fewer distances a pixel than three, a correction of the reference cannot be told from aliases.
  bool few_distances() const { return oversampling < kFewDistances; }
};
EdgeFacts facts_of(const EdgePixels& pixels, const FitState& state, const EdgeModel& model, double local_noise_sd);

/// Noise from differences of neighbouring pixels, half of which may lie on structure.
double local_noise(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts);

struct Outcome {
  Trouble trouble = Trouble::none;
  std::string reason;
  bool refused() const { return trouble != Trouble::none; }
};

/// Before anything is fitted: enough pixels with data, few of them clipped, any contrast at all.
Outcome judge_region(const RegionFacts& facts, const Roi& roi, const MeasureOptions& options);
/// After the fit: an edge with enough contrast, length and plateau.
Outcome judge_edge(const EdgeFacts& facts);
/// After the correction, which describes uneven light and light that is scattered far: one edge, neither side clipped.
Outcome judge_structure(const EdgeFacts& facts);
/// Of the curves: whether they can be those of a step.
Outcome judge_response(const EdgeMeasurement& measurement);

/// What is worth knowing though there is a result. `sparse`: missing pixels are nothing to warn of.
std::vector<std::string> warnings_of(const EdgeFacts& facts, const EdgeMeasurement& measurement, bool sparse);

}  // namespace calib
