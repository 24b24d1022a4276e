// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rows of the catalogue of metric_list.h, for the code that computes the metrics, the tasks whose ranges are
// metrics, and what a metric needs that neither the sensor nor the study has.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mtf/frame.h"
#include "radiometry/performance/acquisition.h"
#include "radiometry/performance/conditions.h"

namespace study {

struct MetricInfo;
struct Study;
struct VariantSensor;

using radiometry::Conditions;

enum class Metric {
  cutoff,
  nyquist,
  q,
  ifov,
  gsd,
  fov,
  optics_mtf_nyquist,
  detector_mtf_nyquist,
  presample_mtf_nyquist,
  mtf_nyquist,
  folded_mtf_nyquist,
  mtf_at,
  mtf50,
  mtfa,
  rer,
  edge_overshoot,
  edge_height,
  fwhm,
  aliasing_ratio,
  spurious_in_band,
  spurious_out_of_band,
  spurious_response,
  strehl,
  ensquared_energy,
  signal,
  background,
  well_fill,
  scene_shot_noise,
  background_shot_noise,
  dark_shot_noise,
  read_noise,
  reset_noise,
  other_noise,
  quantisation_noise,
  temporal_noise,
  prnu_noise,
  dsnu_noise,
  correction_noise,
  spatial_noise,
  snr,
  netd,
  shot_netd,
  spatial_netd,
  nei,
  nep,
  dynamic_range,
  target_snr,
  niirs_giqe3,
  niirs_giqe4,
  niirs_giqe5,
  grd,
  mrtd,
  mdtd,
  johnson_detect,
  johnson_recognise,
  johnson_identify,
  ttp,
  ttp_detect,
  ttp_recognise,
  ttp_identify
};

/// The quantities that have to be computed for a metric.
enum class Effort {
  geometry,
  points,
  edge,
  overshoot,
  fwhm,
  mtf50,
  area,
  aliasing,
  spurious,
  light,
  budget,
  giqe,
  grd,
  bars,  ///< of an observer of bars or squares, behind the sensor's own air
  air    ///< of an observer of a target, at any range
};

struct MetricRow {
  Metric metric;
  std::string_view name;
  bool directional;  ///< also NAME_x and NAME_y; NAME is their geometric mean
  std::string_view unit, definition, source, needs;
  Effort effort;
  bool less_is_better = false;
};

std::span<const MetricRow> metric_rows();
const MetricRow& row_of(Metric metric);

/// Where in the image a metric of the OTF is taken: on the optical axis, or at the places of mtf/field/image_places.h.
enum class Over { axis, mean, worst };

/// A metric as asked for: which, along which axis (none: the geometric mean), for mtf_at the frequency, and where in
/// the image.
struct MetricChoice {
  const MetricRow* row = nullptr;
  std::optional<mtf::Axis> axis{};
  mtf::SpatialFrequency<double> at{};
  Over over = Over::axis;
};

/// It is of a target at its range, as sharp as that is there.
inline bool is_at_a_range(const MetricRow& row) {
  return row.effort == Effort::giqe || row.effort == Effort::grd ||
         (row.effort == Effort::air && row.metric != Metric::ttp);
}

/// Null for a name that no metric has.
std::optional<MetricChoice> choose_metric(std::string_view name);

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

/// "no [detector]", "no [conditions] range" ...; "" where the sensor has all that the metric needs.
std::string metric_gap(const MetricChoice& choice, const Study& study, const VariantSensor& sensor);

/// The same for a study: why no sensor file of its axis over `sensor` has what the metric needs, the other axes being
/// at their first values; "" where one of the files has it.
std::string metric_gap(const MetricInfo& metric, const Study& study);

}  // namespace study
