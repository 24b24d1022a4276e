// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the observers, target and air of a study are, in words, for every output of its ranges.

#include <string>
#include <vector>

#include "apps/study/study.h"

namespace study {

/// Why [conditions] extinction cannot stand beside the air of a sensor file, "" where that has none.
std::string extinction_problem(const mtf::io::SensorConfig& sensor);

/// Empty for a study without figures of light, quality or observers. A magnification by a display is that of the
/// study's first sensor.
std::vector<std::string> condition_lines(const Study& study);

}  // namespace study
