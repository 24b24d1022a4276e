// SPDX-License-Identifier: Apache-2.0
#pragma once

// Timing of alternatives on a shared machine: every round runs each of them once, in turn, so that a slow second hits
// all alike; ratios of minima within one run are what counts. (Google Benchmark repeats one case in a block, or
// shuffles.)

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace bench {

struct Timing {
  double min_ms = 0.0;
  double median_ms = 0.0;
};

/// Rounds from the environment variable MTFKIT_BENCH_ROUNDS, else `rounds`. The first round is not counted.
inline std::vector<Timing> interleave(const std::vector<std::function<void()>>& cases, int rounds) {
  if (const char* wanted = std::getenv("MTFKIT_BENCH_ROUNDS")) rounds = std::max(1, std::atoi(wanted));
  std::vector<std::vector<double>> times(cases.size());
  for (int round = -1; round < rounds; ++round)
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const auto start = std::chrono::steady_clock::now();
      cases[i]();
      const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
      if (round >= 0) times[i].push_back(elapsed.count());
    }
  std::vector<Timing> result;
  for (auto& t : times) {
    std::sort(t.begin(), t.end());
    result.push_back({t.front(), t[t.size() / 2]});
  }
  return result;
}

}  // namespace bench
