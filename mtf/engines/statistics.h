// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// rms of the canvas about `mean`, times sqrt(canvas area / image area), where the canvas is the image with its border
/// (mtf/border.h): what a filter error is scaled by. Equal to 2 std for a reflect border.
double canvas_norm(ImageView<const float> image, Border border, double border_value, double mean);

}  // namespace mtf
