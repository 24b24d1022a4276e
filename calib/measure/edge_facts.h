// SPDX-License-Identifier: Apache-2.0
#pragma once

// Facts about a region that follow from the fit of a step: how far its pixels extend, their noise, other structure.
// The judgement (edge_outcome.h) is made from these facts.

#include <algorithm>
#include <cstddef>

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_fit.h"

namespace calib {

/// Structure beside the edge, as a share of the contrast, from which a warning is given.
inline constexpr double kVisibleStructure = 0.03;

/// Distances a pixel below which the shape of a step is hardly known.
inline constexpr double kFewDistances = 3.0;

/// Widths of the blur, 1 / (largest line spread), below which a side is short.
inline constexpr double kShortSide = 4.4;

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
  bool short_sides() const { return std::min(extent_dark_px, extent_bright_px) < kShortSide * width_px; }
  /// With fewer distances a pixel than three, a correction of the reference cannot be told from aliases.
  bool few_distances() const { return oversampling < kFewDistances; }
};
EdgeFacts facts_of(const EdgePixels& pixels, const FitState& state, const EdgeModel& model, double local_noise_sd);

/// What pixels of the plateaus differ by from the model, and pixels at equal distances from each other, beyond what
/// neighbouring pixels differ by, as a share of the contrast; of the range of the values, 1, where the fitted contrast
/// is larger than that.
double structure_share(const EdgeFacts& facts);

/// Noise from differences of neighbouring pixels, half of which may lie on structure.
double local_noise(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts);

}  // namespace calib
