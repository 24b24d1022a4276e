// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weighted radiance of a blackbody for every pixel of a temperature image: the integral of BandResponse, made
// once into a table that the bits of the temperature index.
//
// First log L is sampled over log T, with its slope, densely enough that cubics through value and slope at both ends
// are right within 1e-9: L itself runs over hundreds of decades, its logarithm over a few hundreds. Then each octave of
// T is cut into 2^n cells, n such that L grows by less than 7 % in a cell, and each gets the cubic through L and dL/dT
// at its ends. A float has its octave in the exponent and its cell in the leading bits of the mantissa, so that a pixel
// takes no logarithm, no exponential and no search. The relative error is below 1e-7 before the result is rounded to
// float, and L rises strictly with T.

#include <bit>
#include <cstdint>
#include <vector>

#include "radiometry/light/band_response.h"

namespace radiometry {

class RadianceTable {
 public:
  /// For temperatures from lo_k to hi_k, 0 <= lo <= hi, finite. Throws UsageError for others.
  RadianceTable(const BandResponse& response, double lo_k, double hi_k, Flux flux = Flux::photons);

  /// Photons per second or watts, m^-2 sr^-1, weighted by the response, of a temperature in [lo, hi]; 0 where the
  /// radiance is below the smallest float. Below lo it is 0, above hi that of hi; NaN for NaN, infinite for infinite.
  double operator()(float temperature_k) const {
    const auto bits = std::bit_cast<std::uint32_t>(temperature_k);
    if (!(temperature_k >= start_)) return temperature_k < start_ ? 0.0 : static_cast<double>(temperature_k);
    if (temperature_k > end_) return beyond(temperature_k);
    const Cell& cell = cells_[(bits >> shift_) - first_];
    const double t = static_cast<double>(bits & mask_) * step_;
    return cell.c0 + t * (cell.c1 + t * (cell.c2 + t * cell.c3));
  }

 private:
  /// Cubic of the place in a cell, 0 to 1.
  struct Cell {
    double c0, c1, c2, c3;
  };
  double beyond(float temperature_k) const;

  float start_ = 0.0F, end_ = 0.0F;  ///< where there is radiance; no cells: start above end
  std::uint32_t shift_ = 0, first_ = 0, mask_ = 0;
  double step_ = 0.0;
  std::vector<Cell> cells_;
};

}  // namespace radiometry
