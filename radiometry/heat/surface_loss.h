// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an exposed surface gives off at a temperature, and its derivative, for one facet; the loops of lanes.cpp have
// the same for many.

#include <cmath>

#include "radiometry/heat/convection.h"

namespace radiometry::heat {

struct LossAndSlope {
  double loss, slope;  ///< W/m2; W/m2/K
};

struct SurfaceLoss {
  double emission = 0.0;           ///< epsilon sigma
  double film = 0.0, air_k = 0.0;  ///< of the wind
  NaturalConvection natural;

  /// Below 0 K, which Newton's method may visit, the loss goes on as an odd function, so that it rises everywhere.
  LossAndSlope at(double t) const {
    const double cube = t * t * std::abs(t), excess = t - air_k;
    double c = excess > 0.0 ? natural.warm : natural.cold;
    if (c != 0.0) c *= std::cbrt(std::abs(excess));
    return {emission * cube * t + (film + c) * excess, 4.0 * emission * cube + film + 4.0 / 3.0 * c};
  }
};

}  // namespace radiometry::heat
