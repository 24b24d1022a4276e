// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measured edges as table, CSV, JSON and figures. Every frequency in them is in the unit that they name.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/edges/edge_input.h"
#include "apps/figures/plot.h"
#include "apps/text/frequency_unit.h"
#include "calib/iso12233/iso12233_difference.h"
#include "calib/measure/measure.h"

namespace apps {

/// Where an edge lies in the field: from the image's centre.
struct FieldPlace {
  double x_px = 0.0, y_px = 0.0;
  double radius_px = 0.0;
  std::int64_t width_px = 0, height_px = 0;  ///< of the image
  /// The MTF across lines along the radius is sagittal, across lines at right angles to it tangential; between 30 and
  /// 60 degrees, and at the centre, neither.
  std::string direction;
};
FieldPlace field_place(const calib::EdgeMeasurement& edge, std::int64_t width, std::int64_t height);

/// What ISO 12233 gives for the same region, and why it differs where there is a result.
struct MethodComparison {
  calib::Iso12233Result result;
  std::optional<calib::Iso12233Difference> difference;
};

/// From the same edge in another plane of the image, along the normal (apps/edges/edge_measure.h).
struct LateralShift {
  std::string from;    ///< the other plane
  calib::Estimate px;  ///< positive along the normal that angle_deg gives
};

struct MeasuredEdge {
  std::string image, channel, name{};
  Linearisation linearisation;
  double quantum = 0.0;  ///< linear step between neighbouring stored values, in the middle of their range; 0 = none
  calib::EdgeMeasurement edge{};
  FieldPlace place{};
  FrequencyScale scale{};                                      ///< unit of the frequencies that are shown
  std::vector<std::optional<calib::Estimate>> at_contrasts{};  ///< cycles per pixel, of MeasureReport::further
  std::optional<MethodComparison> standard{};                  ///< where both methods were asked for
  std::optional<LateralShift> shift{};                         ///< where another plane has the same edge
};

/// An image that could not be used at all.
struct FailedImage {
  std::string image, reason;
};

/// Edges of a plane that were found and not measured (calib/find/find_edges.h).
struct LeftOutEdges {
  std::string image, channel;
  std::size_t usable = 0, not_tried = 0;
};

struct MeasureReport {
  std::string method;
  std::vector<MeasuredEdge> edges{};
  std::vector<LeftOutEdges> left_out{};
  std::vector<FailedImage> failed{};
  FrequencyUnit unit = FrequencyUnit::cy_px;
  std::vector<double> contrasts{};  ///< whose frequencies were asked for
  std::vector<double> further{};    ///< those of them that are no figures of every edge
};

/// The frequency of one contrast in the unit of the edge, be it a figure of every edge or one of `further`.
std::optional<calib::Estimate> at_contrast(const MeasuredEdge& edge, double contrast, std::span<const double> further);

/// "35" for 0.35.
std::string percent_text(double contrast);

/// A frequency in the unit of the edge.
std::optional<calib::Estimate> in_unit(const std::optional<calib::Estimate>& cy_px, const FrequencyScale& scale);
std::vector<double> in_unit(std::vector<double> cy_px, const FrequencyScale& scale);

/// Finds the frequencies of these contrasts in the measured curve. `absent` names those to which it does not fall.
void add_contrasts(MeasuredEdge& edge, std::span<const double> contrasts);

/// The contrasts without repetitions, and those of them that are no figures of every edge.
std::vector<double> without_repetitions(const std::vector<double>& asked);
std::vector<double> further_contrasts(const std::vector<double>& asked);

std::string measure_table(const MeasureReport& report);
/// A line an edge.
std::string measure_csv(const MeasureReport& report);
std::string measure_json(const MeasureReport& report);
/// A line a frequency or distance: edge,curve,x,value,sd. Where frequencies are not in cycles per pixel a column x_unit
/// follows, which `mtf fit` reads.
std::string curves_csv(const MeasureReport& report);

/// ESF, LSF and MTF of one edge, with bands of two standard deviations.
std::vector<Figure> edge_figures(const MeasuredEdge& edge);
/// Maps of the image's field: MTF50 by colour where the edges lie, a panel for sagittal ones, one for tangential ones
/// and, where there are any, one for those between; none when no edge has an MTF50.
std::vector<Figure> field_map(const MeasureReport& report);
/// The data of the maps: edge,image,channel,direction,x_px,y_px,field_x_px,field_y_px,field_radius_px,mtf50,
/// mtf50_sd,frequency_unit.
std::string field_map_csv(const MeasureReport& report);
/// A thick line with a band of two standard deviations; without one where there are none.
Series with_band(std::string name, const std::vector<double>& x, const std::vector<double>& y,
                 const std::vector<double>& sd);
/// MTF50 in the unit of the edge, "-" where there is none.
std::string mtf50_text(const MeasuredEdge& edge);

}  // namespace apps
