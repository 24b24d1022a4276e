// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes the least-squares problem from what the caller gives: parameters are found in the sensor and checked, data
// without use are left out with a warning.

#include <memory>

#include "calib/fit/fit_problem.h"

namespace calib {

struct FitSetup {
  std::unique_ptr<Sensors> sensors;
  FitProblem problem;
  std::vector<double> start;  ///< starting values of the parameters
  std::vector<std::string> warnings;
  /// For each edge, curve and spot in order: its block, or none when it was left out.
  std::vector<std::optional<std::size_t>> block_of;
};

/// Throws UsageError as fit() does.
FitSetup make_setup(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options);

/// Starting points for further runs: a Halton sequence over the allowed ranges, or over what is plausible of them.
std::vector<double> other_start(std::span<const Variable> variables, int run);

}  // namespace calib
