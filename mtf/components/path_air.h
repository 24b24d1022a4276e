// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which systems count with System::air.

#include "mtf/system.h"

namespace mtf {

/// True where a component takes its path from System::air because it states none of its own.
bool takes_path_air(const System<double>& system);

}  // namespace mtf
