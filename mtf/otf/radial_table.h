// SPDX-License-Identifier: Apache-2.0
#pragma once

// A function of |f| as a table, linear between dense knots: used to evaluate radial OTF factors at millions of
// grid points. The function is sampled exactly on a coarse grid that is doubled until cubic interpolation reproduces
// the new midpoints within the target; the dense knots come from those cubics.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace mtf {

class RadialTable {
 public:
  static constexpr std::int64_t kMostSamples = 32768;
  /// Table of `f` on [0, end]; beyond `end` it is f(end) (0 when `end` is the cutoff). `f` fills values at many radii.
  using Function = std::function<void(std::span<const double> radius, std::span<double> value)>;
  /// The table is refined up to about `most` samples.
  RadialTable(const Function& f, double end, double target, std::int64_t most = kMostSamples);

  /// value[i] *= table at end x sqrt(x2[i] + y2): squares of frequencies relative to the table's end.
  void multiply(std::span<const float> x2, float y2, std::span<float> value) const;

  /// The same for a function of one signed coordinate, even about 0: value[i] *= table at end x |x[i] + y|.
  void multiply_line(std::span<const float> x, float y, std::span<float> value) const;

  double end() const { return end_; }

  /// Largest |table - f| seen at the midpoints, with a factor 2 for what lies between.
  double error() const { return error_; }
  /// The same for multiply_line, whose float coordinates may cancel: their rounding times the steepest slope.
  double line_error() const { return error_ + 0x1p-22 * steepest_; }
  /// Largest |f| at radii >= r.
  double bound_from(double r) const;

 private:
  std::vector<std::array<float, 2>> knots_;  // value, and rise to the next
  std::vector<double> suffix_max_;
  double end_ = 0.0;
  double error_ = 0.0;
  double steepest_ = 0.0;  ///< |slope| per table length
  double between_ = 0.0;   ///< how far the function may rise between two samples
};

}  // namespace mtf
