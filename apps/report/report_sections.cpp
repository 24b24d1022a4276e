// SPDX-License-Identifier: Apache-2.0
#include "apps/report/report_sweep.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/page/html.h"
#include "apps/page/svg.h"
#include "apps/terminal/text_table.h"

namespace apps {
namespace {

// The first screen: axes, constraints and objectives, and the best designs.

/// Values of a column at every row of the table, NaN where a cell is empty or no number.
std::vector<double> column_values(const DesignTable& table, std::size_t column) {
  std::vector<double> values;
  values.reserve(table.cells.size());
  for (const auto& cells : table.cells) values.push_back(cell_value(cells[column]).value_or(NAN));
  return values;
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

/// How many designs there are, how many of them count, and how right their numbers are.
std::string counts(const Sweep& sweep) {
  std::string text = sweep.single() ? "" : std::to_string(sweep.designs) + " designs: " + method_words(sweep) + ".";
  if (!sweep.constraints.empty() && !sweep.single())
    text += " " + std::to_string(sweep.feasible) + " (" + percent(sweep.feasible, sweep.designs) +
            ") meet every constraint" +
            (sweep.objectives.size() > 1 ? ", " + std::to_string(sweep.pareto_size) + " are on the Pareto front" : "") +
            ".";
  if (sweep.invalid > 0) {
    text += " " + std::to_string(sweep.invalid) + " are invalid";
    if (!sweep.cause.empty())
      text += "; the commonest cause, of " + std::to_string(sweep.of_cause) + " of the " +
              std::to_string(sweep.looked_at) + " that were looked at: " + html(sweep.cause);
    std::string between = sweep.cause.empty() ? ": " : ". By what they lack: ";
    const auto add = [&](const std::string& what, std::int64_t designs) {
      text += between + what + " in " + std::to_string(designs);
      between = "; ";
    };
    if (sweep.no_sensor > 0) add("impossible as a sensor", sweep.no_sensor);
    for (const auto& [what, designs] : sweep.not_finite) add(html(what) + " not finite", designs);
    text += ".";
  }
  if (std::isfinite(sweep.worst_error))
    text += " The largest error of a metric is " + significant(sweep.worst_error, 2) + ", estimated; tolerance " +
            significant(sweep.tolerance, 2) + ".";
  return "<p>" + text + "</p>\n";
}

std::string axis_values(const SweepAxis& axis, const Sweep& sweep, const DesignTable& table) {
  if (!axis.values.empty()) {
    if (axis.values.size() > 6)
      return html_value(axis.values.front()) + " to " + html_value(axis.values.back()) + ", " +
             std::to_string(axis.values.size()) + " values";
    return joined(axis.values, [](const std::string& value) { return html_value(value); });
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
  return items.empty() ? none : joined(items, html);
}

std::string yield_of(const Sweep& sweep, std::int64_t design) {
  for (const auto& [number, share] : sweep.best_yield)
    if (number == design && std::isfinite(share))
      return ", yield " + significant(100.0 * share, 3) + "&nbsp;% of " + std::to_string(sweep.draws) + " as built";
  return "";
}

std::string limits_of(const Sweep& sweep, const SweepBest& best) {
  if (!best.limits) return "What limits it is not in this folder; a sweep of this version of mtf says it.";
  std::string text;
  for (std::size_t i = 0; i < best.limits->size(); ++i) {
    const SweepLimit& limit = (*best.limits)[i];
    text += (i == 0                         ? "Limited by "
             : i + 1 == best.limits->size() ? " and "
                                            : ", ") +
            std::string("<strong>") + html(limit.text) + "</strong> (" + html(limit.state) + ")";
  }
  if (!text.empty()) return text + ".";
  return sweep.method == "grid" ? "No constraint and no end of an axis limits it."
                                : "No constraint is within 1 % of its limit.";
}

/// The best design of an objective as a sentence: its value, axes, and what the constraints are about.
std::string answer(const Sweep& sweep, const DesignTable& table, const SweepBest& best) {
  const SweepObjective& objective = *std::find_if(sweep.objectives.begin(), sweep.objectives.end(),
                                                  [&](const auto& o) { return o.text == best.objective; });
  const SweepColumn& column = sweep.columns[*sweep.column(objective.column)];
  const std::vector<std::string>& cells = table.cells[*table.row(best.design)];
  std::string text, between = ": ";
  std::vector<std::string> said{column.name};
  const auto add = [&](const std::string& name) {
    const auto c = sweep.column(name);
    if (!c || std::find(said.begin(), said.end(), name) != said.end()) return;
    said.push_back(name);
    text += between + column_html(sweep.columns[*c]) + " " + html_quantity(cells[*c], sweep.columns[*c].unit);
    between = ", ";
  };
  for (const SweepAxis& axis : sweep.axes) add(axis.column);
  between = "; ";
  for (const SweepConstraint& constraint : sweep.constraints)
    for (const std::string& name : constraint.columns) add(name);
  return "<div class=\"answer\"><p><strong class=\"value\">" +
         html_quantity(cells[*sweep.column(column.name)], column.unit) + "</strong> is the " +
         (objective.maximize ? "largest " : "smallest ") + html(best.objective) + text +
         ". <span class=\"key\" data-design=\"" + std::to_string(best.design) + "\">Design&nbsp;" +
         std::to_string(best.design) + "</span>" + yield_of(sweep, best.design) + ".</p>\n<p>" +
         limits_of(sweep, best) + "</p></div>\n";
}

std::string infeasible(const Sweep& sweep) {
  if (sweep.feasible > 0 || sweep.constraints.empty()) return "";
  std::string text = "<p class=\"warning\">No design meets every constraint.";
  if (sweep.nearest)
    text += " The nearest is design " + std::to_string(*sweep.nearest) + ", which misses " +
            list_of(sweep.violated, "none by itself") + ".";
  return text + "</p>\n";
}

std::string gaps(const Sweep& sweep) {
  std::string text;
  for (const SweepColumn& column : sweep.columns)
    if (!column.gap.empty())
      text +=
          "<p class=\"gap\"><strong>" + html(column.name) + "</strong> is not here: " + html(column.gap) + ".</p>\n";
    else if (column.missing > 0 && column.role != "yield")
      text += "<p class=\"gap\"><strong>" + html(column.name) + "</strong>: " + std::to_string(column.missing) +
              " designs cannot have it.</p>\n";
  return text;
}

/// What the figures hold for: target, air, observer, scene.
std::string conditions(const Sweep& sweep) {
  if (sweep.conditions.empty()) return "";
  std::string text = "<h3>These hold for</h3>\n<ul class=\"conditions\">";
  for (const std::string& line : sweep.conditions) text += "<li>" + html(line) + "</li>\n";
  return text + "</ul>\n";
}

// All designs of a sweep in charts: scatter and Pareto front, metrics over two axes.

/// "name (unit)" for axes of charts.
std::string column_label(const SweepColumn& column) {
  return column.unit.empty() ? column.name : column.name + " (" + column.unit + ")";
}

constexpr std::size_t kMostPoints = 1500;  // of a static chart

std::vector<std::size_t> axis_columns(const Sweep& sweep) {
  std::vector<std::size_t> columns;
  for (const SweepAxis& axis : sweep.axes)
    if (const std::size_t c = *sweep.column(axis.column); sweep.columns[c].levels.empty()) columns.push_back(c);
  return columns;
}

/// Objectives first: what a chart shows unless asked for something else.
std::vector<std::size_t> interesting(const Sweep& sweep) {
  std::vector<std::size_t> columns;
  const auto add = [&](std::size_t c) {
    if (sweep.columns[c].gap.empty() && std::ranges::find(columns, c) == columns.end()) columns.push_back(c);
  };
  for (const SweepObjective& objective : sweep.objectives) add(*sweep.column(objective.column));
  for (std::size_t c = 0; c < sweep.columns.size(); ++c)
    if (sweep.columns[c].role == "metric") add(c);
  for (const std::size_t c : axis_columns(sweep)) add(c);
  return columns;
}

Series series_of(const std::string& name, const DesignTable& table, std::size_t x, std::size_t y,
                 const std::vector<std::size_t>& rows, Mark mark) {
  Series series{.name = name, .mark = mark};
  for (const std::size_t row : rows) {
    const auto cx = cell_value(table.cells[row][x]), cy = cell_value(table.cells[row][y]);
    series.x.push_back(cx.value_or(NAN));
    series.y.push_back(cy.value_or(NAN));
  }
  return series;
}

std::string static_scatter(const Sweep& sweep, const DesignTable& table) {
  const std::vector<std::size_t> columns = interesting(sweep);
  if (columns.size() < 2) return "<p class=\"none\">There are not two columns of numbers to draw.</p>";
  std::vector<std::size_t> some, front, chosen;
  const std::size_t step = (table.design.size() + kMostPoints - 1) / kMostPoints;
  for (std::size_t i = 0; i < table.design.size(); i += std::max<std::size_t>(step, 1)) some.push_back(i);
  const std::size_t front_step = std::max<std::size_t>(1, sweep.pareto.size() / 400);
  for (std::size_t i = 0; i < sweep.pareto.size(); i += front_step)
    if (const auto row = table.row(sweep.pareto[i])) front.push_back(*row);
  for (const SweepChosen& one : sweep.chosen)
    if (const auto row = table.row(one.design)) chosen.push_back(*row);
  Figure figure;
  figure.x_label = column_label(sweep.columns[columns[0]]);
  figure.y_label = column_label(sweep.columns[columns[1]]);
  figure.title = sweep.columns[columns[1]].name + " against " + sweep.columns[columns[0]].name;
  figure.series.push_back(series_of("designs", table, columns[0], columns[1], some, Mark::points));
  if (!front.empty())
    figure.series.push_back(series_of("Pareto front", table, columns[0], columns[1], front, Mark::points));
  if (!chosen.empty())
    figure.series.push_back(series_of("chosen", table, columns[0], columns[1], chosen, Mark::large_points));
  return svg_figure(figure);
}

std::string subset_words(const Sweep& sweep, const DesignTable& table) {
  const std::string here = "<span id=\"embedded\">" + std::to_string(table.design.size()) + "</span>";
  if (table.whole()) return "All " + here + " designs are in this page.";
  std::string text = here + " of " + std::to_string(sweep.designs) +
                     " designs are in this page, to keep it small: one in " + std::to_string(table.every) +
                     ", drawn by a fixed hash of its number, the best and chosen ones, and ";
  text += table.pareto_every == 1 ? "the whole Pareto front"
                                  : "every " + std::to_string(table.pareto_every) + "th of the Pareto front";
  if (sweep.pareto_size > static_cast<std::int64_t>(sweep.pareto.size()))
    text += " (sweep.json lists " + std::to_string(sweep.pareto.size()) + " of its " +
            std::to_string(sweep.pareto_size) + ")";
  return text + ". designs.csv has all.";
}

// How far the results can be trusted and how they came about: sensitivities, error, definitions, files.

/// Change of the metric in percent for one percent of the parameter, at the design of the derivatives; NaN where the
/// units or values do not allow it.
double elasticity(const Sweep& sweep, const DesignTable& table, const Derivative& one) {
  const auto metric = sweep.column(one.column), parameter = sweep.column(one.parameter);
  const std::optional<std::size_t> row = table.row(sweep.slope_design.value_or(-1));
  if (!metric || !parameter || !row) return NAN;
  const std::string& unit = sweep.columns[*metric].unit;
  const std::string& by = sweep.columns[*parameter].unit;
  if (one.unit != (by.empty() ? unit : (unit.empty() ? "1" : unit) + " per " + by)) return NAN;
  const auto m = cell_value(table.cells[*row][*metric]), p = cell_value(table.cells[*row][*parameter]);
  return m && p && *m != 0.0 ? one.value * *p / *m : NAN;
}

std::string derivatives(const Sweep& sweep, const DesignTable& designs) {
  HtmlTable table("Partial derivatives", {"Metric", "Parameter", "Derivative", "Unit", "% per %"}, {2, 4});
  std::vector<Bar> bars;
  for (const Derivative& one : sweep.derivatives) {
    const double relative = elasticity(sweep, designs, one);
    table.add({html(one.column), html(one.parameter), html_value(one.value), html(one.unit), html_value(relative)});
    if (std::isfinite(relative) && bars.size() < 30) bars.push_back({one.column + ": " + one.parameter, relative, 0.0});
  }
  return "<h3>At design " + (sweep.slope_design ? std::to_string(*sweep.slope_design) : "?") +
         ": partial derivatives</h3>\n" +
         (bars.empty() ? table.html()
                       : html_chart("slopes", svg_bars("Change of a metric in percent for one percent of a parameter",
                                                       "% per %", bars)) +
                             "<details><summary>Numbers</summary>" + table.html() + "</details>\n");
}

/// Why metrics have no shares: each reason once, after their names.
std::string without_shares(const Sweep& sweep) {
  std::string rare, still;
  std::set<std::string> told;
  for (const SensitivityIndex& one : sweep.indices) {
    if (std::isfinite(one.total) || !told.insert(one.column).second) continue;
    std::string& names = 2 * one.used < sweep.samples ? rare : still;
    names += (names.empty() ? "" : ", ") + html(one.column);
  }
  const auto sentence = [](const std::string& names, const std::string& why) {
    return names.empty() ? ""
                         : "<p class=\"gap\">No shares of <strong>" + names + "</strong>, which " + why + ".</p>\n";
  };
  return sentence(rare, "fewer than half of the samples have") + sentence(still, "vary in no sample");
}

std::string indices(const Sweep& sweep) {
  std::vector<Bar> bars;
  for (const SensitivityIndex& one : sweep.indices)
    if (std::isfinite(one.total) && bars.size() < 40)
      bars.push_back({one.column + ": " + one.parameter, one.total, one.total_sd});
  HtmlTable table("Indices of Sobol", {"Metric", "Parameter", "First order", "&plusmn;", "Total", "&plusmn;"},
                  {2, 3, 4, 5});
  for (const SensitivityIndex& one : sweep.indices)
    table.add({html(one.column), html(one.parameter), html_value(one.first), html_value(one.first_sd),
               html_value(one.total), html_value(one.total_sd)});
  return "<h3>Over all of the space: share of the variance</h3>\n<p>First order: by this parameter alone. Total: with "
         "its interactions with others. From " +
         std::to_string(sweep.samples) + " samples; whiskers are one standard deviation.</p>\n" +
         without_shares(sweep) +
         (bars.empty() ? ""
                       : html_chart("indices",
                                    svg_bars("Total index of Sobol", "share of the variance", bars, Ends{0.0, 1.0}))) +
         "<details><summary>Numbers</summary>" + table.html() + "</details>\n";
}

std::string accuracy(const Sweep& sweep) {
  Figure figure;
  figure.title = "Error against run time";
  figure.x_label = "time of a design (us)";
  figure.y_label = "error";
  figure.log_x = figure.log_y = true;
  Series promised{.name = "promised"}, realised{.name = "realised"};
  HtmlTable table("Error against run time", {"Tolerance", "Promised", "Realised", "Time of a design (&micro;s)"},
                  {0, 1, 2, 3});
  for (const AccuracyPoint& point : sweep.accuracy) {
    promised.x.push_back(point.us_per_design);
    promised.y.push_back(point.promised);
    realised.x.push_back(point.us_per_design);
    realised.y.push_back(point.realised);
    table.add({html_value(point.tolerance), html_value(point.promised), html_value(point.realised),
               html_value(point.us_per_design)});
  }
  figure.series = {promised, realised};
  // The axis of errors is logarithmic: where all are 0 there is nothing on it.
  const bool any = std::any_of(sweep.accuracy.begin(), sweep.accuracy.end(),
                               [](const AccuracyPoint& point) { return point.promised > 0.0 || point.realised > 0.0; });
  const std::string chart = any ? html_chart("accuracy", svg_figure(figure))
                                : "<p>No metric of this study has an error at any tolerance: all are exact.</p>\n";
  return chart + "<details><summary>Numbers</summary>" + table.html() + "</details>\n";
}

std::string shown_file(const std::string& file, const std::string& sha256, const std::string& text,
                       const std::string& problem) {
  constexpr std::size_t kMost = 12'000;
  std::string body = problem.empty() ? "<pre>" + html_lines(std::string_view(text).substr(0, kMost)) + "</pre>"
                                     : "<p class=\"gap\">" + html(problem) + ".</p>";
  if (text.size() > kMost)
    body += "<p class=\"gap\">The first " + std::to_string(kMost) + " of " + std::to_string(text.size()) +
            " bytes; the file in the folder of the sweep has all.</p>";
  return "<details><summary><code>" + html(file) + "</code></summary>" +
         (sha256.empty() ? "" : "<p class=\"hash\">sha256 " + html(sha256) + "</p>") + body + "</details>\n";
}

}  // namespace

std::string column_html(const SweepColumn& column) {
  if (column.definition.empty()) return html(column.name);
  return "<abbr title=\"" + html(column.definition) + (column.source.empty() ? "" : " (" + html(column.source) + ")") +
         "\">" + html(column.name) + "</abbr>";
}

std::string summary_section(const Sweep& sweep, const DesignTable& table) {
  std::string body = infeasible(sweep);
  for (const SweepBest& best : sweep.best) body += answer(sweep, table, best);
  body += conditions(sweep) + counts(sweep);
  if (!sweep.single()) body += "<h3>Axes</h3>" + varies(sweep, table);
  if (!sweep.constraints.empty()) body += "<h3>Constraints</h3>" + constraints(sweep);
  return html_section("summary", "Summary", "", body + gaps(sweep));
}

std::string trade_section(const Sweep& sweep, const DesignTable& table) {
  return html_section("trade", "Trade space", subset_words(sweep, table),
                      html_chart("scatter", static_scatter(sweep, table)) + "<div id=\"filters\"></div>" +
                          html_chart("parallel", "") + "<div id=\"picked\" aria-live=\"polite\"></div>");
}

std::string map_section(const Sweep& sweep) {
  if (sweep.single() || axis_columns(sweep).size() < 2) return "";
  return html_section("maps", "Maps over two axes",
                      sweep.method == "grid" ? "Each cell is a design; other axes are held."
                                             : "The designs are sampled: each point is one.",
                      html_chart("map", "<p class=\"none\">Maps are drawn where the page may run its scripts.</p>"));
}

std::string sensitivity_section(const Sweep& sweep, const DesignTable& table) {
  std::string body;
  if (!sweep.indices.empty() && !sweep.single()) body += indices(sweep);
  if (!sweep.derivatives.empty()) body += derivatives(sweep, table);
  if (body.empty()) return "";
  return html_section("sensitivities", "Sensitivities", "Which parameter matters, and how much.", body);
}

std::string run_section(const Sweep& sweep) {
  std::string body =
      sweep.accuracy.empty()
          ? "<p>What other tolerances would cost was not measured; <code>mtf sweep --accuracy</code> does that.</p>\n"
          : accuracy(sweep);
  body += "<p>Run on " + (sweep.machine.empty() ? "a machine without a name" : html(sweep.machine)) + ", " +
          std::to_string(sweep.threads) + " threads";
  if (sweep.seconds) body += ", " + significant(*sweep.seconds, 4) + " s";
  if (sweep.designs_per_second) body += ", " + significant(*sweep.designs_per_second, 3) + " designs/s";
  if (sweep.resumed > 0)
    body += ", of which " + std::to_string(sweep.resumed) + " designs were computed by an earlier run";
  body += ".</p>\n";
  if (!sweep.skipped.empty()) {
    body += "<h3>What was left out</h3>\n<ul>";
    for (const std::string& sentence : sweep.skipped) body += "<li>" + html(sentence) + "</li>\n";
    body += "</ul>\n";
  }
  return html_section("run", "Error and time",
                      sweep.accuracy.empty() ? "" : "A sample of the designs at every tolerance, against a reference.",
                      body);
}

std::string columns_section(const Sweep& sweep) {
  HtmlTable table("Columns of designs.csv", {"Column", "Unit", "Role", "Definition", "Source"});
  for (const SweepColumn& column : sweep.columns)
    table.add({html(column.name), html(column.unit), html(column.role),
               html(column.definition) +
                   (column.gap.empty() ? "" : " <span class=\"gap\">Not here: " + html(column.gap) + "</span>"),
               html(column.source)});
  return html_section("definitions", "Definitions", "Every column of designs.csv.", table.html());
}

std::string files_section(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen) {
  constexpr std::size_t kMostFiles = 12;
  std::string body, problem;
  std::string text = text_of(sweep, sweep.study.file, problem);
  body += shown_file(sweep.study.file, sweep.study.sha256, text, problem);
  for (std::size_t i = 0; i < sweep.sensors.size() && i < kMostFiles; ++i) {
    problem.clear();
    text = text_of(sweep, sweep.sensors[i].file, problem);
    body += shown_file(sweep.sensors[i].file, sweep.sensors[i].sha256, text, problem);
  }
  if (sweep.sensors.size() > kMostFiles)
    body += "<p class=\"gap\">" + std::to_string(sweep.sensors.size() - kMostFiles) +
            " more sensor files are in the folder of the sweep.</p>";
  for (const ChosenDesign& design : chosen)
    if (!design.text.empty()) body += shown_file(design.chosen.file, design.config.sha256, design.text, "");
  HtmlTable hashes("Versions and hashes", {"What", "Version or hash"});
  hashes.add({"mtf that ran the sweep", html(sweep.version) + " <code>" + html(sweep.commit) + "</code>"});
  hashes.add({"designs.csv, sha256", "<code>" + html(table.sha256) + "</code>"});
  hashes.add({"sweep.json, sha256", "<code>" + html(sweep.sha256) + "</code>"});
  return html_section("files", "Study and files", "", body + hashes.html());
}

}  // namespace apps
