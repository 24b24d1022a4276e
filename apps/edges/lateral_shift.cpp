// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/lateral_shift.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "apps/terminal/text_table.h"

namespace apps {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

bool is_green(const std::string& channel) {
  const std::size_t last = channel.rfind('.') + 1;  // 0 without a point
  return last < channel.size() && (channel[last] == 'G' || channel[last] == 'g');
}

bool measured(const MeasuredEdge& edge) {
  return edge.edge.trouble == calib::Trouble::none && edge.edge.location_sd_px.has_value();
}

/// The location of `edge` from that of `reference`, along the normal of `edge` as angle_deg gives it.
std::optional<calib::Estimate> shift_between(const calib::EdgeMeasurement& edge,
                                             const calib::EdgeMeasurement& reference) {
  constexpr double kMostTurn_deg = 2.0, kMost_px = 5.0;
  // Charts have thousands of edges in each plane: most pairs are ruled out by where they are, before the search for the
  // foot on the curve.
  const double away_px =
      std::hypot(edge.curve.origin.x - reference.curve.origin.x, edge.curve.origin.y - reference.curve.origin.y);
  if (away_px > 2.0 * (reference.curve.half_length_px + kMost_px)) return std::nullopt;
  const double turn_deg = std::remainder(edge.angle_deg.value - reference.angle_deg.value, 180.0);
  if (std::abs(turn_deg) > kMostTurn_deg) return std::nullopt;
  const calib::EdgePoint place = calib::locate(reference.curve, edge.curve.origin);
  if (std::abs(place.distance_px) > kMost_px || std::abs(place.along_px) > reference.curve.half_length_px)
    return std::nullopt;
  const calib::Point n = reference.curve.normal();
  const double angle = edge.angle_deg.value * kRadPerDeg;
  const double sign = n.x * std::cos(angle) + n.y * std::sin(angle) < 0.0 ? -1.0 : 1.0;
  const double turned_sd_px = place.along_px * reference.angle_deg.sd * kRadPerDeg;
  return calib::Estimate{sign * place.distance_px,
                         std::hypot(*edge.location_sd_px, *reference.location_sd_px, turned_sd_px)};
}

}  // namespace

void add_lateral_shifts(std::span<MeasuredEdge> edges) {
  if (edges.empty()) return;
  const auto green = std::ranges::find_if(edges, [](const MeasuredEdge& edge) { return is_green(edge.channel); });
  const std::string reference = green != edges.end() ? green->channel : edges.front().channel;
  std::vector<const calib::EdgeMeasurement*> partners;
  for (const MeasuredEdge& edge : edges)
    if (edge.channel == reference && measured(edge)) partners.push_back(&edge.edge);
  for (MeasuredEdge& edge : edges) {
    if (edge.channel == reference || !measured(edge)) continue;
    for (const calib::EdgeMeasurement* partner : partners) {
      const auto shift = shift_between(edge.edge, *partner);
      if (shift && (!edge.shift || std::abs(shift->value) < std::abs(edge.shift->px.value)))
        edge.shift = LateralShift{reference, *shift};
    }
  }
}

std::string lateral_shift_table(const MeasureReport& report) {
  TextTable table({"edge", "plane", "from", "normal [deg]", "shift [px]"});
  bool any = false;
  for (std::size_t i = 0; i < report.edges.size(); ++i) {
    const MeasuredEdge& edge = report.edges[i];
    if (!edge.shift) continue;
    any = true;
    table.add({std::to_string(i + 1), one_line(edge.channel), one_line(edge.shift->from),
               fixed(edge.edge.angle_deg.value, 2),
               fixed(edge.shift->px.value, 4) + " +- " + fixed(edge.shift->px.sd, 4)});
  }
  if (!any) return "";
  return "\nLateral colour: shift of the edge along its normal from the same edge in another plane\n" +
         table.aligned({Align::right, Align::left, Align::left, Align::right, Align::right});
}

std::string lateral_shift_header(const MeasureReport& report) {
  const bool any = std::any_of(report.edges.begin(), report.edges.end(),
                               [](const MeasuredEdge& edge) { return edge.shift.has_value(); });
  return any ? ",lateral_shift_px,lateral_shift_px_sd,lateral_shift_from" : "";
}

std::string lateral_shift_columns(const MeasuredEdge& edge) {
  if (!edge.shift) return ",,,";
  return "," + csv_number(edge.shift->px.value) + "," + csv_number(edge.shift->px.sd) + "," +
         csv_field(edge.shift->from);
}

}  // namespace apps
