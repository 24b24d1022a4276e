// SPDX-License-Identifier: Apache-2.0
#pragma once

// Moments of the rows of a plane, each about its own mean: they combine without cancellation, in any number of threads,
// while a scene is read row by row.

#include <span>
#include <vector>

#include "mtf/engines/statistics.h"

namespace mtf {

/// Of the finite samples of a row; first and last of all samples.
struct RowMoments {
  double mean = 0.0, squares = 0.0, min = 0.0, max = 0.0, first = 0.0, last = 0.0;
  std::int64_t finite = 0, first_bad = -1;
};
RowMoments row_moments(const float* values, std::int64_t n);
std::vector<RowMoments> row_moments(ImageView<const float> plane, int threads = 1);

/// Of all rows of a plane, in order, `width` samples each.
Statistics statistics_of(std::span<const RowMoments> rows, std::int64_t width);
/// canvas_norm of mtf/engines/statistics.h.
double canvas_norm_of(std::span<const RowMoments> rows, std::int64_t width, Border border, double border_value,
                      double mean);

}  // namespace mtf
