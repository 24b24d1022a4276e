// SPDX-License-Identifier: Apache-2.0
#pragma once

// How ranges and probabilities against range are shown.

#include <string>

#include "apps/figures/plot.h"
#include "apps/study/task_ranges.h"
#include "mtf/io/config/config.h"

namespace apps {

/// The ranges, what they hold for, the probabilities.
std::string range_table(const study::Acquisition& found, const radiometry::Conditions& conditions);
/// A line a range of the probabilities: range_m, then for each task its probability, error and standard deviation.
std::string range_csv(const study::Acquisition& found);
std::string range_json(const study::Acquisition& found, const radiometry::Conditions& conditions,
                       const mtf::io::SensorConfig& sensor);
/// Probability against range of all tasks, with bands of two standard deviations where the sensor file states some.
Figure range_figure(const study::Acquisition& found, const std::string& title);

}  // namespace apps
