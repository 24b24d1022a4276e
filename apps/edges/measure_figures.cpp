// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "apps/edges/measure_report.h"
#include "apps/terminal/text_table.h"

namespace apps {
namespace {

using calib::EdgeMeasurement;
using calib::Trouble;

/// Distances from the edge that figures show.
constexpr double kShown_px = 8.0;

/// Three decimals of cycles per pixel, as many digits of a larger number.
std::string frequency_text(double frequency, FrequencyUnit unit) {
  return unit == FrequencyUnit::cy_px ? fixed(frequency, 3) : significant(frequency, 4);
}

}  // namespace

Series with_band(std::string name, const std::vector<double>& x, const std::vector<double>& y,
                 const std::vector<double>& sd) {
  Series series{.name = std::move(name), .x = x, .y = y, .emphasised = true};
  if (sd.size() != y.size()) return series;
  for (std::size_t i = 0; i < y.size(); ++i) {
    series.low.push_back(y[i] - 2.0 * sd[i]);
    series.high.push_back(y[i] + 2.0 * sd[i]);
  }
  return series;
}

std::string mtf50_text(const MeasuredEdge& edge) {
  const auto mtf50 = in_unit(edge.edge.mtf50, edge.scale);
  return mtf50 ? frequency_text(mtf50->value, edge.scale.unit) : std::string("-");
}

std::vector<Figure> edge_figures(const MeasuredEdge& measured) {
  const EdgeMeasurement& edge = measured.edge;
  std::vector<Figure> figures(edge.distance_px.empty() ? 1 : 3);
  Figure& mtf = figures.back();
  mtf.title = "MTF50 " + mtf50_text(measured) + " " + std::string(unit_symbol(measured.scale.unit));
  mtf.x_label = "spatial frequency [" + std::string(unit_name(measured.scale.unit)) + "]";
  mtf.y_label = "MTF";
  // The name of the curve is all that the figure's CSV says of it.
  const bool pixels = measured.scale.unit == FrequencyUnit::cy_px;
  const std::string curve = pixels ? "MTF" : "MTF over " + std::string(unit_symbol(measured.scale.unit));
  mtf.series.push_back(with_band(edge.mtf_sd.empty() ? curve : curve + ", 2 sd",
                                 in_unit(edge.frequency_cy_px, measured.scale), edge.mtf, edge.mtf_sd));
  mtf.vertical_lines.push_back({0.5 * measured.scale.per_cy_px, "Nyquist"});
  if (edge.mtf50) mtf.vertical_lines.push_back({edge.mtf50->value * measured.scale.per_cy_px, "MTF50"});
  mtf.y_low = 0.0;
  if (figures.size() == 1) return figures;

  Figure& esf = figures[0];
  esf.title = one_line(measured.image);
  esf.x_label = "distance from the edge [pixels]";
  esf.y_label = "edge spread function";
  esf.series.push_back(with_band("ESF, 2 sd", edge.distance_px, edge.esf, edge.esf_sd));
  Figure& lsf = figures[1];
  lsf.x_label = esf.x_label;
  lsf.y_label = "line spread function [1/pixel]";
  lsf.series.push_back({.name = "LSF", .x = edge.distance_px, .y = edge.lsf, .emphasised = true});
  const double shown = std::min(kShown_px, edge.distance_px.back());
  esf.x_range = lsf.x_range = {-shown, shown};
  return figures;
}

std::vector<Figure> field_map(const MeasureReport& report) {
  constexpr std::size_t kMostWords = 40;  // beside places: more would cover each other
  std::vector<Figure> maps;
  double low = std::numeric_limits<double>::infinity(), high = -low, width = 0.0, height = 0.0;
  for (const MeasuredEdge& edge : report.edges) {
    const auto mtf50 = in_unit(edge.edge.mtf50, edge.scale);
    if (!mtf50) continue;
    low = std::min(low, mtf50->value);
    high = std::max(high, mtf50->value);
    width = std::max(width, static_cast<double>(edge.place.width_px));
    height = std::max(height, static_cast<double>(edge.place.height_px));
  }
  if (low > high) return maps;
  for (const char* direction : {"sagittal", "tangential", ""}) {
    const bool between = *direction == '\0';
    Series series{.name = between ? "between" : direction, .mark = Mark::large_points};
    for (const MeasuredEdge& edge : report.edges) {
      if (!edge.edge.mtf50 || edge.place.direction != direction) continue;
      series.x.push_back(edge.edge.curve.origin.x);
      series.y.push_back(edge.edge.curve.origin.y);
      series.value.push_back(edge.edge.mtf50->value * edge.scale.per_cy_px);
    }
    if (between && series.x.empty()) continue;  // the two that a map is for are always there
    if (series.x.size() <= kMostWords)
      for (const double value : series.value) series.words.push_back(frequency_text(value, report.unit));
    Figure& map = maps.emplace_back();
    map.title = "MTF50, " + (between ? std::string("edges between the two") : series.name + " edges");
    map.x_label = "x [pixels]";
    map.y_label = "y, downwards [pixels]";
    map.x_range = {0.0, width};
    map.y_low = height;
    map.y_high = 0.0;
    map.equal_axes = true;
    map.colour_range = {low, high > low ? high : low + 0.01};
    map.colour_label = "MTF50 [" + std::string(unit_name(report.unit)) + "]";
    map.series.push_back(std::move(series));
  }
  return maps;
}

std::string field_map_csv(const MeasureReport& report) {
  std::string text =
      "edge,image,channel,direction,x_px,y_px,field_x_px,field_y_px,field_radius_px,mtf50,mtf50_sd,frequency_unit\n";
  for (std::size_t i = 0; i < report.edges.size(); ++i) {
    const MeasuredEdge& edge = report.edges[i];
    const auto mtf50 = in_unit(edge.edge.mtf50, edge.scale);
    if (!mtf50) continue;
    text += std::to_string(i + 1) + "," + csv_field(edge.image) + "," + csv_field(edge.channel) + "," +
            edge.place.direction;
    for (const double value : {edge.edge.curve.origin.x, edge.edge.curve.origin.y, edge.place.x_px, edge.place.y_px,
                               edge.place.radius_px, mtf50->value, mtf50->sd})
      text += "," + csv_number(value);
    text += "," + std::string(unit_symbol(report.unit)) + "\n";
  }
  return text;
}

}  // namespace apps
