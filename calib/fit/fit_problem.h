// SPDX-License-Identifier: Apache-2.0
#pragma once

// The least-squares problem of a fit, and its solution by Ceres: shared variables x, the unknowns of each set of data,
// priors as residuals. Sets of data are evaluated in parallel and enter as their triangular factors (dense.h),
// so that Ceres itself works on a dozen residuals each, in one thread: the result has the same bits for any number of
// threads.

#include <functional>
#include <optional>
#include <variant>

#include "calib/fit/data/curve_block.h"
#include "calib/fit/data/edge_block.h"
#include "calib/fit/data/spot_block.h"
#include "calib/fit/variables.h"

namespace calib {

using Block = std::variant<EdgeBlock, CurveBlock, SpotBlock>;

/// Values of all unknowns.
struct FitPoint {
  std::vector<double> x;
  std::vector<std::vector<double>> own;  ///< of every block
};

struct FitProblem {
  Sensors* sensors = nullptr;
  std::vector<Variable> variables;
  std::vector<std::optional<std::array<double, 2>>> priors;  ///< mean and sd, of every parameter
  std::vector<Block> blocks;
  int threads = 0;

  std::vector<double> x;                 ///< present values
  std::vector<std::vector<double>> own;  ///< own unknowns of every block

  FitPoint here() const { return {x, own}; }
  /// Sets the sensors to x; returns false when they do not allow it.
  bool apply() const { return sensors->set(values_at(variables, x)); }
  bool go_to(const FitPoint& point) {
    x = point.x;
    own = point.own;
    return apply();
  }
  /// Of a block, at the present values; of an edge one pixel in so many.
  std::vector<Residual> residuals(std::size_t block, std::size_t every = 1) const;
  /// C^T C of every block at the present values, columns: own, x, residual. Apply first. `gradients`: the
  /// columns of an edge's gradients follow its own unknowns also where they are not fitted.
  std::vector<Eigen::MatrixXd> normals(bool gradients = false) const;
  /// The covariance of the scores of each block, by what its pixels share of their noise (edge_block.h), columns as
  /// in normals() without the residual; an empty matrix for a block whose pixels are independent.
  std::vector<Eigen::MatrixXd> score_covariances(std::span<const NoiseCorrelation> noise) const;
};

struct Solution {
  bool converged = false;
  bool stopped = false;
  double cost = 0.0;  ///< at x
  int iterations = 0;
  int agreeing = 1;      ///< number of runs that ended at this minimum
  bool cut_off = false;  ///< a direction has gone round as often as it may, and stands where that ends
};

/// Minimises from the present values and leaves the minimum in x and own, with the sensors set to it. The variable
/// `fixed` keeps its value. `go_on` is called after every iteration. `tolerance`: relative change of the cost that ends
/// it.
struct SolveOptions {
  std::optional<std::size_t> fixed{};
  std::function<bool()> go_on{};
  /// Relative to half the number of pixels: the last step was less than a hundredth of a standard deviation for each
  /// 10000 of them.
  double tolerance = 1e-8;
};
Solution solve(FitProblem& problem, const SolveOptions& options = {});

}  // namespace calib
