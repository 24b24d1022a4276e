// SPDX-License-Identifier: Apache-2.0
#pragma once

// Every decade of tolerance from 1e-1 to 1e-7: the plan that is chosen, every other method that keeps the tolerance,
// and plain OpenCV; each is run once and compared with the exact image.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/bench_job.h"
#include "apps/terminal/progress_line.h"

namespace apps {

inline constexpr std::array kTolerances{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7};

/// One contender at one tolerance. The same contender may appear at several.
struct ToleranceRun {
  double tolerance = 0.0;
  std::optional<std::size_t> contender;  ///< none where no plan keeps the tolerance
  bool chosen = false;
  std::optional<double> promised, plan_ms;  ///< none for OpenCV
  double reachable = 0.0;                   ///< where no plan keeps the tolerance
};

struct ToleranceRuns {
  std::vector<Contender> contenders;
  std::vector<ToleranceRun> runs;
  std::vector<std::string> notes;  ///< what was left out, and why
};

/// `slowest_ms`: methods whose predicted cost is above it are left out, unless they are chosen. `out` is where all
/// images go, the size of job.out.
ToleranceRuns run_tolerances(const BenchJob& job, mtf::ImageView<float> out, double slowest_ms, ProgressLine& progress);

}  // namespace apps
