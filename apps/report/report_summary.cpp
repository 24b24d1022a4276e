// SPDX-License-Identifier: Apache-2.0

// The first screen: axes, constraints and objectives, and the best designs.

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/report/report_html.h"
#include "apps/report/report_sections.h"
#include "apps/terminal/text_table.h"

namespace apps {
namespace {

std::string tile(const std::string& value, const std::string& what) {
  return "<div class=\"tile\"><strong>" + value + "</strong><span>" + what + "</span></div>";
}

std::string percent(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? significant(100.0 * static_cast<double>(part) / static_cast<double>(whole), 3) + " %" : "0 %";
}

std::string method_words(const Sweep& sweep) {
  if (sweep.method == "grid") return "all combinations of a grid";
  if (sweep.method == "latin_hypercube") return "a Latin hypercube sample, seed " + std::to_string(sweep.seed);
  if (sweep.method == "sobol") return "a Sobol sample";
  return html(sweep.method);
}

std::string tiles(const Sweep& sweep) {
  std::string body = "<div class=\"tiles\">";
  body += tile("<span id=\"total\">" + std::to_string(sweep.designs) + "</span>", "designs, " + method_words(sweep));
  body += tile(std::to_string(sweep.feasible), sweep.constraints.empty()
                                                   ? "feasible: the study has no constraints"
                                                   : "feasible (" + percent(sweep.feasible, sweep.designs) + ")");
  if (sweep.invalid > 0) {
    std::string what = "invalid: ";
    if (sweep.no_sensor > 0) what += "impossible as a sensor: " + std::to_string(sweep.no_sensor);
    for (const auto& [text, designs] : sweep.not_finite)
      what += (what == "invalid: " ? "" : "; ") + html(text) + " not finite in " + std::to_string(designs);
    body += tile(std::to_string(sweep.invalid), what);
  }
  if (sweep.objectives.size() > 1) body += tile(std::to_string(sweep.pareto_size), "on the Pareto front");
  if (std::isfinite(sweep.worst_error))
    body += tile(significant(sweep.worst_error, 2), "largest error, tolerance " + significant(sweep.tolerance, 2));
  if (sweep.seconds && sweep.designs_per_second)
    body += tile(significant(*sweep.designs_per_second, 3) + "/s",
                 significant(*sweep.seconds, 3) + " s on " + std::to_string(sweep.threads) + " threads");
  return body + "</div>\n";
}

std::string axis_values(const SweepAxis& axis, const Sweep& sweep, const DesignTable& table) {
  if (!axis.values.empty()) {
    if (axis.values.size() > 6)
      return html_value(axis.values.front()) + " to " + html_value(axis.values.back()) + ", " +
             std::to_string(axis.values.size()) + " values";
    std::string all;
    for (const std::string& value : axis.values) all += (all.empty() ? "" : ", ") + html_value(value);
    return all;
  }
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  for (const double v : column_values(table, *sweep.column(axis.column)))
    if (std::isfinite(v)) {
      lo = std::min(lo, v);
      hi = std::max(hi, v);
    }
  return hi >= lo ? significant(lo, 4) + " to " + significant(hi, 4) + ", sampled" : "";
}

std::string varies(const Sweep& sweep, const DesignTable& table) {
  HtmlTable html_table("What varies", {"Parameter", "Unit", "Values", "Scale"});
  for (const SweepAxis& axis : sweep.axes) {
    const SweepColumn& column = sweep.columns[*sweep.column(axis.column)];
    html_table.add({column_html(column), html(column.unit), axis_values(axis, sweep, table), html(axis.scale)});
  }
  for (const SweepColumn& column : sweep.columns)
    if (column.role == "link")
      html_table.add({column_html(column), html(column.unit), html(column.definition), "follows"});
  return html_table.html();
}

std::string constraints(const Sweep& sweep) {
  if (sweep.constraints.empty()) return "";
  HtmlTable table("Constraints", {"Constraint", "Designs that meet it", ""}, {1});
  for (const SweepConstraint& constraint : sweep.constraints) {
    const double share =
        static_cast<double>(constraint.met) / static_cast<double>(std::max<std::int64_t>(sweep.designs, 1));
    table.add({html(constraint.text),
               std::to_string(constraint.met) + " (" + percent(constraint.met, sweep.designs) + ")",
               "<span class=\"share\" style=\"--share:" + fixed(std::clamp(share, 0.0, 1.0), 4) + "\"></span>"});
  }
  return table.html();
}

std::string list_of(const std::vector<std::string>& items, const char* none) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + html(item);
  return text.empty() ? none : text;
}

std::string yield_of(const Sweep& sweep, std::int64_t design) {
  for (const auto& [number, share] : sweep.best_yield)
    if (number == design && std::isfinite(share)) return significant(100.0 * share, 3) + "&nbsp;%";
  return html_value("");
}

std::string best(const Sweep& sweep, const DesignTable& table) {
  if (sweep.best.empty()) return "";
  std::vector<std::string> header{"Objective", "Design", "Value"};
  for (const SweepAxis& axis : sweep.axes) header.push_back(column_html(sweep.columns[*sweep.column(axis.column)]));
  if (sweep.draws > 0)
    header.push_back("<abbr title=\"share of " + std::to_string(sweep.draws) +
                     " builds, with the variation as built, that meet every constraint\">Yield</abbr>");
  header.emplace_back("<abbr title=\"constraints within 1 % of their limit\">Limited by</abbr>");
  HtmlTable rows("Best designs", header, {1, 2});
  for (const SweepBest& one : sweep.best) {
    const auto objective = std::find_if(sweep.objectives.begin(), sweep.objectives.end(),
                                        [&](const auto& o) { return o.text == one.objective; });
    const bool known = objective != sweep.objectives.end();
    const auto column = sweep.column(known ? objective->column : one.objective);
    const auto row = table.row(one.design);
    std::vector<std::string> cells{(known ? objective->maximize ? "maximize " : "minimize " : "") + html(one.objective),
                                   std::to_string(one.design),
                                   (row && column ? html_value(table.cells[*row][*column]) : html_value(one.value)) +
                                       (column ? " " + html(sweep.columns[*column].unit) : "")};
    for (const SweepAxis& axis : sweep.axes)
      cells.push_back(row ? html_value(table.cells[*row][*sweep.column(axis.column)]) : "");
    if (sweep.draws > 0) cells.push_back(yield_of(sweep, one.design));
    cells.push_back(list_of(one.active, "none"));
    rows.add(cells);
  }
  return rows.html();
}

std::string words(const Sweep& sweep) {
  std::string text;
  if (sweep.feasible == 0 && !sweep.constraints.empty()) {
    text += "<p class=\"warning\">No design meets every constraint.";
    if (sweep.nearest)
      text += " The nearest is design " + std::to_string(*sweep.nearest) + ", which misses " +
              list_of(sweep.violated, "none by itself") + ".";
    text += "</p>\n";
  }
  for (const SweepColumn& column : sweep.columns)
    if (!column.gap.empty())
      text +=
          "<p class=\"gap\"><strong>" + html(column.name) + "</strong> is not here: " + html(column.gap) + ".</p>\n";
  for (const SweepColumn& column : sweep.columns)
    if (column.gap.empty() && column.missing > 0 && column.role != "yield")
      text += "<p class=\"gap\"><strong>" + html(column.name) + "</strong>: " + std::to_string(column.missing) +
              " designs cannot have it.</p>\n";
  return text;
}

/// What figures of observers and ranges hold for.
std::string conditions(const Sweep& sweep) {
  if (sweep.conditions.empty()) return "";
  std::string text = "<h3>Observer, target, air</h3>\n<ul>";
  for (const std::string& line : sweep.conditions) text += "<li>" + html(line) + "</li>\n";
  return text + "</ul>\n";
}

}  // namespace

std::string summary_section(const Sweep& sweep, const DesignTable& table) {
  std::string objectives;
  for (const SweepObjective& objective : sweep.objectives)
    objectives += (objectives.empty() ? "" : ", ") + std::string(objective.maximize ? "maximize " : "minimize ") +
                  "<em>" + html(objective.text) + "</em>";
  return html_section("summary", "Summary", objectives.empty() ? "" : "Objectives: " + objectives + ".",
                      tiles(sweep) + words(sweep) + "<h3>Axes</h3>" + varies(sweep, table) +
                          (sweep.constraints.empty() ? "" : "<h3>Constraints</h3>" + constraints(sweep)) +
                          (sweep.best.empty() ? "" : "<h3>Best designs</h3>" + best(sweep, table)) + conditions(sweep));
}

}  // namespace apps
