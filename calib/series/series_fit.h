// SPDX-License-Identifier: Apache-2.0
#pragma once

// A few numbers of a model fitted to a measured series: one quantity at equal steps of time, some values missing.
//
//   minimise  sum_i (model_i(x) - measured_i)^2 / sd^2 + sum_k (x_k - mean_k)^2 / sd_k^2 (priors),  lo <= x <= hi
//
// by Ceres' trust region; derivatives by central differences of the model. The residuals of a physical model are no
// independent noise: what the model leaves out lasts for hours. So they are taken as a first-order autoregressive
// series, correlation phi^|i - j|, whose phi and variance are those at which the expected sums of r_i^2 and
// r_i r_(i+1), after the fit has taken away what it can, are the observed ones. The covariance is the sandwich
// (J'J)^-1 J'RJ (J'J)^-1 of it. What the data do not determine is found and said as in calib/fit. An error that the
// model makes at each hour of every day is in no standard error.

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "calib/fit/fit.h"

namespace calib {

struct Series {
  std::vector<double> measured;  ///< NaN: missing
  std::optional<double> sd{};    ///< of a value, independent of the others; absent: from the residuals
};

struct SeriesParameter {
  FitParameter parameter;
  double start = 0.0;
  double lo = 0.0, hi = 0.0;  ///< what the model allows, beside the bounds of the parameter
  double scale = 0.0;  ///< a change that matters; 0 for a size, such as a conductivity, whose own value is its scale
};

/// The model at the times of the series for values of the parameters; empty where they allow none. It is called from
/// several threads at once.
using SeriesModel = std::function<std::vector<double>(std::span<const double> values)>;

struct SeriesFitOptions {
  int threads = 0;  ///< 0 = all cores
  std::function<void(int evaluations)> progress{};
};

/// How well a model agrees with the series.
struct SeriesResidual {
  std::vector<double> model;
  double rms = 0.0, worst = 0.0;
};

struct SeriesFit {
  FitStatus status = FitStatus::not_converged;
  std::string reason;
  std::vector<std::string> warnings;
  std::vector<FittedParameter> parameters;
  std::vector<std::vector<double>> correlation;
  std::vector<NullDirection> not_separable;
  std::size_t count = 0;            ///< values that are there
  SeriesResidual before, after;     ///< at the starting values; fitted
  double sd = 0.0;                  ///< of one residual, degrees of freedom counted
  double phi = 0.0;                 ///< correlation of neighbouring residuals
  double independent_values = 0.0;  ///< count (1 - phi) / (1 + phi)
  double chi2_per_dof = 0.0;        ///< against Series::sd; 1 where none is stated
  int iterations = 0, evaluations = 0;

  bool fitted() const { return status == FitStatus::converged || status == FitStatus::converged_model_wrong; }
};

/// Data never throw: the status says what went wrong. Throws UsageError for no parameters, more of them than values,
/// bounds that leave no value, and a start for which the model is empty.
SeriesFit fit_series(const Series& series, std::span<const SeriesParameter> parameters, const SeriesModel& model,
                     const SeriesFitOptions& options = {});

}  // namespace calib
