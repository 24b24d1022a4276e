// SPDX-License-Identifier: Apache-2.0
#pragma once

// The response of an OTF to a point, as taps on the scene's samples about the centre of a detector sample, for whole
// ratios of pitch to sample. The tap at x weighs the sample x to the right of (below) the centre, so it is the point
// spread at -x:
//   K(x, y) = 1/M^2 sum over the corners of mtf/engines/fft/scene_spectrum.h of H(fx, fy) exp(-2 pi i (fx x + fy y)), M
//   = 2 kCells
// and taps let through sum K exp(2 pi i f.x), whose distance from H at the corners is their error. Positions are whole
// samples, or half ones where the ratio is even and centres lie between two samples.
//
// A two-dimensional kernel as a sum of products of one-dimensional ones, best in the least-squares sense (singular
// value decomposition; Eckart and Young, Psychometrika 1, 211 (1936)).

#include <vector>

#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/grid.h"
#include "mtf/otf/factored_otf.h"

namespace mtf {

/// Taps about the middle of a box: rows x columns, row-major.
struct TapBox {
  std::int64_t rows = 0, columns = 0;
  std::vector<double> value;
  double& at(std::int64_t r, std::int64_t c) { return value[static_cast<std::size_t>(r * columns + c)]; }
  double at(std::int64_t r, std::int64_t c) const { return value[static_cast<std::size_t>(r * columns + c)]; }
  double sum() const;
};

/// Whether taps with that share of the whole sum hold the point spread: at most a tenth lies beyond. Taps of a much
/// wider one appear compact, because corners do not show what turns between them.
inline bool holds_most_of_spread(double share) { return share >= 0.9 && share <= 1.1; }

class PointResponse {
 public:
  static constexpr std::int64_t kHalfWidth = 24;  ///< largest, in samples to each side

  PointResponse(const FactoredOtf& sampler, const SampleGrid& in, std::int64_t ratio_x, std::int64_t ratio_y);

  /// The taps at distances up to `half_x`, `half_y`: at most kHalfWidth, at least 1 where the ratio is even.
  TapBox box(std::int64_t half_x, std::int64_t half_y) const;
  /// |sum K exp(-2 pi i f.x) - H| at the corners.
  std::vector<double> error(const TapBox& taps) const;
  /// Largest |H| at the corners.
  double largest() const;
  /// By how much the error of taps at irregular frequencies exceeds half as much again as that at the corners of the
  /// cell there (`error`): more than nothing where H turns faster than corners can show, because the point spread is
  /// wider than 2 kCells samples.
  double excess(const TapBox& taps, std::span<const double> error) const;

 private:
  double offset_x_, offset_y_;             ///< 1/2 where taps lie between samples, else 0
  std::vector<Complex<double>> otf_;       ///< at the corners, kRows x kColumns
  std::vector<double> probe_x_, probe_y_;  ///< irregular frequencies, in cells
  std::vector<Complex<double>> probes_;    ///< H there, rows of y
  TapBox taps_;                            ///< all there are
};

/// One axis of an OTF that factors: the same, further out and finer.
class AxisResponse {
 public:
  static constexpr std::int64_t kHalfWidth = 96;

  /// H along `axis`, over H(0).
  AxisResponse(const FactoredOtf& sampler, Axis axis, double step_um, std::int64_t ratio);

  /// Taps at distances up to `half_width`, of unit sum.
  std::vector<double> taps(std::int64_t half_width) const;
  /// Their sum before that.
  double share(std::int64_t half_width) const;
  /// Largest |sum K exp - H| and largest |H| about each of the corners 0 .. kCells.
  std::vector<double> error(const std::vector<double>& taps) const;
  std::vector<double> modulus() const;
  /// As PointResponse::excess.
  double excess(const std::vector<double>& taps, std::span<const double> error) const;

 private:
  std::vector<double> raw_taps(std::int64_t half_width) const;

  double offset_;
  std::vector<Complex<double>> otf_;  ///< in transform order
  std::vector<double> probe_;
  std::vector<Complex<double>> probes_;
  std::vector<double> taps_;
};

/// value(r, c) = sum over k of along_y[k][r] x along_x[k][c], the largest terms first. Kernels that equal
/// their mirror images along both axes give terms that do so too, bit by bit.
struct SeparableTerms {
  std::vector<std::vector<double>> along_y, along_x;
};

/// The `most` largest terms.
SeparableTerms separable_terms(const TapBox& kernel, std::size_t most);

/// The kernel that the first `count` terms make.
TapBox product_of(const SeparableTerms& terms, std::size_t count);

}  // namespace mtf
