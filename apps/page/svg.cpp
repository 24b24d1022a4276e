// SPDX-License-Identifier: Apache-2.0
#include "apps/page/svg.h"

#include <algorithm>
#include <cmath>

#include "apps/page/html.h"
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
  bool holds(double v) const { return share(v) >= 0.0 && share(v) <= 1.0; }
  /// What lies beyond the axis is at its end.
  double at(double v) const { return std::lerp(from_, to_, std::clamp(share(v), 0.0, 1.0)); }
  /// Round values inside: on a log axis of less than a decade as on a linear one, of few decades 1, 2 and 5 of each.
  std::vector<double> ticks() const {
    std::vector<double> values;
    if (log_ && hi_ - lo_ >= 1.0 && hi_ - lo_ < 2.5) {
      for (double k = std::floor(lo_); k <= hi_; k += 1.0)
        for (const double m : {1.0, 2.0, 5.0})
          if (const double v = k + std::log10(m); v >= lo_ - 1e-9 && v <= hi_ + 1e-9)
            values.push_back(m * std::pow(10.0, k));
      return values;
    }
    const bool powers = log_ && hi_ - lo_ >= 2.5, narrow = log_ && !powers;
    const double lo = narrow ? std::pow(10.0, lo_) : lo_, hi = narrow ? std::pow(10.0, hi_) : hi_;
    const double raw = (hi - lo) / 6.0, power = std::pow(10.0, std::floor(std::log10(raw)));
    double step = power;
    for (const double m : {1.0, 2.0, 5.0, 10.0})
      if (m * power >= raw) {
        step = m * power;
        break;
      }
    if (powers) step = std::max(1.0, std::round(step));
    for (double k = std::ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * step && values.size() < 20; k += 1.0)
      values.push_back(powers ? std::pow(10.0, k * step) : k * step + 0.0);  // + 0.0 makes 0 of -0
    return values;
  }

 private:
  double share(double v) const { return ((log_ ? std::log10(v) : v) - lo_) / (hi_ - lo_); }
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
  /// By a part of the axis at both ends, so that points are whole.
  void widen(double part, bool log) {
    const double room = log ? std::pow(hi / lo, part) : part * (hi - lo);
    lo = log ? lo / room : lo - room;
    hi = log ? hi * room : hi + room;
  }
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

std::string axes(const Scale& x, const Scale& y, double right, double bottom, const std::string& x_label,
                 const std::string& y_label) {
  std::string svg;
  for (const double v : x.ticks())
    svg += line(x.at(v), kTop, x.at(v), bottom, "grid") + text(x.at(v), bottom + 16, "tick", five_digits(v), "middle");
  for (const double v : y.ticks())
    svg += line(kLeft, y.at(v), right, y.at(v), "grid") + text(kLeft - 6, y.at(v) + 4, "tick", five_digits(v), "end");
  return svg + line(kLeft, bottom, right, bottom, "axis") + line(kLeft, kTop, kLeft, bottom, "axis") +
         text(0.5 * (kLeft + right), bottom + 38, "label", x_label, "middle") +
         "<text class=\"label\" text-anchor=\"middle\" transform=\"translate(16 " + px(0.5 * (kTop + bottom)) +
         ") rotate(-90)\">" + html(y_label) + "</text>";
}

/// Where the line stays beyond the axes there is none.
std::string path_of(const Series& series, const Scale& x, const Scale& y, const std::string& style) {
  std::string d;
  bool down = false;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.y[i])) {
      down = false;
      continue;
    }
    const bool leaves = down && !y.holds(series.y[i]) && !y.holds(series.y[i - 1]);
    d += (down && !leaves ? "L" : "M") + px(x.at(series.x[i])) + " " + px(y.at(series.y[i]));
    down = true;
  }
  return "<path class=\"" + style + "\" d=\"" + d + "\"/>";
}

/// Between `low` and `high`, of the colour of the line.
std::string band_of(const Series& series, const Scale& x, const Scale& y, const std::string& style) {
  std::string there, back;
  for (std::size_t i = 0; i < series.low.size(); ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.low[i]) || !y.shows(series.high[i])) continue;
    there += (there.empty() ? "M" : "L") + px(x.at(series.x[i])) + " " + px(y.at(series.high[i]));
    back = "L" + px(x.at(series.x[i])) + " " + px(y.at(series.low[i])) + back;
  }
  return there.empty() ? "" : "<path class=\"band " + style + "\" d=\"" + there + back + "Z\"/>";
}

std::string dot(double x, double y, bool large, const std::string& style) {
  return "<circle cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"" + (large ? "5" : "2.6") + "\" class=\"" + style +
         "\"/>";
}

