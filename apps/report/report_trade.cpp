// SPDX-License-Identifier: Apache-2.0

// All designs of a sweep in charts: scatter and Pareto front, metrics over two axes.

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/report/report_html.h"
#include "apps/report/report_sections.h"
#include "apps/report/report_svg.h"

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
    if (sweep.columns[c].gap.empty() && std::find(columns.begin(), columns.end(), c) == columns.end())
      columns.push_back(c);
  };
  for (const SweepObjective& objective : sweep.objectives) add(*sweep.column(objective.column));
  for (std::size_t c = 0; c < sweep.columns.size(); ++c)
    if (sweep.columns[c].role == "metric") add(c);
  for (const std::size_t c : axis_columns(sweep)) add(c);
  return columns;
}

Series series_of(const std::string& name, const DesignTable& table, std::size_t x, std::size_t y,
                 const std::vector<std::size_t>& rows, Mark mark) {
  Series series{.name = name, .x = {}, .y = {}, .mark = mark};
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

/// The best value over all other axes would hide what they do, so a static map is drawn at the best design's place.
std::string static_map(const Sweep& sweep, const DesignTable& table) {
  const std::vector<std::size_t> axes = axis_columns(sweep), metrics = interesting(sweep);
  if (axes.size() < 2 || metrics.empty() || table.cells.empty())
    return "<p class=\"none\">A map needs two axes of numbers.</p>";
  const std::size_t x = axes[0], y = axes[1], z = metrics.front();
  const std::string title = sweep.columns[z].name + " over " + sweep.columns[x].name + " and " + sweep.columns[y].name;
  const auto levels = [&](std::size_t column) {
    for (const SweepAxis& axis : sweep.axes)
      if (axis.column == sweep.columns[column].name) return axis.values;
    return std::vector<std::string>{};
  };
  HeatMap map{title, column_label(sweep.columns[x]), column_label(sweep.columns[y]), levels(x), levels(y), {}};
  if (sweep.method != "grid" || map.x.empty() || map.y.empty() || map.x.size() * map.y.size() > 4000) {
    Figure figure;
    figure.title = title;
    figure.x_label = map.x_label;
    figure.y_label = map.y_label;
    figure.colour_label = column_label(sweep.columns[z]);
    std::vector<std::size_t> rows;
    const std::size_t step = std::max<std::size_t>(1, table.design.size() / kMostPoints);
    for (std::size_t i = 0; i < table.design.size(); i += step) rows.push_back(i);
    figure.series.push_back(series_of("", table, x, y, rows, Mark::points));
    for (const std::size_t row : rows)
      figure.series.back().value.push_back(cell_value(table.cells[row][z]).value_or(NAN));
    return svg_figure(figure);
  }
  const std::size_t at = sweep.best.empty() ? 0 : table.row(sweep.best.front().design).value_or(0);
  std::map<std::pair<double, double>, double> values;
  for (const auto& cells : table.cells) {
    bool here = true;
    for (const SweepAxis& axis : sweep.axes)
      if (const std::size_t c = *sweep.column(axis.column); c != x && c != y)
        here = here && cells[c] == table.cells[at][c];
    const auto cx = cell_value(cells[x]), cy = cell_value(cells[y]);
    if (here && cx && cy) values[{*cx, *cy}] = cell_value(cells[z]).value_or(NAN);
  }
  for (const std::string& level_y : map.y)
    for (const std::string& level_x : map.x) {
      const auto cx = cell_value(level_x), cy = cell_value(level_y);
      const auto found = cx && cy ? values.find({*cx, *cy}) : values.end();
      map.value.push_back(found == values.end() ? NAN : found->second);
    }
  return svg_heat_map(map);
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

std::string map_section(const Sweep& sweep, const DesignTable& table) {
  return html_section("maps", "Maps over two axes",
                      sweep.method == "grid" ? "Each cell is a design; other axes are held."
                                             : "The designs are sampled: each point is one.",
                      html_chart("map", static_map(sweep, table)));
}

}  // namespace apps
