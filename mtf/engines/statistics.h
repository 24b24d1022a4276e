// SPDX-License-Identifier: Apache-2.0
#pragma once

// Statistics of an image plane from the moments of its rows, each about its own mean: they combine without
// cancellation, in any number of threads, while a scene is read row by row.

#include <span>
#include <vector>

#include "mtf/border.h"
#include "mtf/image.h"

namespace mtf {

/// Statistics of an image plane in double. The same bits for any number of threads: rows are summed one by one.
struct Statistics {
  double mean = 0.0;  ///< of the finite pixels; 0 when there is none
  double std = 0.0;   ///< population standard deviation of the finite pixels
  double min = 0.0;
  double max = 0.0;
  std::int64_t not_finite = 0;              ///< NaN and infinite pixels
  std::int64_t first_x = -1, first_y = -1;  ///< position of the first of them, row by row
};

Statistics statistics(ImageView<const float> image, int threads = 1);

/// False when a pixel is NaN or infinite; all that statistics() is not needed for.
bool all_finite(ImageView<const float> image);

/// Of the finite samples of a row; first and last of all samples.
struct RowMoments {
  double mean = 0.0, squares = 0.0, min = 0.0, max = 0.0, first = 0.0, last = 0.0;
  std::int64_t finite = 0, first_bad = -1;
};
RowMoments row_moments(const float* values, std::int64_t n);
std::vector<RowMoments> row_moments(ImageView<const float> plane, int threads = 1);

/// Of all rows of a plane, in order, `width` samples each.
Statistics statistics_of(std::span<const RowMoments> rows, std::int64_t width);
/// rms of the canvas about `mean`, times sqrt(canvas area / image area), where the canvas is the image with its border
/// (mtf/border.h): what a filter error is scaled by. Equal to 2 std for a reflect border.
double canvas_norm_of(std::span<const RowMoments> rows, std::int64_t width, Border border, double border_value,
                      double mean);

}  // namespace mtf
