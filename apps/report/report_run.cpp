// SPDX-License-Identifier: Apache-2.0

// How far the results can be trusted and how they came about: sensitivities, error, definitions, files.

#include <algorithm>
#include <cmath>

#include "apps/report/report_html.h"
#include "apps/report/report_sections.h"
#include "apps/report/report_svg.h"
#include "apps/terminal/text_table.h"

namespace apps {
namespace {

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

std::string indices(const Sweep& sweep) {
  std::vector<Bar> bars;
  for (const SensitivityIndex& one : sweep.indices)
    if (bars.size() < 40) bars.push_back({one.column + ": " + one.parameter, one.total, one.total_sd});
  HtmlTable table("Indices of Sobol", {"Metric", "Parameter", "First order", "&plusmn;", "Total", "&plusmn;"},
                  {2, 3, 4, 5});
  for (const SensitivityIndex& one : sweep.indices)
    table.add({html(one.column), html(one.parameter), html_value(one.first), html_value(one.first_sd),
               html_value(one.total), html_value(one.total_sd)});
  return "<h3>Over all of the space: share of the variance</h3>\n<p>First order: by this parameter alone. Total: with "
         "its interactions with others. From " +
         std::to_string(sweep.samples) + " samples; whiskers are one standard deviation.</p>\n" +
         html_chart("indices", svg_bars("Total index of Sobol", "share of the variance", bars)) +
         "<details><summary>Numbers</summary>" + table.html() + "</details>\n";
}

std::string accuracy(const Sweep& sweep) {
  Figure figure;
  figure.title = "Error against run time";
  figure.x_label = "time of a design (us)";
  figure.y_label = "error";
  figure.log_x = figure.log_y = true;
  Series promised{.name = "promised", .x = {}, .y = {}}, realised{.name = "realised", .x = {}, .y = {}};
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

std::string sensitivity_section(const Sweep& sweep, const DesignTable& table) {
  std::string body;
  if (!sweep.indices.empty()) body += indices(sweep);
  if (!sweep.derivatives.empty()) body += derivatives(sweep, table);
  if (body.empty()) body = "<p class=\"gap\">The sweep computed no sensitivities.</p>";
  return html_section("sensitivities", "Sensitivities", "Which parameter matters, and how much.", body);
}

std::string run_section(const Sweep& sweep) {
  std::string body =
      sweep.accuracy.empty()
          ? "<p class=\"gap\">The sweep did not measure its error against the time it takes; <code>mtf sweep "
            "--accuracy</code> does.</p>"
          : accuracy(sweep);
  body += "<p>Run on " + (sweep.machine.empty() ? "a machine without a name" : html(sweep.machine)) + ", " +
          std::to_string(sweep.threads) + " threads";
  if (sweep.seconds) body += ", " + significant(*sweep.seconds, 4) + " s";
  if (sweep.resumed > 0)
    body += ", of which " + std::to_string(sweep.resumed) + " designs were computed by an earlier run";
  body += ".</p>\n";
  if (!sweep.skipped.empty()) {
    body += "<h3>What was left out</h3>\n<ul>";
    for (const std::string& sentence : sweep.skipped) body += "<li>" + html(sentence) + "</li>\n";
    body += "</ul>\n";
  }
  return html_section("run", "Error against time", "A sample of the designs at every tolerance, against a reference.",
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
