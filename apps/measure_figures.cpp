// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "apps/measure_report.h"
#include "apps/output.h"
#include "apps/text_table.h"

namespace apps {
namespace {

using calib::EdgeMeasurement;
using calib::Trouble;

constexpr mtf::io::Colour kRegionColour{90, 200, 255}, kEdgeColour{255, 210, 0}, kTroubleColour{255, 90, 60};
/// Distances from the edge that figures show.
constexpr double kShown_px = 8.0;

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

std::string mtf50_text(const EdgeMeasurement& edge) {
  return edge.mtf50 ? fixed(edge.mtf50->value, 3) : std::string("-");
}

}  // namespace

std::vector<Figure> edge_figures(const MeasuredEdge& measured) {
  const EdgeMeasurement& edge = measured.edge;
  std::vector<Figure> figures(edge.distance_px.empty() ? 1 : 3);
  Figure& mtf = figures.back();
  mtf.title = "MTF50 " + mtf50_text(edge) + " cy/px";
  mtf.x_label = "spatial frequency [cycles/pixel]";
  mtf.y_label = "MTF";
  mtf.series.push_back(
      with_band(edge.mtf_sd.empty() ? "MTF" : "MTF, 2 sd", edge.frequency_cy_px, edge.mtf, edge.mtf_sd));
  mtf.vertical_lines.push_back({0.5, "Nyquist"});
  if (edge.mtf50) mtf.vertical_lines.push_back({edge.mtf50->value, "MTF50"});
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
  const double reach = std::min(kShown_px, edge.distance_px.back());
  esf.x_range = lsf.x_range = {-reach, reach};
  return figures;
}

std::optional<Figure> field_map(std::span<const MeasuredEdge> edges) {
  Figure figure;
  figure.title = "MTF50 over the field";
  figure.x_label = "distance from the image's centre [pixels]";
  figure.y_label = "MTF50 [cycles/pixel]";
  for (const char* direction : {"sagittal", "tangential", ""}) {
    Series series{.name = *direction != '\0' ? direction : "between", .x = {}, .y = {}, .mark = Mark::points};
    for (const MeasuredEdge& edge : edges) {
      if (!edge.edge.mtf50 || edge.place.direction != direction) continue;
      series.x.push_back(edge.place.radius_px);
      series.y.push_back(edge.edge.mtf50->value);
    }
    if (!series.x.empty()) figure.series.push_back(std::move(series));
  }
  figure.y_low = 0.0;
  return figure.series.empty() ? std::nullopt : std::optional(figure);
}

mtf::io::Drawing edge_drawing(std::span<const MeasuredEdge> edges, std::int64_t width, std::int64_t height) {
  mtf::io::Drawing drawing;
  // Small images are enlarged so that words can be read.
  drawing.zoom = static_cast<int>(std::clamp<std::int64_t>(800 / std::max<std::int64_t>({width, height, 1}), 1, 8));
  int number = 0;
  for (const MeasuredEdge& measured : edges) {
    const EdgeMeasurement& edge = measured.edge;
    const std::string label = std::to_string(++number) + ": ";
    const bool good = edge.trouble == Trouble::none;
    const auto x0 = static_cast<double>(edge.roi.x), y0 = static_cast<double>(edge.roi.y);
    const double x1 = x0 + static_cast<double>(edge.roi.width), y1 = y0 + static_cast<double>(edge.roi.height);
    const mtf::io::Colour colour = good ? kRegionColour : kTroubleColour;
    drawing.strokes.push_back({{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}, {x0, y0}}, colour});
    const double margin = 4.0 / drawing.zoom, line = 14.0 / drawing.zoom;
    if (!good) {
      drawing.captions.push_back(
          {x0 + margin, y0 + line, label + std::string(trouble_name(edge.trouble)), kTroubleColour});
      continue;
    }
    const calib::Point n = edge.curve.normal();
    mtf::io::Stroke stroke{{}, kEdgeColour};
    for (int i = -32; i <= 32; ++i) {
      const double s = 0.5 * edge.length_px * i / 32.0;
      const double u = offset_at(edge.curve, s);
      stroke.points.push_back({edge.curve.origin.x - s * n.y + u * n.x, edge.curve.origin.y + s * n.x + u * n.y});
    }
    drawing.strokes.push_back(std::move(stroke));
    drawing.captions.push_back({x0 + margin, y0 + line, label + "MTF50 " + mtf50_text(edge), kEdgeColour});
  }
  return drawing;
}

}  // namespace apps
