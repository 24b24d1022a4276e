// SPDX-License-Identifier: Apache-2.0

// What the figures of a study hold for, in words, and a study file to start from.

#include <algorithm>

#include "apps/sensor/sensor_air.h"
#include "apps/study/design/metric_rows.h"
#include "apps/study/study_reader.h"
#include "apps/study/study_shape.h"
#include "apps/study/study_starter.toml.h"
#include "mtf/error.h"
#include "mtf/words.h"
#include "radiometry/performance/condition_lines.h"

namespace study {
namespace {

radiometry::FiguresOfObservers figures_of(const Study& study) {
  radiometry::FiguresOfObservers figures;
  const auto tasks = range_tasks(study.conditions);
  for (const MetricInfo& metric : study.metrics) {
    const MetricRow& row = *choose_metric(metric.name)->row;
    if (row.effort == Effort::bars) figures.bars = true;
    if (row.effort != Effort::air) continue;
    const bool by_bars = std::any_of(tasks.begin(), tasks.end(),
                                     [&](const RangeTask& task) { return task.metric == row.metric && task.by_bars; });
    (by_bars ? figures.johnson : figures.ttp) = true;
  }
  return figures;
}

/// Of all sensor files of the study. `ranges`: figures are ranges, in the air up to each of them.
std::string air_of(const Study& study, bool ranges) {
  std::vector<std::string> airs;
  const auto add = [&](const mtf::io::SensorConfig& sensor) {
    std::string words = apps::air_words(radiometry::sensor_settings(sensor.tables));
    if (words.empty()) words = "none";
    if (words == "none" && study.conditions.extinction_per_km)
      words = "extinction of the contrast, " + mtf::format_double(*study.conditions.extinction_per_km) + " per km";
    if (std::find(airs.begin(), airs.end(), words) == airs.end()) airs.push_back(words);
  };
  add(study.base);
  for (const mtf::io::SensorConfig& sensor : study.sensors) add(sensor);
  std::string text;
  for (const std::string& one : airs) text += (text.empty() ? "" : "; or ") + one;
  if (!ranges) return text;
  return text == "none" ? "none; ranges are those in a vacuum, longer than in any air"
                        : text + "; ranges are solved with the air up to each of them";
}

/// What signal, noise and image quality hold for, where nothing says it of ranges; "" without such figures.
std::string scene_of(const Study& study) {
  const Conditions& c = study.conditions;
  if (std::none_of(study.metrics.begin(), study.metrics.end(), [](const MetricInfo& metric) {
        const Effort effort = choose_metric(metric.name)->row->effort;
        return effort == Effort::budget || effort == Effort::giqe || effort == Effort::grd;
      }))
    return "";
  return "scene: surface of " + mtf::format_double(c.temperature_k) + " K" +
         (c.contrast_k ? ", contrast " + mtf::format_double(*c.contrast_k) + " K" : "") +
         (c.signal_contrast ? ", contrast of the signal " + mtf::format_double(*c.signal_contrast) : "") +
         (c.range_m ? ", at " + mtf::format_double(*c.range_m / 1e3) + " km, elevation " +
                          mtf::format_double(c.elevation_deg) + " deg"
                    : "");
}

}  // namespace

std::string extinction_problem(const mtf::io::SensorConfig& sensor) {
  for (const std::string air : {"atmosphere", "path"})
    if (find_table(sensor.tables, air) != nullptr)
      return "given beside [" + air + "] of " + mtf::printable(sensor.file) +
             ", whose air takes contrast too; remove [" + air + "] from the sensor file, or extinction";
  return "";
}

std::vector<std::string> condition_lines(const Study& study) {
  std::optional<radiometry::Viewing<double>> viewing;
  try {
    viewing = radiometry::viewing_of(study.conditions, study.base.system.frame);
  } catch (const mtf::UsageError&) {  // the gap of each figure says it
  }
  const radiometry::FiguresOfObservers figures = figures_of(study);
  const bool one_rate = study.sensors.empty() && std::ranges::none_of(study.parameters, [](const Parameter& parameter) {
                          return parameter.path == "frame.frame_time" || parameter.path == "frame.integration_time";
                        });
  const std::string frame_rate =
      one_rate ? apps::frame_rate_words(study.base.system, radiometry::sensor_settings(study.base.tables)) : "";
  auto lines = radiometry::condition_lines(figures, study.conditions, viewing,
                                           air_of(study, figures.johnson || figures.ttp), frame_rate);
  if (const std::string scene = scene_of(study); !figures.johnson && !figures.ttp && !scene.empty())
    lines.insert(lines.begin(), scene);
  return lines;
}

std::string starter_study() {
  std::string text(mtf::embedded::study_starter_toml);
  for (const mtf::FieldInfo& field : condition_fields()) {
    std::string line = "# " + std::string(field.name) + " = " + std::string(field.example);
    line.resize(std::max<std::size_t>(line.size() + 2, 34), ' ');
    text += line + "# " + std::string(field.doc) + "\n";
  }
  return text;
}

}  // namespace study
