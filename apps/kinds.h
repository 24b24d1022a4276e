// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace apps {

/// The component of that kind ("" = every one), as its field table tells it: what it is, the lists it may stand in, and
/// each parameter with its range, whether it is needed, and an example. Throws UsageError for an unknown kind.
std::string describe_kinds(const std::string& kind);

}  // namespace apps
