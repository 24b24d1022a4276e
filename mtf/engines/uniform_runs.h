// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a plane is flat: which groups of 16 samples of its rows are uniform, and with which value. Only values that are
// found at 8 x 8 places of the plane count, so that a plane without flat parts costs a few comparisons, and one with
// such parts costs less than the sum of its samples. Flat parts smaller than an eighth of a side may not be found; they
// would save little.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mtf/image.h"

namespace mtf {

class UniformRuns {
 public:
  static constexpr std::int64_t kGroup = 16;
  /// Of a group: 0 where its samples differ (or have a value that was not found), else the k of their value(k).
  using Kind = std::uint8_t;

  UniformRuns() = default;
  /// Only finds the values.
  explicit UniformRuns(ImageView<const float> plane);

  bool any() const { return !values_.empty(); }
  float value(Kind kind) const { return values_[kind - 1U]; }
  /// The kind of a value; 0 when it was not found.
  Kind kind_of(float value) const;
  /// Groups of a row; the last may be shorter.
  std::int64_t groups() const { return groups_; }
  const Kind* row(std::int64_t y) const { return kinds_.data() + y * groups_; }
  /// Fills in row y and returns it. Several threads may classify rows of their own.
  const Kind* classify_row(std::int64_t y);
  std::size_t bytes() const { return values_.size() * sizeof(float) + kinds_.size() * sizeof(Kind); }

 private:
  ImageView<const float> plane_;
  std::int64_t groups_ = 0;
  std::vector<float> values_;
  std::vector<Kind> kinds_;
};

}  // namespace mtf
