// SPDX-License-Identifier: Apache-2.0

// `mtf measure`: MTF and figures of merit of the edges in images.

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "apps/edges/annotated_image.h"
#include "apps/edges/edge_measure.h"
#include "apps/edges/edge_merits.h"
#include "apps/edges/lateral_shift.h"
#include "apps/edges/measure_report.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

// A series of images as a table, for through-focus curves and for a lens over its field: what the edges of each image
// say together.

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

/// A line for all edges of an image and channel, and one for those of its edges that are sagittal and tangential, if
/// any: image,channel,direction,edges,measured,refused_share,mtf50_best,mtf50_best_sd,mtf50_median,mtf50_median_sd,
/// then the same four columns for each of the report's contrasts (mtf20_best, ...), frequency_unit,reason. Edges count
/// as refused where they gave no result; they have no direction. The deviation of the median is that of the edge in the
/// middle, or of the mean of the two there: an upper limit, as nothing is assumed of how alike the edges are. The best
/// of many noisy values is above the best edge.
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

std::vector<std::string> outputs_of(const MeasureOptions& options) {
  std::vector<std::string> outputs;
  if (options.out != "-") outputs.push_back(options.out);
  outputs.push_back(options.table);
  outputs.push_back(options.curves);
  for (const std::string& figure : {options.plot, options.map}) {
    if (figure.empty()) continue;
    check_figure_path(figure);
    outputs.push_back(figure);
    outputs.push_back(figure_data_path(figure));
  }
  outputs.push_back(options.annotate);
  std::erase(outputs, "");
  if (!options.annotate.empty() && mtf::io::format_from_extension(options.annotate) != mtf::io::Format::png)
    throw mtf::UsageError(options.annotate + ": annotated images are PNG; end the name in .png");
  return outputs;
}

void write_figures_of(const MeasureOptions& options, const MeasureReport& report, OutputSet& outputs,
                      const Global& global) {
  const auto drawn = [&](bool made, const std::string& path) {
    note(global, made ? "wrote " + one_line(path) + " and its data " + one_line(figure_data_path(path))
                      : "mtf: note: gnuplot is not installed (Debian package gnuplot-nox): wrote only the data, " +
                            one_line(figure_data_path(path)));
  };
  if (!options.plot.empty()) {
    const auto best = std::find_if(report.edges.begin(), report.edges.end(),
                                   [](const MeasuredEdge& e) { return e.edge.trouble == calib::Trouble::none; });
    if (best == report.edges.end())
      note(global, "mtf: note: no edge was measured: no figure " + one_line(options.plot));
    else
      drawn(write_figures(outputs.at(options.plot), edge_figures(*best)), options.plot);
  }
  if (!options.map.empty()) {
    const std::vector<Figure> map = field_map(report);
    if (map.empty())
      note(global, "mtf: note: no edge has an MTF50: no map " + one_line(options.map));
    else
      drawn(write_figures(outputs.at(options.map), map, field_map_csv(report)), options.map);
  }
}

/// What is wrong with a file, less its name in front.
std::string without_name(std::string message, const std::string& file) {
  const std::string name = one_line(file) + ": ";
  return message.starts_with(name) ? message.substr(name.size()) : message;
}

/// What the file says of its pixels against --pitch; "" where the two agree to the digits that a user writes.
std::string pitch_note(const EdgePlane& plane, std::optional<double> pitch_um) {
  if (!pitch_um || !plane.stated_pitch_um) return "";
  const auto& [x, y] = *plane.stated_pitch_um;
  constexpr double kRounding = 1e-3;
  if (std::abs(x / *pitch_um - 1.0) <= kRounding && std::abs(y / *pitch_um - 1.0) <= kRounding) return "";
  return one_line(plane.image) + " states samples of " + mtf::format_double(x) + " x " + mtf::format_double(y) +
         " um, --pitch says " + mtf::format_double(*pitch_um) + " um, which is what the frequencies are made with";
}

