// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/annotated_image.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/text/message_words.h"
#include "mtf/io/codecs/drawing.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

using calib::Trouble;
using mtf::io::Colour;

constexpr Colour kRegionColour{90, 200, 255}, kEdgeColour{255, 210, 0}, kTroubleColour{255, 90, 60},
    kText{235, 235, 235};

struct Range {
  float low, high;
};

Range range_of(const mtf::Image& image) {
  Range range{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  for (std::int64_t i = 0; i < image.size(); ++i) {
    if (!std::isfinite(image.data()[i])) continue;
    range.low = std::min(range.low, image.data()[i]);
    range.high = std::max(range.high, image.data()[i]);
  }
  return range.low <= range.high ? range : Range{0.0F, 0.0F};
}

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

}  // namespace

void write_annotated_image(const std::string& path, const mtf::Image& image, std::span<const MeasuredEdge> edges) {
  constexpr double kLeastWidth = 352.0, kScale = 100.0;  // pixels of the picture
  constexpr float kGround = 0.1F;                        // grey value behind the legend
  mtf::io::Drawing drawing;
  // Small images are enlarged so that words can be read.
  const std::int64_t longest = std::max<std::int64_t>({image.width(), image.height(), 1});
  drawing.zoom = static_cast<int>(std::clamp<std::int64_t>(800 / longest, 1, 8));
  draw_edges(edges, drawing);

  const Range range = range_of(image);
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
  legend.greys("values from " + significant(static_cast<double>(range.low), 5) + " to " +
               significant(static_cast<double>(range.high), 5));
  const double scale_px = round_length(kScale / drawing.zoom);
  legend.line(kText, scale_px * drawing.zoom, true, plural(static_cast<std::int64_t>(scale_px), "pixel"));

  mtf::Image page(width, legend.bottom_px());
  std::fill_n(page.data(), page.size(), range.low + kGround * (range.high - range.low));
  for (std::int64_t y = 0; y < image.height(); ++y) std::copy_n(image.view().row(y), image.width(), page.view().row(y));
  mtf::io::write_annotated_png(path, page.view(), range.low, range.high, drawing);
}

}  // namespace apps
