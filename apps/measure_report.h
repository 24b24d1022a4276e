// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measured edges as table, CSV, JSON and figures.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/plot.h"
#include "calib/measure.h"
#include "mtf/io/drawing.h"

namespace apps {

/// Where an edge lies in the field: from the image's centre.
struct FieldPlace {
  double x_px = 0.0, y_px = 0.0;
  double radius_px = 0.0;
  /// The MTF across lines along the radius is sagittal, across lines at right angles to it tangential; between 30 and
  /// 60 degrees, and at the centre, neither.
  std::string direction;
};
FieldPlace field_place(const calib::EdgeMeasurement& edge, std::int64_t width, std::int64_t height);

struct MeasuredEdge {
  std::string image, channel, name;
  calib::EdgeMeasurement edge;
  FieldPlace place;
};

/// An image that could not be used at all.
struct FailedImage {
  std::string image, reason;
};

struct MeasureReport {
  std::string method;
  std::vector<MeasuredEdge> edges;
  std::vector<FailedImage> failed;
};

std::string measure_table(const MeasureReport& report);
/// A line an edge.
std::string measure_csv(const MeasureReport& report);
std::string measure_json(const MeasureReport& report);
/// A line a frequency or distance: edge,curve,x,value,sd.
std::string curves_csv(const MeasureReport& report);

/// ESF, LSF and MTF of one edge, with bands of two standard deviations.
std::vector<Figure> edge_figures(const MeasuredEdge& edge);
/// MTF50 against the distance from the image's centre; nothing when no edge has one.
std::optional<Figure> field_map(std::span<const MeasuredEdge> edges);
/// Regions, edges and their MTF50.
mtf::io::Drawing edge_drawing(std::span<const MeasuredEdge> edges, std::int64_t width, std::int64_t height);

}  // namespace apps
