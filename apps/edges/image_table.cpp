// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/image_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/edges/edge_merits.h"
#include "apps/terminal/text_table.h"

namespace apps {
namespace {

using calib::Estimate;

/// The columns of a contrast that no edge has a frequency of.
constexpr const char* kNoFigures = ",,,,";

struct BestAndMedian {
  Estimate best, median;
};

/// Of at least one value.
BestAndMedian best_and_median(std::vector<Estimate> values) {
  std::sort(values.begin(), values.end(), [](const Estimate& a, const Estimate& b) { return a.value < b.value; });
  const Estimate &upper = values[values.size() / 2], &lower = values[(values.size() - 1) / 2];
  const double sd = &upper == &lower ? upper.sd : 0.5 * std::hypot(upper.sd, lower.sd);
  return {values.back(), {0.5 * (upper.value + lower.value), sd}};
}

/// The contrasts whose frequencies the table has.
std::vector<double> contrasts_of(const MeasureReport& report) {
  std::vector<double> contrasts{0.5};
  contrasts.insert(contrasts.end(), report.contrasts.begin(), report.contrasts.end());
  return contrasts;
}

/// The figures of one line, for edges of a direction or of all ("").
std::string line_of(const MeasureReport& report, std::span<const MeasuredEdge> edges, const std::string& direction) {
  const std::vector<double> contrasts = contrasts_of(report);
  std::vector<std::vector<Estimate>> frequencies(contrasts.size());
  std::size_t count = 0, measured = 0;
  for (const MeasuredEdge& edge : edges) {
    const bool good = edge.edge.trouble == calib::Trouble::none;
    if (!direction.empty() && !(good && edge.place.direction == direction)) continue;
    ++count;
    measured += good ? 1 : 0;
    for (std::size_t i = 0; i < contrasts.size(); ++i)
      if (const auto figure = at_contrast(edge, contrasts[i], report.further)) frequencies[i].push_back(*figure);
  }
  if (count == 0) return "";
  const MeasuredEdge& first = edges.front();
  const double refused = static_cast<double>(count - measured) / static_cast<double>(count);
  std::string text = csv_field(first.image) + "," + csv_field(first.channel) + "," +
                     (direction.empty() ? "all" : direction) + "," + std::to_string(count) + "," +
                     std::to_string(measured) + "," + (direction.empty() ? csv_number(refused) : "");
  for (std::vector<Estimate>& values : frequencies) {
    if (values.empty()) {
      text += kNoFigures;
      continue;
    }
    const auto [best, median] = best_and_median(std::move(values));
    for (const double value : {best.value, best.sd, median.value, median.sd}) text += "," + csv_number(value);
  }
  const std::string reason = direction.empty() && measured == 0 ? first.edge.reason : "";
  return text + "," + std::string(unit_symbol(first.scale.unit)) + "," + csv_field(reason) + "\n";
}

}  // namespace

std::string image_table(const MeasureReport& report) {
  std::string text = "image,channel,direction,edges,measured,refused_share", no_figures;
  for (const double contrast : contrasts_of(report)) {
    const std::string name = ",mtf" + percent_text(contrast);
    text += name + "_best" + name + "_best_sd" + name + "_median" + name + "_median_sd";
    no_figures += kNoFigures;
  }
  text += ",frequency_unit,reason\n";
  for (auto begin = report.edges.begin(); begin != report.edges.end();) {
    const auto end = std::find_if(begin, report.edges.end(), [&](const MeasuredEdge& edge) {
      return edge.image != begin->image || edge.channel != begin->channel;
    });
    for (const char* direction : {"", "sagittal", "tangential"}) text += line_of(report, {begin, end}, direction);
    begin = end;
  }
  for (const FailedImage& failed : report.failed)
    text += csv_field(failed.image) + ",,all,0,0," + no_figures + "," + std::string(unit_symbol(report.unit)) + "," +
            csv_field(failed.reason) + "\n";
  return text;
}

}  // namespace apps
