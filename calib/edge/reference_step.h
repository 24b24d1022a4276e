// SPDX-License-Identifier: Apache-2.0
#pragma once

// The reference step: a shape close to that of most edges, with three parameters. Its OTF along the normal (c, s) is
//   H(f) = D(f S) exp(-2 pi^2 v f^2) sinc(f sqrt(q) c) sinc(f sqrt(q) s),
//   D(x) = (2/pi) (acos x - x sqrt(1 - x^2)), 0 from x = 1 on:
// a circular pupil with S = wavelength x f-number / pitch, a Gaussian of variance v and a square footprint of area q.
// Its step response has the tail E - 1 = -2 S / (pi^3 d) of diffraction, which extends beyond any region.

#include <array>
#include <span>
#include <vector>

#include "calib/edge/distance_bins.h"
#include "calib/edge/edge_curve.h"

namespace calib {

struct ReferenceShape {
  double s_px = 0.0;                                                            ///< >= 0
  double v_px2 = 0.25;                                                          ///< >= kLeastVariance_px2
  double q_px2 = 0.0;                                                           ///< >= 0
  double blur_px2() const { return v_px2 + q_px2 / 12.0 + 0.1 * s_px * s_px; }  ///< variance of the whole blur
};
inline constexpr double kLeastVariance_px2 = 0.0036;  ///< below this the cubics of the bins are too coarse
inline constexpr int kShapes = 3;                     ///< S, v, q

struct ReferenceOtf {
  double value = 1.0;
  std::array<double, kShapes> slope{};  ///< by S, v, q
};
ReferenceOtf reference_otf(const ReferenceShape& shape, Point normal, double f_cy_px);
ReferenceOtf reference_otf(const ReferenceShape& shape, double angle_rad, double f_cy_px);
/// At many frequencies at once.
std::vector<ReferenceOtf> reference_otfs(const ReferenceShape& shape, Point normal, std::span<const double> f_cy_px);

/// E - 1/2, the line spread and the derivatives of E, at the knots of the bright side (all but the line spread are
/// odd).
struct ReferenceTable {
  std::array<double, kSideBins + 1> odd{}, lsf{};
  std::array<std::array<double, kSideBins + 1>, kShapes> slope{};
};
ReferenceTable tabulate(const ReferenceShape& shape, double angle_rad);

}  // namespace calib
