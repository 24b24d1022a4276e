// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which components of the path follow System::air, and which state a path of their own.

#include <string>

#include "mtf/system.h"

namespace mtf {

/// True where a component takes its path from System::air because it states none of its own.
bool takes_path_air(const System<double>& system);

/// The label of the first component whose path stays what it is when System::air changes; "" where there is none.
std::string own_path(const System<double>& system);

}  // namespace mtf
