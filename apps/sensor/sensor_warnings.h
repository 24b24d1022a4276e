// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where components and tables of one sensor file state the same thing of the detector, and may not agree.

#include <vector>

#include "mtf/io/config/config.h"

namespace apps {

/// Warnings, as such a pair can be meant; notes where both ways are usual.
std::vector<mtf::io::Diagnostic> chain_warnings(const mtf::io::SensorConfig& config);

}  // namespace apps
