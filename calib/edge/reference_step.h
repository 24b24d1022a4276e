// SPDX-License-Identifier: Apache-2.0
#pragma once

// The reference step: a shape close to that of most edges, with three parameters. Its OTF along the normal (c, s) is
//   H(f) = D(f S) exp(-2 pi^2 v f^2) sinc(f sqrt(q) c) sinc(f sqrt(q) s),
//   D(x) = (2/pi) (acos x - x sqrt(1 - x^2)), 0 from x = 1 on:
// a circular pupil with S = wavelength x f-number / pitch, a Gaussian of variance v and a square footprint of area q.
// Its step response has the tail E - 1 = -2 S / (pi^3 d) of diffraction, which extends beyond any region.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "calib/edge/edge_curve.h"

namespace calib {

// Bins of the distance from an edge, fine where an edge spread function is steep. They are where the model is tabulated
// (a cubic a bin) and where pixels' residuals are summed; no pixel's value is ever replaced by that of its bin.

/// Distances from 0 to kRange_px are divided into zones whose step doubles; the other side mirrors them.
inline constexpr double kRange_px = 96.0;
inline constexpr int kFinest = 32;  ///< bins per pixel next to the edge
struct DistanceZone {
  double end_px, step_px;
};
inline constexpr std::array<DistanceZone, 6> kDistanceZones{
    {{2.0, 1.0 / 32}, {6.0, 1.0 / 16}, {12.0, 1.0 / 8}, {24.0, 1.0 / 2}, {48.0, 1.0}, {96.0, 2.0}}};
inline constexpr int kSideBins = 64 + 64 + 48 + 24 + 24 + 24;
inline constexpr int kBins = 2 * kSideBins;  ///< in order of rising distance, the dark side first
inline constexpr int kLot = 16;              ///< bins that loops process together
static_assert(kBins % kLot == 0);
/// A number for each bin, aligned to cache lines.
struct alignas(64) BinRow : std::array<double, kBins> {};

class DistanceBins {
 public:
  /// The bins, which are the same for all edges.
  static const DistanceBins& get();

  /// The bin of a distance, |d| < kRange_px.
  int index(double d_px) const {
    const auto step = static_cast<std::size_t>(std::floor((d_px + kRange_px) * kFinest));
    return at_step_[std::min(step, at_step_.size() - 1)];  // a distance just below the range may round up to its end
  }
  double knot(int i) const { return knot_[static_cast<std::size_t>(i)]; }  ///< lower end of bin i, i <= kBins
  double centre(int i) const { return centre_[static_cast<std::size_t>(i)]; }
  const BinRow& centres() const { return centre_; }
  double width(int i) const { return knot(i + 1) - knot(i); }

  constexpr DistanceBins();

 private:
  std::array<std::int16_t, 2 * static_cast<std::size_t>(kRange_px) * kFinest> at_step_{};  // of the finest bins
  std::array<double, kBins + 1> knot_{};
  BinRow centre_{};
};

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
/// At many frequencies at once.
std::vector<ReferenceOtf> reference_otfs(const ReferenceShape& shape, Point normal, std::span<const double> f_cy_px);

/// E - 1/2, the line spread and the derivatives of E, at the knots of the bright side (all but the line spread are
/// odd).
using SideKnots = std::array<double, kSideBins + 1>;
struct ReferenceTable {
  SideKnots odd{}, lsf{};
  std::array<SideKnots, kShapes> slope{};
};
ReferenceTable tabulate(const ReferenceShape& shape, double angle_rad);

/// E(d) and its derivatives, tabulated for many pixels. In each bin E is a cubic in d - centre, whose c0 and c1 are E
/// and the line spread at the middle of the bin; the derivatives by the shape are taken there.
class StepProfile {
 public:
  StepProfile() = default;
  explicit StepProfile(const ReferenceTable& table);

  const BinRow& esf() const { return rows_[0]; }
  const BinRow& lsf() const { return rows_[1]; }
  const BinRow& cubic(std::size_t k) const { return rows_[k]; }
  const BinRow& slope(std::size_t k) const { return rows_[kCubic + k]; }
  /// E and the line spread of the reference step, which a correction does not change.
  const BinRow& reference_esf() const { return rows_[kReference]; }
  const BinRow& reference_lsf() const { return rows_[kReference + 1]; }
  /// Adds to E, the line spread and c2.
  void correct(const BinRow& esf, const BinRow& lsf, const BinRow& c2);
  /// Adds something that is proportional to S, given per S at the middle of each bin and divided by the contrast.
  void add_per_s(const BinRow& per_s, double s_px);
  /// Takes the reference step and the derivatives by its shape from another.
  void set_reference(const StepProfile& other);

  /// The bins [first, end) outside which the line spread is below a thousandth of that at the edge, in multiples
  /// of kLot. Only there do bends of the edge show; their derivatives, the terms t^2 and higher, count as zero
  /// elsewhere.
  int bend_first = 0, bend_end = kBins;
  void bend_everywhere() { bend_first = 0, bend_end = kBins; }

 private:
  void find_bend_bins();
  static constexpr std::size_t kCubic = 4, kReference = kCubic + kShapes;
  std::vector<BinRow> rows_;
};

}  // namespace calib
