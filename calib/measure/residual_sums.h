// SPDX-License-Identifier: Apache-2.0
#pragma once

// The model of an edge, and the residuals of its pixels, summed by distance in one pass.
// A pixel at distance d and t = s / half_length along the edge is
//   D + (B - D) E(d),  D = plateau[0] + plateau[2] d + plateau[4] t + plateau[6] d^2 + plateau[8] d t + plateau[10]
//   t^2,
// and B the same of the odd ones.
// Every derivative of it is a function of d times a power of t, so that the normal equations of any set of unknowns
// follow from sums of t^k and r t^k over bins of d. Residuals are those of the pixels, at their own distances; only the
// derivatives are taken at the middle of the bin, which changes the steps to the solution but not the solution.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "calib/edge/edge_curve.h"
#include "calib/edge/edge_pixels.h"
#include "calib/edge/reference_step.h"

namespace calib {

inline constexpr int kPlateauTerms = 12;
inline constexpr int kFirstCurvature = 6;  ///< the terms from here on are square
inline constexpr int kHighestOrder = 5;

/// The powers of d and t in the term of a plateau.
struct PlateauPowers {
  int d, t;
};
constexpr PlateauPowers plateau_powers(int term) {
  constexpr std::array<PlateauPowers, kPlateauTerms / 2> kPowers{{{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};
  return kPowers[static_cast<std::size_t>(term / 2)];
}

struct EdgeModel {
  EdgeCurve curve;  ///< in the coordinates of EdgePixels
  std::array<double, kPlateauTerms> plateau{};
  ReferenceShape shape;
  double contrast() const { return plateau[1] - plateau[0]; }
};

/// Sums over the pixels of each bin of d: of r^2, of t^k up to t^2 and of r t^k up to r t.
/// For an `order` above 1 there are also sums of t^k up to 2 order and of r t^k up to order, in the bins that show
/// bends.
class EdgeSums {
 public:
  const BinRow& square() const { return rows_[0]; }                       ///< of r^2
  const BinRow& moment(int k) const { return rows_[moment_row(k)]; }      ///< of t^k
  const BinRow& residual(int k) const { return rows_[residual_row(k)]; }  ///< of r t^k
  double count(int i) const { return moment(0)[static_cast<std::size_t>(i)]; }
  int order() const { return static_cast<int>(rows_.size()) / 3 - 1; }
  /// Changes the sums as if each pixel's residual were less by the change in its bin; residuals times powers above t
  /// change only in the bins that show bends.
  void take_from_residual(const BinRow& change, const StepProfile& profile);
  /// Sum of r^2 about the mean residual of the bin, with count - 1 degrees of freedom.
  double pure_error(int i) const;

 private:
  friend EdgeSums accumulate(const EdgePixels&, const EdgeModel&, const StepProfile&, int, std::size_t);
  // r^2, 1, r;  t, t^2, r t;  t^3, t^4, r t^2;  ..
  static constexpr std::size_t rows_of(int order) { return static_cast<std::size_t>(3 * order + 3); }
  static constexpr std::size_t moment_row(int k) { return static_cast<std::size_t>((k + 1) / 2 * 3 + 1 - k % 2); }
  static constexpr std::size_t residual_row(int k) { return static_cast<std::size_t>(3 * k + 2); }
  std::vector<BinRow> rows_;
};

/// The sums over every `step`-th pixel.
EdgeSums accumulate(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile, int order,
                    std::size_t step = 1);

/// Of all residuals in units of their standard deviation.
double largest_deviation(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile,
                         const BinRow& variance);

/// Each pixel's residual and the bin of its distance, kBins beyond the range (there the residual has no meaning).
struct PixelResiduals {
  std::vector<std::int32_t> bin;
  std::vector<double> residual;
};
PixelResiduals residuals_of(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile);

}  // namespace calib
