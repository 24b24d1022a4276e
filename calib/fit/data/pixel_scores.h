// SPDX-License-Identifier: Apache-2.0
#pragma once

// The covariance of the scores J^T r of a set of pixels. That of independent pixels is J^T J, residuals and derivatives
// in standard deviations of the noise. Where neighbouring pixels share their noise it is J^T R J, R the correlation of
// the pixels: the sum over the lags of the products of each row of J with that of the pixel at the lag. The covariance
// of the solution is then the sandwich (J^T J)^-1 J^T R J (J^T J)^-1 (H. White, Econometrica 48, 817 (1980)).

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "calib/edge/pixel_correlation.h"

namespace calib {

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
