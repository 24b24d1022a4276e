// SPDX-License-Identifier: Apache-2.0
#pragma once

// How much memory the process may use: the least of the machine's, of what `ulimit -v` leaves (RLIMIT_AS, less what is
// mapped already), and of the limits of all control groups that the process is in, which are those of a container or a
// batch job (cgroup v2: memory.max, v1: memory.limit_in_bytes). Sizes are compared with it before anything is taken.

#include <string>

namespace mtf {

struct UsableMemory {
  double bytes = 0.0;
  const char* whose = "";  ///< "the machine has", "ulimit -v leaves" or "the container has"
};

UsableMemory usable_memory();

/// usable_memory().bytes
double usable_bytes();

/// The least limit of these groups, the text of /proc/self/cgroup, and of those around them; infinity where there is
/// none. `root`: where groups are mounted, /sys/fs/cgroup.
double group_limit_bytes(const std::string& groups, const std::string& root);

}  // namespace mtf
