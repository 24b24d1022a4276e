// SPDX-License-Identifier: Apache-2.0
#pragma once

// The model of an edge, and what one pass over its pixels leaves: residuals, summed by distance.
// A pixel at distance d and t = s / half_length along the edge is
//   D + (B - D) E(d),  D = level[0] + level[2] d + level[4] t,  B = level[1] + level[3] d + level[5] t.
// Every derivative of it is a function of d times a power of t, so that the normal equations of any set of unknowns
// follow from sums of t^k and r t^k over bins of d. Residuals are those of the pixels, at their own distances; only the
// derivatives are taken at the middle of the bin, which changes the way to the solution but not what is solved.

#include <array>
#include <cstddef>
#include <vector>

#include "calib/distance_bins.h"
#include "calib/edge_curve.h"
#include "calib/edge_pixels.h"
#include "calib/reference_step.h"

namespace calib {

inline constexpr int kLevels = 6;
inline constexpr int kHighestOrder = 5;

struct EdgeModel {
  EdgeCurve curve;  ///< in the coordinates of EdgePixels
  std::array<double, kLevels> level{};
  ReferenceShape shape;
  double contrast() const { return level[1] - level[0]; }
};

/// E(d) as a cubic a bin, and at the middle of each bin E, the line spread and the derivatives by the shape.
struct StepProfile {
  std::vector<std::array<double, 4>> cubic;  ///< in d - centre
  std::vector<double> esf, lsf;
  std::array<std::vector<double>, kShapes> slope;
};
StepProfile make_profile(const ReferenceTable& table);

struct EdgeSums {
  int order = 1;  ///< powers of t: t^0 .. t^(2 order) alone, t^0 .. t^order with the residual
  std::vector<double> sums;

  explicit EdgeSums(int order_of_curve)
      : order(order_of_curve > 2 ? kHighestOrder : order_of_curve), sums(kBins * stride()) {}
  std::size_t stride() const { return static_cast<std::size_t>(3 * order + 3); }
  const double* bin(int i) const { return sums.data() + static_cast<std::size_t>(i) * stride(); }
  double count(int i) const { return bin(i)[0]; }
  double moment(int i, int k) const { return bin(i)[k]; }                    ///< sum of t^k
  double residual(int i, int k) const { return bin(i)[2 * order + 1 + k]; }  ///< sum of r t^k
  double square(int i) const { return bin(i)[3 * order + 2]; }               ///< sum of r^2
  /// As if each pixel's residual in the bin were larger by `more`.
  void add_to_residual(int i, double more);
  double pure_error(int i) const;  ///< sum of r^2 about the bin's own mean, count - 1 degrees of freedom
};

/// Takes every `step`-th pixel.
EdgeSums accumulate(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile, int order,
                    std::size_t step = 1);

}  // namespace calib
