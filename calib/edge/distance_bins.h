// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bins of the distance from an edge, fine where an edge spread function is steep. They are where the model is tabulated
// (a cubic a bin) and where pixels' residuals are summed; no pixel's value is ever replaced by that of its bin.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace calib {

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

}  // namespace calib
