// SPDX-License-Identifier: Apache-2.0
#pragma once

// Places at which figures of an OTF that changes over the image are looked at: 9 x 9, from the centre of one corner
// pixel to that of the opposite one, row by row; more where tables have positions that are closer. The mean over the
// image is that of Simpson's rule; its change from every other place to all, and that of the worst, tell how well they
// follow the figure, as far as places are no farther apart than positions of tables.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mtf/math/special.h"
#include "mtf/system.h"

namespace mtf {

struct ImagePlace {
  double x_px = 0.0, y_px = 0.0;           ///< from the upper left corner of the detector
  double weight = 0.0, every_other = 0.0;  ///< in the mean, by all places and by every other one
};

inline constexpr int kImagePlaces = 9;  ///< along an axis, without tables

/// The least distance between positions of a table over the field, in pixels; infinite without tables.
template <class S>
double table_step_px(const System<S>& system) {
  const double pitch_um = std::max(value_of(system.frame.pitch_x_um), value_of(system.frame.pitch_y_um));
  double least = std::numeric_limits<double>::infinity();
  for (const FieldNumber<S>& number : system.field.numbers) {
    if (number.map == nullptr) continue;
    const double unit_um = number.map->unit == FieldUnit::pixel        ? pitch_um
                           : number.map->unit == FieldUnit::millimetre ? 1e3
                           : number.map->unit == FieldUnit::slope      ? 1e3 * value_of(system.frame.focal_length_mm)
                                                                       : value_of(system.field_radius_um());
    const std::vector<FieldPoint<double>>& at = number.map->position;
    for (std::size_t i = 0; i < at.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        least = std::min(least, std::hypot(at[i].x - at[j].x, at[i].y - at[j].y) * unit_um / pitch_um);
  }
  return least;
}

/// Whether so many places along an axis are no farther apart than that.
template <class S>
bool follows_tables(const System<S>& system, int along) {
  const int longest = std::max(system.frame.columns, system.frame.rows) - 1;
  return longest <= 1.01 * table_step_px(system) * (along - 1);
}

/// How many places along an axis do, of 9, 17, 33 ... up to `most`.
template <class S>
int image_places_along(const System<S>& system, int most) {
  int along = kImagePlaces;
  while (along < most && !follows_tables(system, along)) along = 2 * along - 1;
  return along;
}

inline std::vector<ImagePlace> image_places(int columns, int rows, int along = kImagePlaces) {
  const auto at = [along](int i, int count) {
    return 0.5 + static_cast<double>(i) * static_cast<double>(count - 1) / static_cast<double>(along - 1);
  };
  const auto simpson = [along](int i, int stride) {
    const int last = (along - 1) / stride, k = i / stride;
    if (i % stride != 0) return 0.0;
    return (k == 0 || k == last ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) / (3.0 * last);
  };
  std::vector<ImagePlace> places;
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < along; ++i)
      places.push_back({.x_px = at(i, columns),
                        .y_px = at(j, rows),
                        .weight = simpson(i, 1) * simpson(j, 1),
                        .every_other = simpson(i, 2) * simpson(j, 2)});
  return places;
}

}  // namespace mtf
