// SPDX-License-Identifier: Apache-2.0

// `mtf budget SENSOR`: what a pixel collects, each noise term, and what that lets one see.

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/options.h"
#include "apps/output.h"
#include "apps/sensor_chain.h"
#include "apps/sensor_file.h"
#include "apps/text_table.h"
#include "radiometry/sensor_budget.h"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;
using Rows = std::vector<radiometry::BudgetRow>;

std::string as_table(const Rows& rows) {
  TextTable table({"term", "value", "unit", "what it is"});
  for (const auto& row : rows)
    table.add({row.name, std::isfinite(row.value) ? significant(row.value, 7) : "-", row.unit, row.doc});
  return table.aligned({Align::left, Align::right});
}

std::string as_csv(const Rows& rows) {
  TextTable table({"term", "value", "unit", "doc"});
  for (const auto& row : rows) table.add({row.name, csv_number(row.value), row.unit, row.doc});
  return table.csv();
}

std::string as_json(const Rows& rows, const BudgetOptions& options, const mtf::io::SensorConfig& config) {
  Json json{{"sensor", options.sensor},
            {"name", config.system.name},
            {"config_sha256", config.sha256},
            {"temperature_k", options.temperature_k}};
  Json& terms = json["terms"] = Json::object();
  for (const auto& row : rows) terms[row.name] = {{"value", row.value}, {"unit", row.unit}, {"doc", row.doc}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

int run_budget(const BudgetOptions& options, const Global& global) {
  const mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  if (!options.out.empty())
    for (const std::string& input : files_of(config)) require_different(input, options.out);
  const LoadedSensor loaded = load_chain(config);
  if (loaded.paths) note(global, "note: the path has the range of each pixel; this budget is for none");
  const radiometry::Budget<double> budget = budget_of(config.system, loaded.sensor, options.temperature_k);
  if (const std::string gap = spatial_gap(loaded.sensor.settings, budget); !gap.empty())
    note(global, "note: spatial noise has no number: " + gap);
  Rows rows = radiometry::rows(budget);
  rows.push_back(dstar_row(config.system, loaded.sensor, budget));
  switch (options.format) {
    case Format::table:
      emit(options.out, as_table(rows));
      break;
    case Format::csv:
      emit(options.out, as_csv(rows));
      break;
    case Format::json:
      emit(options.out, as_json(rows, options, config));
      break;
  }
  return 0;
}

}  // namespace apps
