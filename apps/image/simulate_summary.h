// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf simulate` prints of a run.

#include <string>

#include "apps/simulate/simulate.h"

namespace apps {

/// The lines that it ends with: size and unit, statistics of the channels, predicted error, time.
std::string summary_text(const SimulateResult& result);

/// What --explain prints: the plan, after lines that say of how much it is the plan.
std::string explain_text(const RunReport& report);

}  // namespace apps
