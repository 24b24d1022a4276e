// SPDX-License-Identifier: Apache-2.0
#include "apps/report/report_svg.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/report/report_designs.h"
#include "apps/report/report_html.h"
#include "apps/terminal/text_table.h"

namespace apps {
namespace {

constexpr double kWidth = 720.0, kHeight = 380.0, kLeft = 84.0, kRight = 190.0, kTop = 34.0, kBottom = 52.0;

std::string px(double value) { return fixed(value, 1); }

/// From values to places, linear or logarithmic.
class Scale {
 public:
  Scale(double lo, double hi, double from, double to, bool log)
      : lo_(log ? std::log10(lo) : lo), hi_(log ? std::log10(hi) : hi), from_(from), to_(to), log_(log) {
    if (!(hi_ > lo_)) {
      const double room = std::max(std::abs(lo_) * 0.05, 1e-12);
      lo_ -= room;
      hi_ += room;
    }
  }
  bool shows(double v) const { return std::isfinite(v) && (!log_ || v > 0.0); }
  double at(double v) const {
    const double share = ((log_ ? std::log10(v) : v) - lo_) / (hi_ - lo_);
    return std::lerp(from_, to_, std::clamp(share, -0.02, 1.02));
  }
  /// Round values inside.
  std::vector<double> ticks() const {
    std::vector<double> values;
    const double raw = (hi_ - lo_) / 6.0, power = std::pow(10.0, std::floor(std::log10(raw)));
    double step = power;
    for (const double m : {1.0, 2.0, 5.0, 10.0})
      if (m * power >= raw) {
        step = m * power;
        break;
      }
    if (log_) step = std::max(1.0, std::round(step));
    for (double k = std::ceil(lo_ / step - 1e-9); k * step <= hi_ + 1e-9 * step && values.size() < 20; k += 1.0)
      values.push_back(log_ ? std::pow(10.0, k * step) : k * step + 0.0);  // + 0.0 makes 0 of -0
    return values;
  }

 private:
  double lo_, hi_, from_, to_;
  bool log_;
};

struct Range {
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  void take(double v, bool log) {
    if (!std::isfinite(v) || (log && v <= 0.0)) return;
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  bool empty() const { return !(hi >= lo); }
};

std::string text(double x, double y, const char* style, const std::string& words, const char* anchor = "start") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" class=\"" + style + "\" text-anchor=\"" + anchor + "\">" +
         html(words) + "</text>";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + px(x1) + "\" y1=\"" + px(y1) + "\" x2=\"" + px(x2) + "\" y2=\"" + px(y2) + "\" class=\"" +
         style + "\"/>";
}

std::string open(const std::string& title, double height = kHeight) {
  return "<svg class=\"static\" viewBox=\"0 0 " + px(kWidth) + " " + px(height) + "\" role=\"img\" aria-label=\"" +
         html(title) + "\">" + text(kLeft, 20, "title", title);
}

std::string axes(const Scale& x, const Scale& y, const std::string& x_label, const std::string& y_label) {
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  std::string svg;
  for (const double v : x.ticks())
    svg += line(x.at(v), kTop, x.at(v), bottom, "grid") + text(x.at(v), bottom + 16, "tick", five_digits(v), "middle");
  for (const double v : y.ticks())
    svg += line(kLeft, y.at(v), right, y.at(v), "grid") + text(kLeft - 6, y.at(v) + 4, "tick", five_digits(v), "end");
  return svg + line(kLeft, bottom, right, bottom, "axis") + line(kLeft, kTop, kLeft, bottom, "axis") +
         text(0.5 * (kLeft + right), kHeight - 14, "label", x_label, "middle") +
         "<text class=\"label\" text-anchor=\"middle\" transform=\"translate(16 " + px(0.5 * (kTop + bottom)) +
         ") rotate(-90)\">" + html(y_label) + "</text>";
}

/// Viridis (Smith and van der Walt, matplotlib), five anchors.
std::string colour(double share) {
  constexpr std::array<std::array<double, 3>, 5> anchors{
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double at = std::clamp(share, 0.0, 1.0) * 4.0;
  const auto i = static_cast<std::size_t>(std::min(3.0, std::floor(at)));
  std::string name = "rgb(";
  for (std::size_t c = 0; c < 3; ++c)
    name += (c > 0 ? "," : "") + fixed(std::lerp(anchors[i][c], anchors[i + 1][c], at - static_cast<double>(i)), 0);
  return name + ")";
}

std::string colour_scale(const Range& range, const std::string& label) {
  const double x = kWidth - kRight + 24.0, h = (kHeight - kTop - kBottom) / 32.0;
  std::string svg = text(x, kTop - 6, "tick", label);
  for (int i = 0; i < 32; ++i)
    svg += "<rect x=\"" + px(x) + "\" y=\"" + px(kTop + (31 - i) * h) + "\" width=\"14\" height=\"" + px(h + 0.5) +
           "\" fill=\"" + colour(i / 31.0) + "\"/>";
  return svg + text(x + 20, kTop + 8, "tick", five_digits(range.hi)) +
         text(x + 20, kHeight - kBottom, "tick", five_digits(range.lo));
}

std::string path_of(const Series& series, const Scale& x, const Scale& y, const std::string& style) {
  std::string d;
  bool down = false;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.y[i])) {
      down = false;
      continue;
    }
    d += (down ? "L" : "M") + px(x.at(series.x[i])) + " " + px(y.at(series.y[i]));
    down = true;
  }
  return "<path class=\"" + style + "\" d=\"" + d + "\"/>";
}

