// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rows of `mtf budget`, for the command and the live view.

#include <vector>

#include "apps/sensor/sensor_chain.h"

namespace apps {

struct BudgetTable {
  radiometry::Budget<double> budget;
  std::vector<radiometry::BudgetRow> rows;  ///< of the chain, of the observer, and of the path where there is one
};

/// For a pixel on the axis that images a surface of that temperature. Throws UsageError with file, line and key as
/// radiometry::budget_of.
BudgetTable budget_table(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, double temperature_k);

}  // namespace apps
