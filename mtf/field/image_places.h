// SPDX-License-Identifier: Apache-2.0
#pragma once

// Places at which figures of an OTF that changes over the image are looked at: 9 x 9, from the centre of one corner
// pixel to that of the opposite one, row by row. The mean over the image is that of Simpson's rule; its change from
// every other place to all tells how well they follow the figure.

#include <vector>

namespace mtf {

struct ImagePlace {
  double x_px = 0.0, y_px = 0.0;           ///< from the upper left corner of the detector
  double weight = 0.0, every_other = 0.0;  ///< in the mean, by all places and by every other one
};

inline constexpr int kImagePlaces = 9;  ///< along an axis

inline std::vector<ImagePlace> image_places(int columns, int rows) {
  const auto at = [](int i, int count) {
    return 0.5 + static_cast<double>(i) * static_cast<double>(count - 1) / static_cast<double>(kImagePlaces - 1);
  };
  const auto simpson = [](int i, int stride) {
    const int last = (kImagePlaces - 1) / stride, k = i / stride;
    if (i % stride != 0) return 0.0;
    return (k == 0 || k == last ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) / (3.0 * last);
  };
  std::vector<ImagePlace> places;
  for (int j = 0; j < kImagePlaces; ++j)
    for (int i = 0; i < kImagePlaces; ++i)
      places.push_back({.x_px = at(i, columns),
                        .y_px = at(j, rows),
                        .weight = simpson(i, 1) * simpson(j, 1),
                        .every_other = simpson(i, 2) * simpson(j, 2)});
  return places;
}

}  // namespace mtf