std::string points_of(const Series& series, const Scale& x, const Scale& y, const Range& colours,
                      const std::string& style) {
  std::string svg;
  const double span = colours.hi > colours.lo ? colours.hi - colours.lo : 1.0;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.y[i])) continue;
    const bool coloured = i < series.value.size() && std::isfinite(series.value[i]);
    svg += "<circle cx=\"" + px(x.at(series.x[i])) + "\" cy=\"" + px(y.at(series.y[i])) + "\" r=\"" +
           (series.mark == Mark::large_points ? "5" : "2.6") + "\" class=\"" + style + "\"" +
           (coloured ? " style=\"fill:" + colour((series.value[i] - colours.lo) / span) +
                           ";fill-opacity:1;stroke:var(--soft);stroke-width:.4\""
                     : "") +
           "/>";
  }
  return svg;
}

}  // namespace

std::string svg_figure(const Figure& figure) {
  Range xs, ys, colours;
  for (const Series& series : figure.series) {
    for (const double v : series.x) xs.take(v, figure.log_x);
    for (const double v : series.y) ys.take(v, figure.log_y);
    for (const double v : series.value) colours.take(v, false);
  }
  if (xs.empty() || ys.empty())
    return "<p class=\"none\">" + html(figure.title) + ": there are no numbers to draw.</p>";
  const Scale x(figure.x_range ? (*figure.x_range)[0] : xs.lo, figure.x_range ? (*figure.x_range)[1] : xs.hi, kLeft,
                kWidth - kRight, figure.log_x);
  const Scale y(figure.y_low.value_or(ys.lo), figure.y_high.value_or(ys.hi), kHeight - kBottom, kTop, figure.log_y);
  std::string svg = open(figure.title) + axes(x, y, figure.x_label, figure.y_label);
  double legend = kTop + 8.0;
  int number = 0;
  for (const Series& series : figure.series) {
    const std::string style = series.emphasised ? "series strong" : "series s" + std::to_string(number++ % 8);
    svg += series.mark == Mark::line ? path_of(series, x, y, style) : points_of(series, x, y, colours, style + " dot");
    if (series.name.empty() || !series.value.empty() || legend > kHeight - 20) continue;
    svg += line(kWidth - kRight + 14, legend - 4, kWidth - kRight + 32, legend - 4, style) +
           text(kWidth - kRight + 38, legend, "tick", series.name);
    legend += 17.0;
  }
  if (!colours.empty()) svg += colour_scale(colours, figure.colour_label);
  return svg + "</svg>";
}