std::string_view method_name(MeasureMethod method) {
  if (method == MeasureMethod::both) return "both";
  return method == MeasureMethod::iso12233 ? "iso12233" : "regression";
}

std::string formatted(const MeasureReport& report, Format format) {
  if (format == Format::csv) return measure_csv(report);
  return format == Format::json ? measure_json(report) : measure_table(report);
}

}  // namespace

int run_measure(const MeasureOptions& options, const Global& global) {
  OutputSet outputs({.files = outputs_of(options), .inputs = files_of(options.input)});
  if (options.method != MeasureMethod::regression && options.circle)
    throw mtf::UsageError("--circle: ISO 12233 knows polynomials only; leave out one of the two");
  const auto scale_of = [&options](std::int64_t rows) {
    return frequency_scale(options.unit, options.pitch_um, options.focal_length_mm, rows);
  };
  static_cast<void>(scale_of(1));  // what the unit lacks is said before any image is read
  MeasureReport report{.method = std::string(method_name(options.method)),
                       .edges = {},
                       .left_out = {},
                       .failed = {},
                       .unit = options.unit,
                       .contrasts = without_repetitions(options.contrasts),
                       .further = further_contrasts(options.contrasts)};
  std::erase(report.contrasts, 0.5);  // MTF50 is in every table
  const std::vector<std::string>& images = options.input.images;
  ProgressLine progress(global);
  for (std::size_t i = 0; i < images.size(); ++i) {
    progress.update("measuring", static_cast<double>(i) / static_cast<double>(images.size()));
    try {
      bool first = i == 0, told = false;
      const std::size_t before = report.edges.size();
      for (const EdgePlane& plane : load_edge_planes(images[i], options.input)) {
        if (!plane.warning.empty()) note(global, "mtf: warning: " + plane.warning);
        for (const std::string& remark : plane.notes) note(global, "mtf: note: " + remark);
        if (const std::string remark = pitch_note(plane, options.pitch_um); !remark.empty() && !told)
          note(global, "mtf: warning: " + remark);
        told = true;
        if (plane.left_out + plane.not_tried > 0)
          report.left_out.push_back({images[i], plane.channel, plane.left_out, plane.not_tried});
        const EdgeMethod method{.order = options.order, .circle = options.circle, .method = options.method};
        std::vector<MeasuredEdge> edges = measure_plane(plane, method, global.threads);
        for (MeasuredEdge& edge : edges) {
          edge.scale = scale_of(plane.plane.height());
          add_contrasts(edge, report.further);
        }
        if (first && !options.annotate.empty()) write_annotated_image(outputs.at(options.annotate), plane.plane, edges);
        first = false;
        std::move(edges.begin(), edges.end(), std::back_inserter(report.edges));
      }
      add_lateral_shifts(std::span(report.edges).subspan(before));
    } catch (const mtf::Error& error) {
      if (images.size() == 1) throw;
      report.failed.push_back({images[i], without_name(error.what(), images[i])});
    }
  }
  progress.update("measuring", 1.0);
  write_figures_of(options, report, outputs, global);
  if (!options.table.empty()) emit(outputs.at(options.table), image_table(report));
  if (!options.curves.empty()) emit(outputs.at(options.curves), curves_csv(report));
  outputs.commit(options.out, formatted(report, options.format));

  const auto measured = std::count_if(report.edges.begin(), report.edges.end(),
                                      [](const MeasuredEdge& e) { return e.edge.trouble == calib::Trouble::none; });
  if (images.size() > 1) {
    std::set<std::string> with_edges;
    for (const MeasuredEdge& edge : report.edges)
      if (edge.edge.trouble == calib::Trouble::none) with_edges.insert(edge.image);
    note(global, "measured " + std::to_string(measured) + " edges in " + std::to_string(with_edges.size()) + " of " +
                     std::to_string(images.size()) + " images");
  }
  return measured > 0 && report.failed.empty() ? 0 : 1;
}

}  // namespace apps
