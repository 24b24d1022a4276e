// SPDX-License-Identifier: Apache-2.0
#pragma once

// One set of data as the minimiser sees it: residuals as a function of its own unknowns (geometry, plateaus) and of the
// shared parameters, weighted by the noise, bent by the Huber loss, condensed to a normal matrix.

#include <cmath>
#include <cstdint>

#include "calib/dense.h"
#include "calib/fit/sensors.h"

namespace calib {

/// Residuals beyond this many sd count linearly.
inline constexpr double kHuberSd = 3.0;

/// A residual whose square is the Huber loss of r, and its derivative by r.
struct BentResidual {
  double value = 0.0, slope = 1.0;
};
inline BentResidual bent(double r, bool robust) {
  const double size = std::abs(r);
  if (!robust || size <= kHuberSd) return {r, 1.0};
  const double value = std::sqrt(kHuberSd * (2.0 * size - kHuberSd));
  return {std::copysign(value, r), kHuberSd / value};
}

/// A residual as reports and tests of the model need it: in sd, without the Huber loss.
struct Residual {
  std::int64_t x = 0, y = 0;  ///< pixel
  double value = 0.0;
  double distance_px = 0.0;  ///< distance from an edge; 0 for other data
  double sd = 0.0;           ///< sd of the noise that was assumed
  double shared = 0.0;       ///< variance, in sd^2, of the rounding error that pixels at one distance have in common
};

}  // namespace calib
