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
  std::vector<std::array<double, 4>> cubic;  ///< in d - centre; one more for what is out of reach
  std::vector<double> esf, lsf;
  std::array<std::vector<double>, kShapes> slope;
  /// The bins [first, end) outside which the line spread is below a thousandth of that at the edge: where bends of the
  /// edge are seen. Their derivatives, the terms t^2 and higher, count as zero elsewhere.
  int bend_first = 0, bend_end = kBins;
  bool shows_bends(int i) const { return i >= bend_first && i < bend_end; }
};
StepProfile make_profile(const ReferenceTable& table);
void find_bend_bins(StepProfile& profile);

/// Sums by bins of d of powers of t, up to t^2 alone and t^1 with the residual; where `bends` are asked for and seen up
/// to t^10 and t^5.
class EdgeSums {
 public:
  EdgeSums() = default;
  explicit EdgeSums(bool bends);

  /// 1, t, t^2, r, r t, r^2 of a bin.
  const double* low(int i) const { return plain(i); }
  double count(int i) const { return plain(i)[0]; }
  double moment(int i, int k) const { return k < 3 ? plain(i)[k] : bent(i)[k - 3]; }        ///< sum of t^k
  double residual(int i, int k) const { return k < 2 ? plain(i)[3 + k] : bent(i)[6 + k]; }  ///< sum of r t^k
  double square(int i) const { return plain(i)[5]; }                                        ///< sum of r^2
  /// As if each pixel's residual in the bin were less by change[0] + change[1] t, or where `bends` are asked for and
  /// seen by change[0] + .. + change[5] t^5.
  void take_from_residual(int i, const std::array<double, kHighestOrder + 1>& change, bool bends);
  double pure_error(int i) const;  ///< sum of r^2 about the bin's own mean, count - 1 degrees of freedom
  bool bends() const { return !bent_.empty(); }
  void drop_bends() { bent_.clear(); }

 private:
  friend EdgeSums accumulate(const EdgePixels&, const EdgeModel&, const StepProfile&, bool, std::size_t);
  static constexpr std::size_t kPlain = 8, kBent = 12;  // one cache line a bin; 1, t, t^2, r, r t, r^2
  const double* plain(int i) const { return plain_.data() + static_cast<std::size_t>(i) * kPlain; }
  const double* bent(int i) const { return bent_.data() + static_cast<std::size_t>(i) * kBent; }

  std::vector<double> plain_, bent_;  // one more bin, for pixels out of reach
};

/// Takes every `step`-th pixel.
EdgeSums accumulate(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile, bool bends,
                    std::size_t step = 1);

}  // namespace calib
