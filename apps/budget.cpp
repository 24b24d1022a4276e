// SPDX-License-Identifier: Apache-2.0

// `mtf budget SENSOR`: the electrons of a pixel, each noise term, and the sensitivity that follows.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "apps/budget_table.h"
#include "apps/config_command.h"
#include "apps/figures/otf_map.h"
#include "apps/options.h"
#include "apps/range/budget_curves.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"

namespace apps {
namespace {

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

using radiometry::BudgetGroup;

constexpr std::array kGroups{std::pair{BudgetGroup::signal, std::string_view("signal")},
                             std::pair{BudgetGroup::temporal, std::string_view("temporal noise")},
                             std::pair{BudgetGroup::spatial, std::string_view("spatial noise")},
                             std::pair{BudgetGroup::sensitivity, std::string_view("sensitivity")}};

/// 4 digits, below 10 million without an exponent.
std::string four_digits(double value) {
  const std::string text = significant(value, 4);
  const double rounded = std::stod(text), size = std::abs(rounded);
  return size >= 1e4 && size < 1e7 ? fixed(rounded, 0) : text;
}

std::string percent(double share) {
  if (share < 0.0005) return "< 0.1 %";
  return share < 0.9995 ? fixed(100.0 * share, 1) + " %" : "100 %";
}

/// Sum of the squares of the terms of a group; not above 0 where it has none or they have no numbers.
double variance_of(const Rows& rows, BudgetGroup group) {
  double sum = 0.0;
  for (const auto& row : rows)
    if (row.group == group && row.term) sum += row.value * row.value;
  return sum;
}

double share_of(const radiometry::BudgetRow& row, double variance) { return row.value * row.value / variance; }

/// Electrons or noise far below what a double resolves of the largest row of the group in that unit.
bool is_next_to_nothing(const radiometry::BudgetRow& row, const Rows& rows) {
  constexpr double kNothing = 1e-12;
  return row.group != BudgetGroup::sensitivity && std::any_of(rows.begin(), rows.end(), [&](const auto& other) {
           return other.group == row.group && other.unit == row.unit &&
                  std::abs(row.value) < kNothing * std::abs(other.value);
         });
}

/// The term that a group of noise is made of most, in words.
std::string largest_term(const Rows& rows, BudgetGroup group) {
  const double variance = variance_of(rows, group);
  if (!(variance > 0.0)) return {};
  const auto largest = std::max_element(rows.begin(), rows.end(), [&](const auto& x, const auto& y) {
    const auto size = [&](const auto& row) { return row.group == group && row.term ? row.value : -1.0; };
    return size(x) < size(y);
  });
  return "The largest " + std::string(group == BudgetGroup::temporal ? "temporal" : "spatial") + " term, " +
         percent(share_of(*largest, variance)) + " of the variance, is " + largest->name + ": " + largest->doc + ".\n";
}

}  // namespace

std::string budget_text(const BudgetTable& budget, const Rows& rows) {
  TextTable table({"term", "value", "unit", "of variance", "what it is"});
  std::vector<std::string> zeros;
  for (const auto& [group, title] : kGroups) {
    const double variance = variance_of(rows, group);
    bool titled = false;
    for (const auto& row : rows) {
      // The largest term is said of every detector, in words.
      if (row.group != group || row.name == "largest") continue;
      if (row.value == 0.0 || is_next_to_nothing(row, rows)) {
        zeros.push_back(row.name +
                        (row.value == 0.0 ? "" : " (" + mtf::with_unit(significant(row.value, 2), row.unit) + ")"));
        continue;
      }
      if (!std::exchange(titled, true)) {
        const bool behind_air = group == BudgetGroup::sensitivity && !budget.air.empty();
        table.add({std::string(title), "", "", "",
                   behind_air
                       ? "behind the air of " + budget.air + "; --without-path gives that of the sensor by itself"
                       : ""});
      }
      table.add({"  " + row.name,
                 row.saturated              ? "saturated"
                 : std::isfinite(row.value) ? four_digits(row.value)
                                            : "-",
                 row.unit, row.term && variance > 0.0 ? percent(share_of(row, variance)) : "", row.doc});
    }
  }
  std::string lines;
  if (!zeros.empty()) lines += "Zero: " + joined(zeros) + ".\n";
  lines += largest_term(rows, BudgetGroup::temporal) + largest_term(rows, BudgetGroup::spatial);
  lines += reasons(rows);
  if (const std::string said = words(budget.numbers.saturation); !said.empty()) lines += said + "\n";
  for (const std::string& line : budget.observer) lines += one_line(line) + "\n";
  return table.aligned({Align::left, Align::right, Align::left, Align::right}) + lines;
}

namespace {

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

std::string as_json(const BudgetTable& budget, const BudgetOptions& options, const mtf::io::SensorConfig& config) {
  Json json{{"sensor", options.sensor},
            {"name", config.system.name},
            {"config_sha256", config.sha256},
            {"temperature_k", options.temperature_k},
            {"saturation", saturation_json(budget.numbers.saturation)},
            {"notes", budget.notes},
            {"conditions", {{"lines", budget.observer}}}};
  if (!options.field.empty()) json["field"] = {config.system.point.x, config.system.point.y};
  Json& terms = json["terms"] = Json::object();
  for (const auto& row : budget.rows) {
    terms[row.name] = {{"value", row.value}, {"unit", row.unit}, {"doc", row.doc}};
    if (!row.refused.empty()) terms[row.name]["reason"] = row.refused;
  }
  return json_document(json);
}

}  // namespace

void note_budget(const BudgetOptions& options, const BudgetTable& budget, const Global& global) {
  constexpr double kCold_k = 100.0;
  if (!options.temperature_has_unit && options.temperature_k < kCold_k) {
    const std::string given = mtf::format_double(options.temperature_k);
    note(global, "warning: --temperature " + given + " was taken for " + given + " K; for degrees Celsius write \"" +
                     given + " degC\", or \"" + given + " K\" where kelvin is meant");
  }
  if (!options.temperature_given) note(global, "note: the pixel sees a surface of 300 K; --temperature takes another");
  if (budget.without_path) note(global, "note: the scene gives the range of each pixel; this budget is without a path");
  if (!budget.spatial_gap.empty()) note(global, "note: spatial noise has no number: " + budget.spatial_gap);
  for (const std::string& text : budget.notes) note(global, "note: " + text);
  const std::string said = words(budget.numbers.saturation);
  if (!said.empty() && (options.curves || options.format != Format::table))
    note(global, (budget.numbers.saturation.saturated() ? "warning: " : "note: ") + said);
}

mtf::io::SensorConfig read_sensor(const BudgetOptions& options, const Global& global) {
  mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  if (!options.field.empty()) config.system = system_at(config.system, field_point_of(config.system, options.field));
  return options.without_path ? without_path(std::move(config)) : config;
}

int run_budget(const BudgetOptions& options, const Global& global) {
  if (options.curves) return run_budget_curves(options, global);
  if (!options.plot.empty()) throw mtf::UsageError("--plot: draws the curves of --curves; give both");
  const mtf::io::SensorConfig config = read_sensor(options, global);
  if (!options.out.empty())
    for (const std::string& input : files_of(config)) require_different(input, options.out);
  const LoadedSensor loaded = load_chain(config);
  const BudgetTable budget = budget_table(config, loaded, options.temperature_k);
  note_budget(options, budget, global);
  const Rows& rows = budget.rows;
  switch (options.format) {
    case Format::table: {
      Rows shown = rows;
      for (auto& row : nyquist_rows(config.system, loaded)) shown.push_back(std::move(row));
      emit(options.out, budget_text(budget, shown));
      break;
    }
    case Format::csv:
      for (const std::string& line : budget.observer) note(global, "note: " + line);
      emit(options.out, as_csv(rows));
      break;
    case Format::json:
      emit(options.out, as_json(budget, options, config));
      break;
  }
  return 0;
}

}  // namespace apps
