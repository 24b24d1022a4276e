// SPDX-License-Identifier: Apache-2.0
#pragma once

// The tasks whose ranges are metrics.

#include <array>

#include "apps/study/design/metric_rows.h"
#include "radiometry/performance/acquisition.h"
#include "radiometry/performance/conditions.h"

namespace study {

using radiometry::Conditions;

/// A task: its metric, how it is judged, and the cycles on target that it needs.
struct RangeTask {
  Metric metric;
  bool by_bars = false;  ///< Johnson's criteria, else TTP
  double half = 0.0;     ///< for half of the trials: N50 or V50
  double cycles = 0.0;   ///< for [conditions] probability

  radiometry::Psychometric law() const {
    return by_bars ? radiometry::Psychometric::johnson : radiometry::Psychometric::ttp_nvthermip;
  }
};
inline constexpr std::size_t kRangeTasks = 6;

inline std::array<RangeTask, kRangeTasks> range_tasks(const Conditions& c) {
  using radiometry::kN50;
  std::array<RangeTask, kRangeTasks> tasks{{{Metric::johnson_detect, true, kN50[0]},
                                            {Metric::johnson_recognise, true, kN50[1]},
                                            {Metric::johnson_identify, true, kN50[2]},
                                            {Metric::ttp_detect, false, c.v50_detect},
                                            {Metric::ttp_recognise, false, c.v50_recognise},
                                            {Metric::ttp_identify, false, c.v50_identify}}};
  for (RangeTask& task : tasks) task.cycles = task.half * radiometry::ratio_for_probability(task.law(), c.probability);
  return tasks;
}

}  // namespace study
