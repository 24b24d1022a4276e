// SPDX-License-Identifier: Apache-2.0
#pragma once

// The least squares of a series by Ceres, in x = value / scale.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "calib/series/series_fit.h"

namespace calib {

inline constexpr double kDifference = 0.03;  ///< of the scale

struct SeriesProblem {
  std::vector<double> measured;                             ///< those that are there
  std::vector<std::size_t> place;                           ///< of each in the series
  std::vector<double> scale, lo, hi;                        ///< of x: value = scale x
  std::vector<std::optional<std::array<double, 2>>> prior;  ///< mean and sd of the values
  const SeriesModel* model = nullptr;
  SeriesFitOptions options;
  double weight = 1.0;  ///< of a residual: 1 / sd

  std::vector<double> x;
  int evaluations = 0;

  std::vector<double> values(std::span<const double> at) const;
  /// Residuals, model - measured without weight; absent where the model allows no such values.
  std::optional<Eigen::VectorXd> residuals(std::span<const double> at) const;
  /// Residuals and their derivatives by x; central differences of so much of the scale, one-sided at bounds.
  struct Linear {
    Eigen::VectorXd residual;
    Eigen::MatrixXd jacobian;
  };
  std::optional<Linear> linear(std::span<const double> at, double difference = kDifference);
  /// Of the weighted cost by x: J'r weight^2 and the priors' part.
  Eigen::VectorXd gradient(const Linear& linear) const;
};

struct SeriesMinimum {
  bool converged = false;
  int iterations = 0;
};

/// Minimises from x, and leaves the minimum there. Variables that end at a bound are held there while the others come
/// to their minimum.
SeriesMinimum minimise(SeriesProblem& problem);

}  // namespace calib
