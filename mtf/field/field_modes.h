// SPDX-License-Identifier: Apache-2.0
#pragma once

// The presample OTF of a system that changes over the image, as a sum of a few OTFs with weights that are smooth over
// the image:
//   H(f; q) = C(f) E(f; q),    E(f; q) ~ P_0(f) + sum over k of w_k(q) P_k(f)
// C is the product of the components that are the same everywhere, E that of the others (with all chromatic ones where
// a chromatic one is among them, as a band averages their product). P_0 is the mean of E over the image; P_k(0) = 0, so
// uniform scenes stay exact with any number of modes. OTFs are made at Chebyshev points of the image, and the modes are
// the singular vectors of their deviations from the mean, weighted with the power of the scene where that is known
// (Flicker & Rigaut, JOSA A 22, 504 (2005), for modes of a measured point spread), taken apart for each part of E by
// parity along x and y (mtf/engines/fft/parity.h): such a mode takes one inverse transform of a mirrored scene.
//
// The promise. Of a residual D(f; x) = sum of a_k(x) p_k(f), for any c_k > 0, Cauchy-Schwarz at each pixel and Parseval
// give rms(error)^2 <= max over x of sum a_k^2 / c_k times sum over f of power(f) sum c_k |p_k|^2. With modes scaled so
// that max |a_k| = 1 the least of c = 1, 1 / |p_k| and 1 / |p_k|^2 is taken. What one part filters of a mirrored canvas
// has a modulus as symmetric as the canvas, so that nothing of it can concentrate in the image: where C has one part,
// the bound for mirrored scenes is half of that of any error. What interpolation between the points
// misses is looked at in other places of the image. Weights are polynomials over the image, but where a lens about its
// axis has kinks along the radius (radial_weights.h).

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "mtf/field/weight_axis.h"
#include "mtf/grid.h"
#include "mtf/otf/factored_otf.h"

namespace mtf {

/// Width and height of the detector: of the frame's format, else of the grid.
std::array<double, 2> detector_um(const Frame<double>& frame, const SampleGrid& detector);

struct FieldModesOptions {
  SceneAperture aperture{};
  double table_error = 1e-7;  ///< that the table of one OTF should keep
  double band_error = 1e-7;   ///< of its average over the band
  double worst_unit = 1.0;    ///< rms error, relative to the scene's std, that an OTF error of 1 may become
  const SceneSpectrum* spectrum = nullptr;  ///< of the scene; null: any scene
  double spectrum_gain = 1.0;               ///< rms error of the image over that of the spectrum
  double part_gain = 1.0;  ///< factor on both for an error of one parity, whose square is as symmetric as the canvas
  double enough = 0.0;     ///< an rms error for which no more points are taken
  double reach = 1.0;      ///< OTFs are wanted up to that many times the scene's Nyquist frequencies
  bool line = false;       ///< of one parameter alone, which the x of the field stands for: points along one row
  int threads = 0;
  OtfProgress progress = {};
};

class FieldTables;

class FieldModes {
 public:
  /// Throws UsageError where the size of the detector is not known and cannot be told from `out`.
  FieldModes(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
             const FieldModesOptions& options);

  /// Number of modes besides the mean.
  std::size_t count() const { return factors_.size() - 1; }
  /// rms error relative to the scene's std, at most, when only the first `modes` are taken; with all of them what
  /// interpolation over the image misses.
  double error(std::size_t modes) const { return error_.at(modes) + between_; }
  /// The same when the OTF of the optical axis serves all pixels.
  double error_of_axis() const { return axis_error_ + between_; }
  /// The part of it that is of the average over the band.
  double band_error() const { return band_; }
  /// By how much a weight may be wrong by rounding.
  double weight_rounding() const { return 0x1p-22 * static_cast<double>(n_); }
  /// Places of the image at which OTFs were made.
  std::size_t points() const { return points_; }

  /// In place of the components that change: mode 0 is the mean, whose weight is 1; weights of the others are within
  /// -1 .. 1.
  std::shared_ptr<const GivenFactor> factor(std::size_t mode) const { return factors_.at(mode); }
  /// Adds to row y of the image, from column x on, what mode 1 .. count() filtered, times its weights.
  void add(std::size_t mode, std::int64_t y, std::int64_t x, std::span<const float> filtered, float* image) const;

  /// A bound for what tiles leave of modes 1 .. count() (tile_modes.h): where the weights that are left at a pixel are
  /// b_k, the error is at most `rms` times the largest root of sum (scale_k b_k)^2 over the image.
  struct Measure {
    std::vector<double> scale;
    double rms = 0.0;
  };
  const std::vector<Measure>& measures() const { return measures_; }
  /// Whether OTFs have kinks over the image, where weights are no polynomials, and there is no series.
  bool has_kinks() const { return grid_x_.nodes() > 0; }
  /// The weight of a mode as a Chebyshev series, [y][x] of as many terms each as this (of a line along x alone); its
  /// variables are
  std::size_t terms() const { return n_; }
  const std::vector<double>& series(std::size_t mode) const { return series_.at(mode - 1); }
  /// the places of pixels, -1 .. 1.
  double place_x(double pixel) const { return x_.place(pixel); }
  double place_y(double pixel) const { return y_.place(pixel); }

  // What its making goes by.
  struct Frequencies;
  struct Rms;
  struct Mode;

 private:
  struct Line {
    double first = 0.0, step = 0.0;  ///< field coordinate of the first pixel, and from one to the next
    std::int64_t count = 0;
    double last() const { return first + step * static_cast<double>(count - 1); }
    /// Pixel i as a place in -1 .. 1, and the field coordinate of a place.
    double place_of(double q) const { return count > 1 ? (2.0 * q - first - last()) / (last() - first) : 0.0; }
    double pixel(double t) const { return 0.5 * (1.0 + t) * static_cast<double>(count - 1); }
    double place(double i) const { return count > 1 ? 2.0 * i / static_cast<double>(count - 1) - 1.0 : 0.0; }
    double at(double t) const { return 0.5 * ((1.0 - t) * first + (1.0 + t) * last()); }  // t in -1 .. 1
  };
  /// Those at which OTFs are made with n points along an axis: the points, places between them, and the optical axis.
  std::vector<FieldPoint<double>> places(std::size_t n, std::size_t rows) const;
  std::vector<float> grid_row(std::span<const float> values, double y) const;
  void project(std::vector<Mode>& modes, const FieldTables& tables, const Frequencies& at,
               std::span<const std::ptrdiff_t> some, int threads) const;
  bool make(FieldTables& tables, const Frequencies& at, const Rms& rms, std::size_t n, bool last);

  Line x_, y_;
  std::size_t n_ = 0, points_ = 0;  ///< points along an axis
  std::vector<std::shared_ptr<const GivenFactor>> factors_;
  std::vector<Measure> measures_;
  std::vector<std::vector<double>> series_;
  std::vector<std::array<double, 2>> probes_;  ///< places in -1 .. 1 that are looked at
  WeightAxis grid_x_, grid_y_;                 ///< where there are kinks: nodes of the weights,
  std::vector<WeightAxis::Cubic> columns_;     ///< and each column of the image between them
  std::vector<std::vector<float>> rows_;  ///< of each weight, its nodes or for each row Chebyshev coefficients along x
  std::vector<float> along_x_;            ///< the polynomials at the pixels of a row, one after the other
  std::vector<double> error_;
  double axis_error_ = 0.0, between_ = 0.0, band_ = 0.0;
};

/// The system whose field points are measured with the detector of its format or, without one, of that grid.
System<double> with_field_radius(System<double> system, const SampleGrid& out);

}  // namespace mtf
