// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far one sensor detects, recognises and identifies a target: the range of each task, and its probability against
// range, by TTP and by Johnson's criteria (radiometry/performance/target_at_range.h), with the air up to each range.
//   P(R) = law(cycles resolved on the target at R / cycles that half of the trials need)
// The ranges are the metrics of studies, from the same solver.
//
// What is uncertain:
//   error  of the numbers: of the root, the OTF and the light along the range, each worse by what it may err
//   sd     of what the sensor file states: each number that it writes as { value, stderr } or { value, interval } is
//   moved by its standard
//          deviation to both sides; half of the difference counts, and the numbers are taken as independent
// How well a model describes observers is in neither.

#include <array>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "apps/study/design/metric_rows.h"
#include "mtf/io/config/config.h"
#include "radiometry/performance/conditions.h"

namespace study {

/// A task by one of the models. Lengths in m.
struct TaskRange {
  std::string metric, task, model;  ///< "ttp_range_detect", "detect", "ttp"
  double half = 0.0;                ///< cycles on target that half of the trials need: V50 or N50
  double range_m = std::numeric_limits<double>::quiet_NaN();  ///< 0: the task succeeds nowhere
  double error_m = 0.0;
  double sd_m = 0.0;         ///< NaN where a number that was moved has no range
  bool at_nyquist = false;   ///< limited by the Nyquist frequency, not by contrast
  bool fills_field = false;  ///< the target is wider there than the field of view
  std::string reason{};      ///< why there is no range; "" where there is
  /// Against Acquisition::range_m; NaN where a model refuses the range, empty where it refuses the sensor.
  std::vector<double> probability{}, probability_error{}, probability_sd{};
};

/// A number of the sensor file with a standard deviation.
struct StatedNumber {
  std::string path, unit;
  double value = 0.0, sd = 0.0;
  std::array<double, kRangeTasks> moves_m{};  ///< half of the difference of each range
  std::string problem{};                      ///< why it could not be moved; "" where it was
};

struct Acquisition {
  std::array<TaskRange, kRangeTasks> tasks;  ///< detect, recognise, identify by Johnson, then by TTP
  std::vector<double> range_m;               ///< of the probabilities, rising
  std::vector<StatedNumber> stated;
  std::vector<std::string> lines;     ///< observer, target, criteria, air
  std::vector<std::string> cautions;  ///< what the numbers rest on
  double filled_m = 0.0;              ///< nearer the target is wider than the field of view; 0: not known
};

/// `range_m`: of the probabilities, rising, above 0; empty for round lengths that show all tasks. Those beyond the
/// reach of the air are left out, which `cautions` says. `tolerance`: relative, of the ranges. `steps`: from each round
/// length to the next, for curves. Throws UsageError, with what to write instead, where no task has a range: without
/// target or contrast, for air that holds for one range alone.
Acquisition acquisition(const mtf::io::SensorConfig& sensor, const radiometry::Conditions& conditions,
                        std::span<const double> range_m = {}, double tolerance = 1e-4, int steps = 1);

}  // namespace study
