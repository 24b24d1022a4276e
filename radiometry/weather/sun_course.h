// SPDX-License-Identifier: Apache-2.0
#pragma once

// How light changes with the height of the sun within a record, h, but for a factor: what an hour's mean is spread by.
//   beam, normal          sin h / (sin h + 0.15) above the horizon: a clear sky's within a tenth above 5 degrees
//   on a horizontal plane sin h + 0.1, down to the end of civil twilight: from the sky, and all of it

#include <algorithm>

namespace radiometry::heat {

constexpr double beam_course(double sine) {
  constexpr double kHalf = 0.15;
  return sine > 0.0 ? sine / (sine + kHalf) : 0.0;
}

constexpr double sky_course(double sine) {
  constexpr double kTwilight = 0.1;  // of 6 degrees
  return std::max(0.0, sine + kTwilight);
}

}  // namespace radiometry::heat
