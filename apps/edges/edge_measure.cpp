// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/edge_measure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/text/message_words.h"
#include "calib/iso12233/iso12233_difference.h"
#include "mtf/parallel.h"

namespace apps {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The same fields as of the regression; what that method does not know stays empty.
calib::EdgeMeasurement as_measurement(const calib::Iso12233Result& result, const calib::Roi& roi) {
  calib::EdgeMeasurement edge;
  edge.roi = roi;
  edge.trouble = result.trouble;
  edge.reason = result.reason;
  edge.warnings = result.warnings;
  edge.curve.origin = {static_cast<double>(roi.x) + 0.5 * static_cast<double>(roi.width),
                       static_cast<double>(roi.y) + 0.5 * static_cast<double>(roi.height)};
  edge.curve.angle_rad = result.angle_deg * std::numbers::pi / 180.0;
  edge.angle_deg = {result.angle_deg, kUnknown};
  for (double* unknown : {&edge.length_px, &edge.sagitta_px, &edge.dark, &edge.bright, &edge.noise_sd, &edge.noise_gain,
                          &edge.cnr, &edge.oversampling, &edge.chi2_per_dof})
    *unknown = kUnknown;
  edge.clipped_share = result.clipped_share;
  edge.frequency_cy_px = result.frequency_cy_px;
  edge.mtf = result.sfr;
  const auto figure = [&](const char* name, const std::optional<double>& value, const char* why) {
    if (!value && result.trouble == calib::Trouble::none) edge.absent.emplace_back(name, why);
    return value ? std::optional(calib::Estimate{*value, kUnknown}) : std::nullopt;
  };
  edge.mtf50 = figure("mtf50", result.mtf50, "the curve does not fall to 50 %");
  edge.mtf10 = figure("mtf10", result.mtf10, "the curve does not fall to 10 %");
  const auto fall = [&edge](double contrast) {
    const auto frequency = calib::frequency_at(edge, contrast);
    return frequency ? std::optional(frequency->value) : std::nullopt;
  };
  edge.mtf20 = figure("mtf20", fall(0.2), "the curve does not fall to 20 %");
  edge.mtf30 = figure("mtf30", fall(0.3), "the curve does not fall to 30 %");
  if (!edge.mtf.empty())
    edge.mtf50p = figure("mtf50p", fall(0.5 * *std::max_element(edge.mtf.begin(), edge.mtf.end())),
                         "the curve does not fall to half of its peak");
  edge.nyquist = figure("nyquist", result.nyquist, "the curve ends before 0.5 cycles/pixel");
  edge.sampling_efficiency =
      figure("sampling_efficiency", result.sampling_efficiency, "the curve does not fall to 10 %");
  return edge;
}

calib::Iso12233Result measure_by_standard(const EdgePlane& plane, const calib::Roi& roi, const EdgeMethod& method) {
  return calib::measure_iso12233(plane.plane.view(), roi, {.order = method.order.value_or(5), .image = plane.options});
}

calib::EdgeMeasurement measure(const EdgePlane& plane, const calib::Roi& roi, const EdgeMethod& method) {
  const mtf::Image& image = plane.plane;
  if (roi.x < 0 || roi.y < 0 || roi.x > image.width() - roi.width || roi.y > image.height() - roi.height) {
    calib::EdgeMeasurement outside;
    outside.roi = roi;
    outside.trouble = calib::Trouble::off_region;
    outside.reason = "the region leaves the image of " + std::to_string(image.width()) + " x " +
                     std::to_string(image.height()) + " pixels: give one inside";
    return outside;
  }
  if (method.method == MeasureMethod::iso12233) return as_measurement(measure_by_standard(plane, roi, method), roi);
  calib::MeasureOptions how = plane.options;
  how.order = method.order;
  how.circle = method.circle;
  return calib::measure_edge(image.view(), roi, how);
}

/// Of a JPEG whose rounding is not small against the noise: see "JPEG" in calib/README.md.
void warn_of_jpeg(MeasuredEdge& edge) {
  const double rounding = edge.linearisation.dct_rounding_sd * edge.quantum;
  if (!(rounding > edge.edge.noise_sd)) return;
  edge.edge.warnings.push_back(
      "JPEG: the rounding of its cosine coefficients changes pixels by up to " + significant(rounding, 2) +
      " rms, more than the noise of " + significant(edge.edge.noise_sd, 2) +
      ": standard deviations may be 1.3 to 4 times too small, and contrast near Nyquist may be "
      "lost; take a higher quality or the raw image");
}

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

std::vector<MeasuredEdge> measure_plane(const EdgePlane& plane, const EdgeMethod& method, int threads) {
  const MeasuredEdge blank{.image = plane.image,
                           .channel = plane.channel,
                           .linearisation = plane.linearisation,
                           .quantum = plane.options.quantum};
  std::vector<MeasuredEdge> edges(std::max<std::size_t>(1, plane.regions.size()), blank);
  if (plane.regions.empty()) {
    edges.front().edge.roi = {0, 0, plane.plane.width(), plane.plane.height()};
    edges.front().edge.trouble = calib::Trouble::no_edge;
    edges.front().edge.reason = plane.reason;
    return edges;
  }
  mtf::parallel_for(std::ssize(edges), 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      edges[i].name = plane.regions[i].name;
      edges[i].edge = measure(plane, plane.regions[i].roi, method);
      if (edges[i].edge.trouble != calib::Trouble::none) continue;
      edges[i].place = field_place(edges[i].edge, plane.plane.width(), plane.plane.height());
      warn_of_jpeg(edges[i]);
      if (method.method != MeasureMethod::both) continue;
      MethodComparison& both = edges[i].standard.emplace();
      both.result = measure_by_standard(plane, plane.regions[i].roi, method);
      if (both.result.trouble == calib::Trouble::none)
        both.difference = calib::explain_difference(edges[i].edge, both.result);
    }
  });
  return edges;
}

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

}  // namespace apps
