// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pixels of an edge as residuals. At the signed distance d from the edge and (s, u) along and across it
//   pixel = D + (B - D) E(d),   D = dark + g1 s + g2 u,  B = dark + contrast + g3 s + g4 u
// The edge's own unknowns: offset along the normal (px), turn (rad), the curve's coefficients (px) or its curvature
// (1/px), dark, contrast, and where the data ask for them the four gradients (per half_length). A turn moves the
// curve along its normal at the foot point s by cos(phi) (s + g g'), an offset by cos(phi), a coefficient by cos(phi)
// (s / half_length)^k, with tan(phi) = g'(s) the slope of the curve there. The blur is that of the normal at the
// curve's origin: over a bend of phi the OTF differs by the square of phi.

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "calib/edge/pixel_correlation.h"
#include "calib/fit/data/data_block.h"
#include "calib/fit/fit.h"

namespace calib {

class EdgeBlock {
 public:
  explicit EdgeBlock(const EdgeData& data);

  /// Index of what it sees (Sensors::place); that of its condition unless it is set.
  std::size_t place() const { return place_; }
  void set_place(std::size_t place) { place_ = place; }
  const EdgeData& data() const { return *data_; }
  std::size_t pixels() const { return pixels_.size(); }
  /// A part of the pixels, so that no region takes unbounded memory.
  bool thinned() const { return thinned_; }
  double range_px() const { return range_px_; }
  bool gradients() const { return gradients_; }
  void use_gradients() { gradients_ = true; }
  void set_robust(bool robust) { robust_ = robust; }
  /// One pixel in so many are about `some`.
  std::size_t every_for(std::size_t some) const { return std::max<std::size_t>(1, pixels_.size() / some); }
  /// Makes normal() use one pixel in so many, which is enough to come close to the minimum.
  void thin_out(std::size_t every) { every_ = every; }
  /// Multiplies all noise variances.
  void scale_noise(double factor);
  /// The variance in use, divided by the variance that was given.
  double noise_scale() const { return noise_factor_ * noise_factor_; }

  std::vector<double> start() const;
  EdgeCurve curve(std::span<const double> own) const;
  std::size_t contrast_index() const { return 3 + curve_unknowns(); }

  /// Standard deviation of a pixel's noise half way up the edge.
  double middle_sd() const { return sd_at(0.5 * (data_->start.dark + data_->start.bright)); }

  /// Columns: own unknowns, parameters (as the sensors hold them).
  NormalMatrix normal(const Sensors& sensors, std::span<const double> own) const;
  /// The same with the gradients, whether they are in use or not; `own` without them.
  NormalMatrix normal_with_gradients(const Sensors& sensors, std::span<const double> own) const;
  /// J^T R J of the columns of normal(), where the pixels share their noise.
  Eigen::MatrixXd score_covariance(const Sensors& sensors, std::span<const double> own,
                                   const NoiseCorrelation& noise) const;
  /// The residuals without the Huber loss, for tests of adequacy. `own` is as normal() takes it.
  std::vector<Residual> residuals(const Sensors& sensors, std::span<const double> own, std::size_t every = 1) const;
  /// True when the weights depend on the fit: the noise grows with the signal, or the rounding is coarse against it.
  bool noise_follows() const;
  /// True when the noise is less than rounding leaves uncertain: the residuals are then rounding errors.
  bool rounds() const { return data_->start.noise_sd < 0.6 * data_->quantum; }
  /// True when the noise on a side is so small that neighbouring pixels round alike.
  bool rounding_hides_noise() const;
  /// Sets the weights from the fitted values and slopes.
  void update_noise(const Sensors& sensors, std::span<const double> own);

 private:
  struct Pixel {
    std::int32_t x = 0, y = 0;
    double value = 0.0;
    double sd = 1.0;
  };
  /// How d at a pixel follows the curve's unknowns: times cos(phi), see above.
  struct Place {
    double distance = 0.0, along = 0.0, across = 0.0;
    double by_offset = -1.0, by_turn = 0.0;
    double scale = 1.0;  ///< cos(phi)
  };
  static Place place_of(const EdgeCurve& curve, Point normal, const Pixel& pixel);
  /// `near`: the place along the edge from where the foot point is searched.
  static Place on_curve(const EdgeCurve& curve, double across, double along, double near);
  /// The places of all pixels on a curve that is not straight, kept for the next pass at the same point.
  const std::vector<Place>& places(std::span<const double> own) const;
  bool keeps_places() const;
  std::size_t curve_unknowns() const;
  bool rounds_coarsely() const;
  const StepResponse& response(const Sensors& sensors, const EdgeCurve& curve) const;
  /// The rows of C = [J r], given to a new NormalMatrix or PixelRows.
  template <class Rows>
  Rows rows_of(const Sensors& sensors, std::span<const double> own, bool gradients) const;
  double sd_at(double value) const;

  const EdgeData* data_;
  std::size_t place_;
  bool robust_ = false;
  std::size_t every_ = 1;
  bool gradients_ = false;
  double noise_factor_ = 1.0;  // factor on the sd
  double range_px_ = 0.0;
  bool thinned_ = false;
  double alike_ = 0.0;  // along the pixels' grid: the share of rounding that pixels at one distance have in common
  std::vector<Pixel> pixels_;

  // The last table, for the next pass over the pixels at the same point. A block belongs to one thread at a time.
  struct Kept {
    const Sensors* sensors = nullptr;
    std::size_t version = 0;
    double angle_rad = 0.0;
    bool turns = false;  // the table's last function is the derivative by the angle
    std::optional<StepResponse> step;
  };
  mutable Kept kept_;
  mutable std::vector<double> placed_for_;
  mutable std::vector<Place> places_;
};

// The covariance of the scores J^T r of a set of pixels. That of independent pixels is J^T J, residuals and derivatives
// in standard deviations of the noise. Where neighbouring pixels share their noise it is J^T R J, R the correlation of
// the pixels: the sum over the lags of the products of each row of J with that of the pixel at the lag. The covariance
// of the solution is then the sandwich (J^T J)^-1 J^T R J (J^T J)^-1 (H. White, Econometrica 48, 817 (1980)).

struct PixelPlace {
  std::int32_t x = 0, y = 0;
  auto operator<=>(const PixelPlace& other) const = default;
};

/// The rows of C = [J r], one a pixel, where all of them are needed at once; filled as a NormalMatrix is.
class PixelRows {
 public:
  explicit PixelRows(std::size_t unknowns) : columns_(unknowns + 1) {}
  std::span<double> next() {
    values_.resize(values_.size() + columns_);
    return std::span(values_).last(columns_);
  }
  void add() {}

  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// All rows of J.
  auto jacobian() const {
    const auto columns = static_cast<Eigen::Index>(columns_);
    return Eigen::Map<const Matrix>(values_.data(), std::ssize(values_) / columns, columns).leftCols(columns - 1);
  }

 private:
  std::size_t columns_;
  std::vector<double> values_;
};

/// J^T R J. `places`: of the rows, row by row of the image and from left to right.
Eigen::MatrixXd score_covariance(const PixelRows& rows, std::span<const PixelPlace> places,
                                 const NoiseCorrelation& noise);

}  // namespace calib
