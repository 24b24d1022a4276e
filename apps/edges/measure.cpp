// SPDX-License-Identifier: Apache-2.0

// `mtf measure`: MTF and figures of merit of the edges in images.

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "apps/edges/edge_measure.h"
#include "apps/edges/measure_report.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/message_words.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/image.h"
#include "mtf/io/codecs/drawing.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

// The image with its edges drawn upon it, for the eye: regions, edges and their MTF50, and below the image what the
// colours and grey values stand for, with a scale of the image's pixels.

using calib::Trouble;
using mtf::io::Colour;

constexpr Colour kRegionColour{90, 200, 255}, kEdgeColour{255, 210, 0}, kTroubleColour{255, 90, 60},
    kText{235, 235, 235};

/// The whole number 1, 2 or 5 x 10^n next below.
double round_length(double length) {
  const double decade = std::pow(10.0, std::floor(std::log10(length)));
  const double digit = length / decade;
  return std::max(1.0, decade * (digit < 2.0 ? 1.0 : digit < 5.0 ? 2.0 : 5.0));
}

void draw_edges(std::span<const MeasuredEdge> edges, mtf::io::Drawing& drawing) {
  int number = 0;
  for (const MeasuredEdge& measured : edges) {
    const calib::EdgeMeasurement& edge = measured.edge;
    const std::string label = std::to_string(++number) + ": ";
    const bool good = edge.trouble == Trouble::none;
    const auto x0 = static_cast<double>(edge.roi.x), y0 = static_cast<double>(edge.roi.y);
    const double x1 = x0 + static_cast<double>(edge.roi.width), y1 = y0 + static_cast<double>(edge.roi.height);
    const Colour colour = good ? kRegionColour : kTroubleColour;
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
    const FrequencyUnit unit = measured.scale.unit;
    const std::string symbol = unit == FrequencyUnit::cy_px ? "" : " " + std::string(unit_symbol(unit));
    drawing.captions.push_back({x0 + margin, y0 + line, label + "MTF50 " + mtf50_text(measured) + symbol, kEdgeColour});
  }
}

/// Samples with words below an image, from left to right and then in the next line. Lengths are pixels of the picture.
class Legend {
 public:
  Legend(std::int64_t top_px, double width, mtf::io::Drawing& drawing)
      : drawing_(&drawing), width_(width), y_(static_cast<double>(top_px * drawing.zoom) + kLine) {}

  void line(Colour colour, double length, bool ends, const std::string& words) {
    start(length, words);
    draw({{x_, y_}, {x_ + length, y_}}, colour);
    if (ends)
      for (const double x : {x_, x_ + length}) draw({{x, y_ - kHalfBar}, {x, y_ + kHalfBar}}, colour);
    write(length, words);
  }
  void greys(const std::string& words) {
    constexpr int kLength = 64;
    start(kLength, words);
    for (int i = 0; i < kLength; ++i) {
      const auto grey = static_cast<std::uint8_t>(255 * i / (kLength - 1));
      draw({{x_ + i, y_ - kHalfBar}, {x_ + i, y_ + kHalfBar}}, {grey, grey, grey});
    }
    draw({{x_, y_ - kHalfBar},
          {x_ + kLength, y_ - kHalfBar},
          {x_ + kLength, y_ + kHalfBar},
          {x_, y_ + kHalfBar},
          {x_, y_ - kHalfBar}},
         kText);
    write(kLength, words);
  }
  /// Rows of the image that hold it all.
  std::int64_t bottom_px() const { return static_cast<std::int64_t>(std::ceil((y_ + kLine) / drawing_->zoom)); }

 private:
  static constexpr double kLine = 18.0, kMargin = 8.0, kGap = 6.0, kHalfBar = 5.0, kLetter = 7.2, kCapital = 9.0;

  void start(double length, const std::string& words) {
    const double all = length + kGap + kLetter * static_cast<double>(words.size());
    if (next_ > kMargin && next_ + all + kMargin > width_) next_ = kMargin, y_ += kLine;
    x_ = next_;
    next_ += all + 3.0 * kMargin;
  }
  void draw(std::vector<std::array<double, 2>> points, Colour colour) {
    for (auto& [x, y] : points) x /= drawing_->zoom, y /= drawing_->zoom;
    drawing_->strokes.push_back({std::move(points), colour});
  }
  void write(double length, const std::string& words) {
    const double zoom = drawing_->zoom;
    drawing_->captions.push_back({(x_ + length + kGap) / zoom, (y_ + 0.5 * kCapital) / zoom, words, kText});
  }

  mtf::io::Drawing* drawing_;
  double width_, x_ = 0.0, y_ = 0.0, next_ = kMargin;
};

/// Writes a PNG, whole or not at all.
void write_annotated_image(const std::string& path, const mtf::Image& image, std::span<const MeasuredEdge> edges) {
  constexpr double kLeastWidth = 352.0, kScale = 100.0;  // pixels of the picture
  constexpr float kGround = 0.1F;                        // grey value behind the legend
  mtf::io::Drawing drawing;
  // Small images are enlarged so that words can be read.
  const std::int64_t longest = std::max<std::int64_t>({image.width(), image.height(), 1});
  drawing.zoom = static_cast<int>(std::clamp<std::int64_t>(800 / longest, 1, 8));
  draw_edges(edges, drawing);

  const mtf::Statistics values = mtf::statistics(image.view());
  const auto low = static_cast<float>(values.min), high = static_cast<float>(values.max);
  const auto width = std::max(image.width(), static_cast<std::int64_t>(std::ceil(kLeastWidth / drawing.zoom)));
  Legend legend(image.height(), static_cast<double>(width * drawing.zoom), drawing);
  const auto measured = [](const MeasuredEdge& one) { return one.edge.trouble == Trouble::none; };
  const auto first = std::find_if(edges.begin(), edges.end(), measured);
  if (first != edges.end()) {
    legend.line(kRegionColour, 20.0, false, "region measured");
    legend.line(kEdgeColour, 20.0, false, "edge, MTF50 in " + std::string(unit_symbol(first->scale.unit)));
  }
  if (!std::all_of(edges.begin(), edges.end(), measured))
    legend.line(kTroubleColour, 20.0, false, "region without a result, and why");
  legend.greys("values from " + significant(values.min, 5) + " to " + significant(values.max, 5));
  const double scale_px = round_length(kScale / drawing.zoom);
  legend.line(kText, scale_px * drawing.zoom, true, plural(static_cast<std::int64_t>(scale_px), "pixel"));

  mtf::Image page(width, legend.bottom_px());
  std::fill_n(page.data(), page.size(), low + kGround * (high - low));
  copy(image.view(), part_of(page.view(), {0, 0, image.width(), image.height()}));
  mtf::io::write_annotated_png(path, page.view(), low, high, drawing);
}

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
  for (const std::string& figure : {options.plot, options.map})
    for (std::string& file : figure_files(figure)) outputs.push_back(std::move(file));
  outputs.push_back(options.annotate);
  std::erase(outputs, "");
  if (!options.annotate.empty() && mtf::io::format_from_extension(options.annotate) != mtf::io::Format::png)
    throw mtf::UsageError(options.annotate + ": annotated images are PNG; end the name in .png");
  return outputs;
}

void write_figures_of(const MeasureOptions& options, const MeasureReport& report, OutputSet& outputs,
                      const Global& global) {
  const auto drawn = [&](bool made, const std::string& path) { note(global, figure_note(path, made)); };
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
