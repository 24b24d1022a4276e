// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a plane is flat: its rows in groups of 16 samples, each of one level or not. Levels are those found at 8 x 8
// places of the plane, so that a plane without flat parts costs a few compares, and one with such parts less than a
// look at its mean. Flat parts smaller than an eighth of a side may stay unseen: they are worth little.

#include <array>
#include <cstdint>
#include <vector>

#include "mtf/image.h"

namespace mtf {

class UniformRuns {
 public:
  static constexpr std::int64_t kGroup = 16;
  /// Of a group: 0 where samples differ (or are of a level not found), else k of level(k).
  using Kind = std::uint8_t;

  UniformRuns() = default;
  /// Looks for levels only.
  explicit UniformRuns(ImageView<const float> plane);

  bool any() const { return !levels_.empty(); }
  float level(Kind kind) const { return levels_[kind - 1U]; }
  /// The kind of a level; 0 when it is none of them.
  Kind kind_of(float level) const;
  /// Groups of a row; the last may be shorter.
  std::int64_t groups() const { return groups_; }
  const Kind* row(std::int64_t y) const { return kinds_.data() + y * groups_; }
  /// Fills in row y and returns it. Several threads may look at rows of their own.
  const Kind* classify_row(std::int64_t y);

 private:
  ImageView<const float> plane_;
  std::int64_t groups_ = 0;
  std::vector<float> levels_;
  std::vector<Kind> kinds_;
};

}  // namespace mtf