std::string points_of(const Series& series, const Scale& x, const Scale& y, const std::string& style) {
  std::string svg;
  for (std::size_t i = 0; i < series.x.size(); ++i)
    if (x.shows(series.x[i]) && y.shows(series.y[i]))
      svg += dot(x.at(series.x[i]), y.at(series.y[i]), series.mark == Mark::large_points, style);
  return svg;
}

}  // namespace

std::string svg_figure(const Figure& figure) {
  Range xs, ys;
  for (const Series& series : figure.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i)
      if (std::isfinite(series.y[i]) && !(figure.log_y && series.y[i] <= 0.0)) xs.take(series.x[i], figure.log_x);
    for (const auto* const values : {&series.y, &series.low, &series.high})
      for (const double v : *values) ys.take(v, figure.log_y);
  }
  if (xs.empty() || ys.empty())
    return "<p class=\"none\">" + html(figure.title) + ": there are no numbers to draw.</p>";
  if (std::ranges::any_of(figure.series, [](const Series& s) { return s.mark != Mark::line && !s.x.empty(); })) {
    xs.widen(0.02, figure.log_x);
    ys.widen(0.03, figure.log_y);
  }
  if (figure.x_range) xs = {(*figure.x_range)[0], (*figure.x_range)[1]};
  ys = {figure.y_low.value_or(ys.lo), figure.y_high.value_or(ys.hi)};
  double right = kWidth - kRight, bottom = kHeight - kBottom;
  if (figure.equal_axes) {
    const double unit = std::min((right - kLeft) / (xs.hi - xs.lo), (bottom - kTop) / std::abs(ys.hi - ys.lo));
    right = kLeft + unit * (xs.hi - xs.lo);
    bottom = kTop + unit * std::abs(ys.hi - ys.lo);
  }
  const Scale x(xs.lo, xs.hi, kLeft, right, figure.log_x);
  const Scale y = ys.hi < ys.lo ? Scale(ys.hi, ys.lo, kTop, bottom, figure.log_y)  // the axis falls
                                : Scale(ys.lo, ys.hi, bottom, kTop, figure.log_y);
  std::string svg = open(figure.title, bottom + kBottom) + axes(x, y, right, bottom, figure.x_label, figure.y_label);
  double legend = kTop + 8.0;
  int number = 0;
  for (const Series& series : figure.series) {
    const bool is_line = series.mark == Mark::line;
    const std::string style = series.emphasised ? "series strong" : "series s" + std::to_string(number++ % 8);
    svg += band_of(series, x, y, style);
    svg += is_line ? path_of(series, x, y, style) : points_of(series, x, y, style + " dot");
    if (series.name.empty() || series.x.empty() || legend > kHeight - 20) continue;
    const double key = kWidth - kRight + 14, middle = legend - 4;
    if (!series.low.empty())
      svg += "<rect class=\"band\" x=\"" + px(key) + "\" y=\"" + px(middle - 6) + "\" width=\"18\" height=\"12\"/>";
    svg += (is_line ? line(key, middle, key + 18, middle, style)
                    : dot(key + 9, middle, series.mark == Mark::large_points, style + " dot")) +
           text(key + 24, legend, "tick", series.name);
    legend += 17.0;
  }
  return svg + "</svg>";
}

std::string svg_bars(const std::string& title, const std::string& x_label, std::span<const Bar> bars,
                     std::optional<Ends> ends) {
  Range range;
  range.take(0.0, false);
  const auto whisker = [](const Bar& bar) {
    return bar.interval.value_or(Ends{bar.value - bar.spread, bar.value + bar.spread});
  };
  for (const Bar& bar : bars)
    for (const double end : whisker(bar)) range.take(end, false);
  constexpr double row = 22.0, character = 7.2;  // its mean width in the type of labels
  std::size_t longest = 0;
  for (const Bar& bar : bars) longest = std::max(longest, bar.label.size());
  const double left = std::clamp(20.0 + character * static_cast<double>(longest), 100.0, 400.0);
  const double bottom = kTop + row * static_cast<double>(bars.size()), height = bottom + kBottom;
  if (ends) range = {(*ends)[0], (*ends)[1]};
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
             text(std::max(b, x.at(whisker(bar)[1])) + 6, y + 15, "tick", significant(bar.value, 3));
      if (whisker(bar)[1] > whisker(bar)[0])
        svg += line(x.at(whisker(bar)[0]), y + 11, x.at(whisker(bar)[1]), y + 11, "axis");
    }
    y += row;
  }
  return svg + line(x.at(0.0), kTop, x.at(0.0), bottom, "axis") +
         text(0.5 * (left + kWidth - 70.0), height - 14, "label", x_label, "middle") + "</svg>";
}

}  // namespace apps
