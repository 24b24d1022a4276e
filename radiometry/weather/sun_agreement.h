// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether sunlight that a station writes fits the sun: global G = B cos z + D of beam B and diffuse D with the cosine
// of the time that a record is taken to stand for. A stamp that is taken for another one shows by half an hour or a
// whole one: 40 W/m2 rms and more on clear days, where G - D - B cos z is a few W/m2 otherwise.

#include <cstddef>
#include <string>
#include <vector>

#include "radiometry/weather/records.h"

namespace radiometry::heat {

/// Sentences: the records fit the sun at another time than the one they are taken for, and which stamp says so; or they
/// fit it at none. Records that are compared are spread over the time that `options` want.
std::vector<std::string> disagreements(const Records& records, Stamp stamp, const Place& place,
                                       const SeriesOptions& options);

/// Beams that the sun cannot give in the time they stand for.
struct LostBeam {
  std::size_t records = 0;
  double first_s = 0.0, most_w_m2 = 0.0;

  void add(double begin_s, double mean_w_m2);
  /// A sentence; "" where there are none but traces.
  std::string text() const;
};

}  // namespace radiometry::heat
