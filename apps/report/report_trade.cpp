// SPDX-License-Identifier: Apache-2.0

// All designs of a sweep in charts: scatter and Pareto front, metrics over two axes.

#include <algorithm>

#include "apps/page/html.h"
#include "apps/page/svg.h"
#include "apps/report/report_sections.h"

namespace apps {
namespace {

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

}  // namespace

std::string column_html(const SweepColumn& column) {
  if (column.definition.empty()) return html(column.name);
  return "<abbr title=\"" + html(column.definition) + (column.source.empty() ? "" : " (" + html(column.source) + ")") +
         "\">" + html(column.name) + "</abbr>";
}

std::string column_label(const SweepColumn& column) {
  return column.unit.empty() ? column.name : column.name + " (" + column.unit + ")";
}

std::vector<double> column_values(const DesignTable& table, std::size_t column) {
  std::vector<double> values;
  values.reserve(table.cells.size());
  for (const auto& cells : table.cells) values.push_back(cell_value(cells[column]).value_or(NAN));
  return values;
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

}  // namespace apps
