// SPDX-License-Identifier: Apache-2.0
#pragma once

// The E(d) of a step and its derivatives, tabulated by bins of the distance, for many pixels.

#include <vector>

#include "calib/edge/reference_step.h"

namespace calib {

/// In each bin E is a cubic in d - centre, whose c0 and c1 are E and the line spread at the middle of the bin; the
/// derivatives by the shape are taken there.
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