std::string svg_heat_map(const HeatMap& map) {
  Range colours;
  for (const double v : map.value) colours.take(v, false);
  if (colours.empty() || map.x.empty() || map.y.empty())
    return "<p class=\"none\">" + html(map.title) + ": there are no numbers to draw.</p>";
  const double w = (kWidth - kLeft - kRight) / static_cast<double>(map.x.size()),
               h = (kHeight - kTop - kBottom) / static_cast<double>(map.y.size());
  const double span = colours.hi > colours.lo ? colours.hi - colours.lo : 1.0;
  std::string svg = open(map.title);
  for (std::size_t j = 0; j < map.y.size(); ++j)
    for (std::size_t i = 0; i < map.x.size(); ++i) {
      const double v = map.value[j * map.x.size() + i];
      if (!std::isfinite(v)) continue;
      svg += "<rect x=\"" + px(kLeft + w * static_cast<double>(i)) + "\" y=\"" +
             px(kHeight - kBottom - h * static_cast<double>(j + 1)) + "\" width=\"" + px(w + 0.3) + "\" height=\"" +
             px(h + 0.3) + "\" fill=\"" + colour((v - colours.lo) / span) + "\"/>";
    }
  const auto every = [](std::size_t count) { return std::max<std::size_t>(1, (count + 7) / 8); };
  const auto level = [](const std::string& words) {
    const auto value = cell_value(words);
    return value ? five_digits(*value) : words;
  };
  for (std::size_t i = 0; i < map.x.size(); i += every(map.x.size()))
    svg += text(kLeft + w * (static_cast<double>(i) + 0.5), kHeight - kBottom + 16, "tick", level(map.x[i]), "middle");
  for (std::size_t j = 0; j < map.y.size(); j += every(map.y.size()))
    svg += text(kLeft - 6, kHeight - kBottom - h * (static_cast<double>(j) + 0.5) + 4, "tick", level(map.y[j]), "end");
  return svg + text(0.5 * (kLeft + kWidth - kRight), kHeight - 14, "label", map.x_label, "middle") +
         "<text class=\"label\" text-anchor=\"middle\" transform=\"translate(16 " +
         px(0.5 * (kTop + kHeight - kBottom)) + ") rotate(-90)\">" + html(map.y_label) + "</text>" +
         colour_scale(colours, "") + "</svg>";
}

std::string svg_bars(const std::string& title, const std::string& x_label, std::span<const Bar> bars) {
  Range range;
  range.take(0.0, false);
  for (const Bar& bar : bars) {
    range.take(bar.value - bar.spread, false);
    range.take(bar.value + bar.spread, false);
  }
  constexpr double row = 22.0, character = 7.2;  // its mean width in the type of labels
  std::size_t longest = 0;
  for (const Bar& bar : bars) longest = std::max(longest, bar.label.size());
  const double left = std::clamp(20.0 + character * static_cast<double>(longest), 100.0, 400.0);
  const double bottom = kTop + row * static_cast<double>(bars.size()), height = bottom + kBottom;
  const Scale x(range.lo, range.hi, left, kWidth - 70.0, false);
  std::string svg = open(title, height);
  for (const double v : x.ticks())
    svg += line(x.at(v), kTop, x.at(v), bottom, "grid") + text(x.at(v), bottom + 16, "tick", five_digits(v), "middle");
  double y = kTop;
  for (const Bar& bar : bars) {
    svg += text(left - 8, y + 15, "tick", bar.label, "end");
    if (std::isfinite(bar.value)) {
      const double a = std::min(x.at(0.0), x.at(bar.value)), b = std::max(x.at(0.0), x.at(bar.value));
      svg += "<rect class=\"bar\" x=\"" + px(a) + "\" y=\"" + px(y + 4) + "\" width=\"" + px(std::max(b - a, 0.5)) +
             "\" height=\"14\"/>" +
             text(std::max(b, x.at(bar.value + bar.spread)) + 6, y + 15, "tick", significant(bar.value, 3));
      if (bar.spread > 0.0)
        svg += line(x.at(bar.value - bar.spread), y + 11, x.at(bar.value + bar.spread), y + 11, "axis");
    }
    y += row;
  }
  return svg + line(x.at(0.0), kTop, x.at(0.0), bottom, "axis") +
         text(0.5 * (left + kWidth - 70.0), height - 14, "label", x_label, "middle") + "</svg>";
}

}  // namespace apps
