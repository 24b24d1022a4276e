// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a region holds one edge that can be measured, and if not, what to change.

#include <optional>
#include <string>

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/measure.h"

namespace calib {

struct Outcome {
  Trouble trouble = Trouble::none;
  std::string reason;
};

/// Before anything is fitted: pixels, clipping, contrast at all.
Outcome judge_region(const RegionFacts& facts, const Roi& roi, const MeasureOptions& options);

/// What the fit says of the region.
struct EdgeFacts {
  double length_px = 0.0;
  double width_px = 0.0;                              ///< equivalent width of the line spread
  double reach_dark_px = 0.0, reach_bright_px = 0.0;  ///< mean extent of the pixels on both sides
  double contrast = 0.0;                              ///< in units of EdgePixels::value, as the next three
  double noise_sd = 0.0;
  double local_noise_sd = 0.0;  ///< from neighbours
  double plateau_sd = 0.0;      ///< of the pixels of the plateaus about the model
  double significance = 0.0;    ///< contrast / its sd
  bool bright_is_flat = false;  ///< many pixels at the largest value, though the dark side has noise
  bool dark_is_flat = false;    ///< many at the smallest, though the bright side has noise
  std::size_t outliers = 0;     ///< pixels left out
  std::int64_t missing = 0;     ///< pixels without data that are worth a word
  double oversampling = 0.0;
  double narrowed_px = 0.0;  ///< pixels further from the edge are left out: the levels bend there; 0 = none
  bool levels_bend = false;  ///< those near the edge too
};
EdgeFacts facts_of(const EdgePixels& pixels, const FitState& state, const EdgeModel& model, double local_noise_sd);
Outcome judge_edge(const EdgeFacts& facts);
/// Of the result: whether it can be that of a step.
Outcome judge_response(const EdgeMeasurement& out);

/// Removes hot and dead pixels and the like, if there are few; returns how many.
std::size_t remove_outliers(EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile,
                            const EdgeFacts& facts);
/// Whether outliers may be why pixels are further from the model than neighbours from each other.
bool suspects_outliers(const EdgeFacts& facts);

/// What is worth knowing though there is a result.
void warn(const EdgeFacts& facts, EdgeMeasurement& out);

/// Noise from differences of neighbours, half of which may lie on structure.
double local_noise(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts);

}  // namespace calib
