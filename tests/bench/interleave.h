// SPDX-License-Identifier: Apache-2.0
#pragma once

// apps/bench/interleave.h for the benchmark programs: rounds from the environment. (Google Benchmark repeats one case
// in a block, or shuffles.)

#include <algorithm>
#include <cstdlib>

#include "apps/bench/interleave.h"

namespace bench {

/// Rounds from the environment variable MTFKIT_BENCH_ROUNDS, else `rounds`. The first round is not counted.
inline std::vector<apps::Timing> interleave(const std::vector<std::function<void()>>& cases, int rounds) {
  if (const char* wanted = std::getenv("MTFKIT_BENCH_ROUNDS")) rounds = std::max(1, std::atoi(wanted));
  return apps::interleave(cases, {.rounds = rounds});
}

}  // namespace bench
