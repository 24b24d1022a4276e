// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/metric_gap.h"

#include <algorithm>
#include <cmath>

#include "apps/sensor/sensor_air.h"
#include "apps/study/design/range_tasks.h"
#include "apps/study/study_shape.h"
#include "mtf/error.h"
#include "mtf/otf/otf_parts.h"

namespace study {
namespace {

/// "no [conditions] range, such as range = "5 km"": `keys` of which the first is shown as it is written.
std::string no_condition(std::string_view keys) {
  const std::string first(keys.substr(0, keys.find(' ')));
  std::string text = "no [conditions] " + std::string(keys);
  for (const mtf::FieldInfo& field : condition_fields())
    if (field.name == first) text += ", such as " + first + " = " + std::string(field.example);
  return text;
}

}  // namespace

std::string metric_gap(const MetricChoice& choice, const Study& study, const VariantSensor& sensor) {
  const Effort effort = choice.row->effort;
  const Metric metric = choice.row->metric;
  const Conditions& given = study.conditions;
  const bool quality = effort == Effort::giqe || effort == Effort::grd;
  const bool acquisition = effort == Effort::bars || effort == Effort::air;
  if ((effort == Effort::budget || quality || acquisition) && !sensor.no_budget.empty()) return sensor.no_budget;
  const bool own_range = sensor.loaded && apps::stated_range_m(sensor.loaded->sensor.settings);
  if ((metric == Metric::gsd || quality) && !given.range_m && !own_range) return no_condition("range");
  if ((metric == Metric::target_snr || quality) && !given.contrast_k && !given.signal_contrast)
    return no_condition("contrast or signal_contrast");
  if (effort == Effort::air) {
    if (!given.contrast_k) return no_condition("contrast");
    if (metric != Metric::ttp && !given.target_size_m) return no_condition("target_size");
    const auto tasks = range_tasks(given);
    const bool bars = std::any_of(tasks.begin(), tasks.end(),
                                  [&](const RangeTask& task) { return task.metric == metric && task.by_bars; });
    if (!bars) try {
        static_cast<void>(radiometry::viewing_of(given, sensor.system.frame));
      } catch (const mtf::UsageError& missing) {
        return missing.what();
      }
    if (!sensor.no_ranges.empty()) return sensor.no_ranges;
  }
  const auto& list = sensor.system.list(mtf::Stage::presample);
  const mtf::Context<double> middle = sensor.system.context();
  if (metric == Metric::cutoff &&
      std::ranges::none_of(list, [&](const auto& e) { return e.component.cutoff_cy_mm(middle) < mtf::kInfinity; }))
    return "no pupil (diffraction, defocus or wavefront), and no curve that ends at 0";
  const bool pupil = effort == Effort::light || metric == Metric::q;
  if (pupil && std::none_of(list.begin(), list.end(), [](const auto& e) { return e.component.is_pupil(); }))
    return "no pupil: diffraction, defocus or wavefront";
  const bool over_image = choice.over != Over::axis && !sensor.system.is_isoplanatic();
  if ((metric == Metric::fov || over_image) && (sensor.system.frame.columns <= 0 || sensor.system.frame.rows <= 0))
    return "no [frame] format; write format = [640, 512], columns and rows";
  if (effort == Effort::spurious && !mtf::is_reconstructed(sensor.system))
    return "no display, interpolation or eye in [[postsample]]";
  const bool thermal = sensor.loaded && sensor.loaded->sensor.settings.thermal;
  if (metric == Metric::nep && sensor.loaded && !thermal) return "no [detector] kind = \"thermal\"";
  const bool of_electrons = choice.row->unit == "e-" || metric == Metric::well_fill || metric == Metric::shot_netd ||
                            metric == Metric::nei || metric == Metric::dynamic_range;
  if (thermal && of_electrons) return "a thermal detector has no electrons and no photons; take netd, nep or snr";
  if (thermal && acquisition && !(given.frame_rate_hz > 0.0)) {
    const auto& frame = sensor.loaded->sensor.settings.frame;
    if (!frame || !frame->frame_time_s)
      return "no [frame] frame_time; write frame_time = \"33 ms\" there, or give [conditions] frame_rate";
  }
  if (metric == Metric::dynamic_range && sensor.loaded && sensor.loaded->sensor.settings.detector &&
      !std::isfinite(sensor.loaded->sensor.settings.detector->full_well_e))
    return "no [detector] full_well";
  return "";
}

std::string metric_gap(const MetricInfo& metric, const Study& study) {
  const auto choice = choose_metric(metric.name);
  if (!choice) return "";
  std::vector<int> levels(study.axes.size(), 0);
  const auto over_sensor = std::find_if(study.axes.begin(), study.axes.end(), [&](const Axis& axis) {
    return study.parameters[static_cast<std::size_t>(axis.parameter)].path == "sensor";
  });
  const std::size_t count = over_sensor == study.axes.end() ? 1 : over_sensor->levels.size();
  std::string gap;
  for (std::size_t level = 0; level < count; ++level) {
    if (over_sensor != study.axes.end())
      levels[static_cast<std::size_t>(over_sensor - study.axes.begin())] = static_cast<int>(level);
    const VariantSensor sensor = load_variant(study, levels);
    if (!sensor.problems.empty()) return "";  // reported elsewhere
    gap = metric_gap(*choice, study, sensor);
    if (gap.empty()) return "";
  }
  return gap;
}

}  // namespace study
