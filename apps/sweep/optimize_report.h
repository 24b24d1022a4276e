// SPDX-License-Identifier: Apache-2.0
#pragma once

// The results of `mtf optimize`, for people and as JSON.

#include <string>
#include <vector>

#include "apps/study/optimum/optimize.h"

namespace apps {

/// One optimisation of a study.
struct OptimizedGoal {
  std::string name;  ///< "maximize niirs_giqe5", "1 x maximize niirs_giqe5 + 0.2 x minimize cost"
  study::OptimizeOptions options;
  study::OptimizeOutcome outcome;
  std::string file;  ///< of the sensor that was written; "" = none
};

std::string optimize_table(const study::Study& study, const std::vector<OptimizedGoal>& goals);
std::string optimize_json(const study::Study& study, const std::vector<OptimizedGoal>& goals);

/// "optimal", "stopped", "infeasible" or "impossible".
std::string status_name(study::OptimizeOutcome::Status status);

}  // namespace apps
