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
  double cycles = 0.0;
};
inline constexpr std::size_t kRangeTasks = 6;

inline std::array<RangeTask, kRangeTasks> range_tasks(const Conditions& c) {
  using radiometry::kN50;
  using radiometry::Psychometric;
  const double bars = radiometry::ratio_for_probability(Psychometric::johnson, radiometry::kTaskProbability);
  const double ttp = radiometry::ratio_for_probability(Psychometric::ttp_nvthermip, radiometry::kTaskProbability);
  return {{{Metric::johnson_detect, true, kN50[0] * bars},
           {Metric::johnson_recognise, true, kN50[1] * bars},
           {Metric::johnson_identify, true, kN50[2] * bars},
           {Metric::ttp_detect, false, c.v50_detect * ttp},
           {Metric::ttp_recognise, false, c.v50_recognise * ttp},
           {Metric::ttp_identify, false, c.v50_identify * ttp}}};
}

}  // namespace study
