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

/// The figures of one line, for edges of a direction or of all ("").
std::string line_of(std::span<const MeasuredEdge> edges, const std::string& direction) {
  std::vector<Estimate> mtf50;
  std::size_t count = 0, measured = 0;
  for (const MeasuredEdge& edge : edges) {
    const bool good = edge.edge.trouble == calib::Trouble::none;
    if (!direction.empty() && !(good && edge.place.direction == direction)) continue;
    ++count;
    measured += good ? 1 : 0;
    if (const auto figure = in_unit(edge.edge.mtf50, edge.scale)) mtf50.push_back(*figure);
  }
  if (count == 0) return "";
  const MeasuredEdge& first = edges.front();
  const double refused = static_cast<double>(count - measured) / static_cast<double>(count);
  std::string text = csv_field(first.image) + "," + csv_field(first.channel) + "," +
                     (direction.empty() ? "all" : direction) + "," + std::to_string(count) + "," +
                     std::to_string(measured) + "," + (direction.empty() ? csv_number(refused) : "");
  if (mtf50.empty()) {
    text += ",,,,";
  } else {
    const auto [best, median] = best_and_median(std::move(mtf50));
    for (const double value : {best.value, best.sd, median.value, median.sd}) text += "," + csv_number(value);
  }
  const std::string reason = direction.empty() && measured == 0 ? first.edge.reason : "";
  return text + "," + std::string(unit_symbol(first.scale.unit)) + "," + csv_field(reason) + "\n";
}

}  // namespace

std::string image_table(const MeasureReport& report) {
  std::string text =
      "image,channel,direction,edges,measured,refused_share,mtf50_best,mtf50_best_sd,mtf50_median,mtf50_median_sd,"
      "frequency_unit,reason\n";
  for (auto begin = report.edges.begin(); begin != report.edges.end();) {
    const auto end = std::find_if(begin, report.edges.end(), [&](const MeasuredEdge& edge) {
      return edge.image != begin->image || edge.channel != begin->channel;
    });
    for (const char* direction : {"", "sagittal", "tangential"}) text += line_of({begin, end}, direction);
    begin = end;
  }
  for (const FailedImage& failed : report.failed)
    text += csv_field(failed.image) + ",,all,0,0,,,,,," + std::string(unit_symbol(report.unit)) + "," +
            csv_field(failed.reason) + "\n";
  return text;
}

}  // namespace apps
