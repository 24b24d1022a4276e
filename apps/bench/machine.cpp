// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/machine.h"

#include <fstream>
#include <thread>

#include "mtf/work/usable_memory.h"

namespace apps {

Machine this_machine() {
  Machine machine;
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; machine.cpu.empty() && std::getline(info, line);)
    if (line.starts_with("model name") && line.find(": ") != std::string::npos)
      machine.cpu = line.substr(line.find(": ") + 2);
  machine.cores = static_cast<int>(std::thread::hardware_concurrency());
  machine.memory_bytes = static_cast<std::int64_t>(mtf::usable_bytes());
  return machine;
}

}  // namespace apps
