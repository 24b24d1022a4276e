// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/pupil_circles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mtf {

double root_of_product(double a, double b) { return std::sqrt(std::max(a * b, 0.0)); }

PupilCaps pupil_caps(double nu, double obscuration) {
  PupilCaps caps;
  const auto add = [&](double sign, double side, double radius, double angle, bool hole) {
    if (angle > 0.0) caps.cap[static_cast<std::size_t>(caps.count++)] = {sign, -side * nu, side, radius, angle, hole};
  };
  const double e = obscuration;
  // Angles from legs, so that neither end of acos loses digits; differences like 1 - nu are formed first.
  const double outer = std::atan2(root_of_product(1.0 - nu, 1.0 + nu), nu);
  for (const double side : {1.0, -1.0}) add(1.0, side, 1.0, outer, false);
  if (e == 0.0) return caps;
  if (nu < e)
    for (const double side : {1.0, -1.0}) add(1.0, side, e, std::atan2(root_of_product(e - nu, e + nu), nu), true);
  // d - (1 - e) and (1 + e) - d, rounded once: d - 1 is exact where a small hole touches the edge from either side,
  // 1 - e where a large one does. The slopes there go with the roots of these.
  const double gap = 1.0 - e;
  const double from_inside = e < 0.5 ? (2.0 * nu - 1.0) + e : 2.0 * nu - gap, to_outside = (1.0 - 2.0 * nu) + e;
  if (from_inside <= 0.0) {  // a hole lies inside the other disc
    for (const double side : {1.0, -1.0}) add(-1.0, side, e, std::numbers::pi, true);
    return caps;
  }
  if (to_outside <= 0.0) return caps;
  const double ring = gap * (1.0 + e);
  const double half_chord = root_of_product(to_outside, 1.0 + e + 2.0 * nu);
  const double crossing = half_chord * root_of_product(from_inside, 2.0 * nu + gap) / (4.0 * nu);
  for (const double side : {1.0, -1.0}) {
    add(-1.0, side, 1.0, std::atan2(crossing, nu + ring / (4.0 * nu)), false);
    add(-1.0, -side, e, std::atan2(crossing, nu - ring / (4.0 * nu)), true);
  }
  return caps;
}

}  // namespace mtf
