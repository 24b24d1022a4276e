// SPDX-License-Identifier: Apache-2.0

// `mtf budget SENSOR`: the electrons of a pixel, each noise term, and the sensitivity that follows.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/options.h"
#include "apps/sensor/observer_rows.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_file.h"
#include "apps/sensor/sensor_place.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "radiometry/performance/sensor_budget.h"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;
using Rows = std::vector<radiometry::BudgetRow>;

/// Why figures have no value, but for saturation: each reason once, after the names of its rows.
std::string reasons(const Rows& rows) {
  std::vector<std::pair<std::string, std::string>> found;  // reason, names
  for (const auto& row : rows) {
    if (row.refused.empty() || row.saturated) continue;
    const auto same = std::find_if(found.begin(), found.end(), [&](const auto& f) { return f.first == row.refused; });
    if (same == found.end())
      found.emplace_back(row.refused, row.name);
    else
      same->second += ", " + row.name;
  }
  std::string text;
  for (const auto& [reason, names] : found) text += "no " + names + ": " + reason + "\n";
  return text;
}

/// What the path lets through of the light of the surface, and of that of a small difference of its temperature. A
/// band average of the transmission alone would be another number.
void add_path_rows(const radiometry::Sensor& sensor, double temperature_k, Rows& rows) {
  if (!sensor.settings.path && !sensor.settings.atmosphere) return;
  const double reflected_k = sensor.settings.scene ? sensor.settings.scene->surroundings_k.value_or(0.0) : 0.0;
  const radiometry::Surface surface{temperature_k, sensor.emissivity, reflected_k};
  const auto add = [&](const char* name, const char* doc, const auto& light) {
    const double clear = light(sensor.curves, surface, radiometry::Path{});
    radiometry::BudgetRow row{name, "", light(sensor.curves, surface, sensor.path) / clear, doc};
    if (!(clear > 0.0)) row.refused = "no light of the scene makes electrons";
    rows.push_back(std::move(row));
  };
  add("path_share", "share of the scene's light that the path lets through", radiometry::scene_radiance);
  add("contrast_share", "the same of a small temperature difference", radiometry::scene_derivative);
}

std::string as_table(const Rows& rows, const radiometry::Saturation& saturation) {
  TextTable table({"term", "value", "unit", "what it is"});
  for (const auto& row : rows)
    table.add({row.name,
               row.saturated              ? "saturated"
               : std::isfinite(row.value) ? significant(row.value, 7)
                                          : "-",
               row.unit, row.doc});
  const std::string said = words(saturation);
  return table.aligned({Align::left, Align::right}) + reasons(rows) + (said.empty() ? "" : said + "\n");
}

std::string as_csv(const Rows& rows) {
  TextTable table({"term", "value", "unit", "doc", "reason"});
  for (const auto& row : rows) table.add({row.name, csv_number(row.value), row.unit, row.doc, row.refused});
  return table.csv();
}

Json saturation_json(const radiometry::Saturation& saturation) {
  Json json{{"saturated", saturation.saturated()}, {"end", nullptr}, {"share_held", saturation.held}};
  if (saturation.end != radiometry::RangeEnd::none) json["end"] = range_end_name(saturation.end);
  if (const std::string said = words(saturation); !said.empty())
    json[saturation.saturated() ? "reason" : "note"] = said;
  return json;
}

std::string as_json(const Rows& rows, const radiometry::Saturation& saturation, const std::vector<std::string>& notes,
                    const BudgetOptions& options, const mtf::io::SensorConfig& config) {
  Json json{{"sensor", options.sensor},
            {"name", config.system.name},
            {"config_sha256", config.sha256},
            {"temperature_k", options.temperature_k},
            {"saturation", saturation_json(saturation)},
            {"notes", notes}};
  Json& terms = json["terms"] = Json::object();
  for (const auto& row : rows) {
    terms[row.name] = {{"value", row.value}, {"unit", row.unit}, {"doc", row.doc}};
    if (!row.refused.empty()) terms[row.name]["reason"] = row.refused;
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

int run_budget(const BudgetOptions& options, const Global& global) {
  const mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  if (!options.out.empty())
    for (const std::string& input : files_of(config)) require_different(input, options.out);
  constexpr double kCold_k = 100.0;
  if (!options.temperature_has_unit && options.temperature_k < kCold_k) {
    const std::string given = mtf::format_double(options.temperature_k);
    note(global, "warning: --temperature " + given + " was taken for " + given + " K; for degrees Celsius write \"" +
                     given + " degC\", or \"" + given + " K\" where kelvin is meant");
  }
  const LoadedSensor loaded = load_chain(config);
  if (loaded.paths) note(global, "note: the scene gives the range of each pixel; this budget is without a path");
  const radiometry::Budget<double> budget =
      at_its_place(config, [&] { return budget_of(config.system, loaded.sensor, options.temperature_k); });
  if (const std::string gap = spatial_gap(loaded.sensor.settings, budget); !gap.empty())
    note(global, "note: spatial noise has no number: " + gap);
  const std::vector<std::string> notes = budget_notes(loaded.sensor);
  for (const std::string& text : notes) note(global, "note: " + text);
  Rows rows = budget_rows(config.system, loaded.sensor, budget);
  for (radiometry::BudgetRow& row : observer_rows(with_electron_rate(config.system, loaded), loaded.sensor, budget))
    rows.push_back(std::move(row));
  if (!loaded.paths) add_path_rows(loaded.sensor, options.temperature_k, rows);
  const radiometry::Saturation& saturation = budget.saturation;
  if (const std::string said = words(saturation); !said.empty() && options.format != Format::table)
    note(global, (saturation.saturated() ? "warning: " : "note: ") + said);
  switch (options.format) {
    case Format::table:
      emit(options.out, as_table(rows, saturation));
      break;
    case Format::csv:
      emit(options.out, as_csv(rows));
      break;
    case Format::json:
      emit(options.out, as_json(rows, saturation, notes, options, config));
      break;
  }
  return 0;
}

}  // namespace apps
