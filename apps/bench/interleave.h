// SPDX-License-Identifier: Apache-2.0
#pragma once

// Timing of alternatives on a shared machine: every round runs each of them once, in turn, so that a slow second hits
// all alike; ratios of minima within one run are what counts.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <vector>

#include "mtf/work/stopwatch.h"

namespace apps {

struct Timing {
  double min_ms = 0.0;
  double median_ms = 0.0;
  int runs = 0;
};

struct InterleaveOptions {
  int rounds = 15;
  /// For all runs together, about. Each case may use an equal part of what is left: one that is too slow for every
  /// round is run less often, its runs spread over the rounds, once at the least.
  double seconds = std::numeric_limits<double>::infinity();
  std::function<void(double share_done)> progress{};  ///< called between runs
};

namespace detail {

inline double run_ms(const std::function<void()>& work) {
  const mtf::Stopwatch watch;
  work();
  return watch.ms();
}

// Runs that fit: the quick ones take what they need, the others share the rest alike.
inline std::vector<int> runs_within(const std::vector<double>& once_ms, int rounds, double budget_ms) {
  std::vector<std::size_t> order(once_ms.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return once_ms[a] < once_ms[b]; });
  std::vector<int> runs(once_ms.size(), rounds);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const double once = once_ms[order[i]];
    const double share = budget_ms / static_cast<double>(order.size() - i);
    if (once * rounds > share) runs[order[i]] = std::max(1, static_cast<int>(std::floor(share / once)));
    budget_ms = std::max(0.0, budget_ms - once * runs[order[i]]);
  }
  return runs;
}

}  // namespace detail

/// One timing a case, in order. A round before the first is not counted.
inline std::vector<Timing> interleave(const std::vector<std::function<void()>>& cases,
                                      const InterleaveOptions& options) {
  std::vector<double> once;
  for (const auto& work : cases) {
    once.push_back(detail::run_ms(work));
    if (options.progress) options.progress(0.0);
  }
  const int rounds = std::max(1, options.rounds);
  const double warmup = std::accumulate(once.begin(), once.end(), 0.0);
  const std::vector<int> runs = detail::runs_within(once, rounds, 1e3 * options.seconds - warmup);
  double total = 0.0, done = 0.0;
  for (std::size_t i = 0; i < cases.size(); ++i) total += once[i] * runs[i];
  std::vector<std::vector<double>> times(cases.size());
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < cases.size(); ++i) {
      // `runs` of the `rounds`, evenly spread.
      if ((round + 1) * runs[i] / rounds == round * runs[i] / rounds) continue;
      times[i].push_back(detail::run_ms(cases[i]));
      done += once[i];
      if (options.progress && total > 0.0) options.progress(done / total);
    }
  if (options.progress) options.progress(1.0);
  std::vector<Timing> result;
  for (auto& t : times) {
    std::sort(t.begin(), t.end());
    result.push_back({t.front(), t[t.size() / 2], static_cast<int>(t.size())});
  }
  return result;
}

}  // namespace apps
