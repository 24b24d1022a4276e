// SPDX-License-Identifier: Apache-2.0
#pragma once

// Factors of an OTF as tables, which are refined until interpolation keeps a target.

#include <array>
#include <complex>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mtf/engines/fft/parity.h"
#include "mtf/frame.h"

namespace mtf {

/// A function of |f| as a table, linear between dense knots: used to evaluate radial OTF factors at millions of
/// grid points. The function is sampled exactly on a coarse grid that is doubled until cubic interpolation reproduces
/// the new midpoints within the target; the dense knots come from those cubics.
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

/// A Hermitian function of a frequency vector as a table in polar coordinates, for OTFs that cost microseconds a sample
/// (aberrated pupils). Around, a Fourier series, H(r, a) = sum over m of c_m(r) exp(i m a); outwards, Chebyshev points
/// between the radii where the function has kinks, taken in a variable that is the square root of the distance at both
/// ends of each piece, where pupil edges that touch and the cutoff have their half-integer powers. Both converge
/// geometrically; they are refined until points in between come out within the target.
class PolarTable {
 public:
  using Function = std::function<Complex<double>(const Freq<double>& f)>;
  /// rows[i spokes/2 + m] = c_m at the radius r[i], from `spokes` directions, m < spokes/2. Returns how many values of
  /// an OTF that took.
  using Rings =
      std::function<std::int64_t(std::span<const double> r, std::size_t spokes, std::span<std::complex<double>> rows)>;
  /// The series of a function that is evaluated on `threads` (0 = all cores); of a `radial` one in one direction.
  static Rings rings_of(Function h, int threads, bool radial = false);

  /// `breaks`: radii in rising order between which H is smooth, the last being the table's end; beyond it H is 0.
  /// The table is refined until it meets the target at points in between, or until the next step would take more than
  /// `most` values of an OTF in all; `threads` evaluate `h` (0 = all cores).
  PolarTable(const Function& h, const Rings& rings, std::vector<double> breaks, double target, std::int64_t most,
             int threads);

  /// Sum of tables whose orders m are multiplied by weight[i][m]; what it errs by its maker has to know: error() is 0.
  /// All are made with the same breaks. Weights exp(-i m angle) turn a table from +x to +y.
  static PolarTable combination(std::span<const PolarTable* const> tables,
                                std::span<const std::vector<std::complex<double>>> weight);
  /// The parts of H that are among these, as a table of their sum.
  PolarTable parts(const Parities& wanted) const;
  std::size_t orders() const { return orders_; }

  Complex<double> at(const Freq<double>& f) const;
  /// ee, eo, oe and oo at f, in the order of kOtfParts; the imaginary ones as real numbers.
  std::array<double, 4> parts_at(const Freq<double>& f) const;
  /// h[i] *= table at (fx[i], fy).
  void multiply(std::span<const double> fx, double fy, std::span<Complex<double>> h) const;

  /// Largest |table - H| found at points in between, times 2; also where the target could not be kept.
  double error() const { return error_; }
  std::int64_t bytes() const;
  /// The number of values of an OTF that were taken.
  std::int64_t evaluations() const { return evaluations_; }

 private:
  /// Coefficients in rows, one for each knot: uniform in the variable of the piece, one more beyond either end for the
  /// cubic through four of them. A row has the real parts of c_0 .. c_(orders-1), filled up with zeros, then the
  /// imaginary ones, where there are any of either.
  struct Piece {
    double begin = 0.0, end = 0.0;
    std::vector<double> rows;
  };
  PolarTable() = default;
  void set_orders(std::size_t orders);
  std::size_t row_size() const { return (cosines_ ? width_ : 0) + (sines_ ? width_ : 0); }
  void tabulate(const Rings& rings, std::size_t spokes, std::size_t points);
  std::size_t probes() const;  ///< number for each piece and each kind
  double probe(const Function& h, std::size_t spokes, std::size_t points, bool around, int threads);

  std::vector<Piece> pieces_;
  std::size_t orders_ = 0, width_ = 0;
  std::size_t first_ = 0, step_ = 1;    ///< orders are first, first + step, ...
  bool cosines_ = true, sines_ = true;  ///< whether there are real and imaginary parts
  double error_ = 0.0;
  std::int64_t evaluations_ = 0;
};

}  // namespace mtf
