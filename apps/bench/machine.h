// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace apps {

/// What a run time depends on.
struct Machine {
  std::string cpu;                ///< as the system names it, "" when it does not
  int cores = 0;                  ///< usable
  std::int64_t memory_bytes = 0;  ///< usable
};

Machine this_machine();

}  // namespace apps
