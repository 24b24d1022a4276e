// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "calib/edge/median.h"

#include "calib/find/find_parts.h"
#include "mtf/work/stop.h"

namespace calib::find {
namespace {

constexpr int kMostSamples = 96;         // along a segment
constexpr double kMiddleShare = 0.8;     // of a segment: its ends are corners
constexpr double kMostBlur = 24.0;       // largest half width of a blur, in cells
constexpr double kKnownShare = 0.3;      // of samples at a distance: with fewer there is no side
constexpr double kTornShare = 0.25;      // of samples above the floor: a structure runs along the edge there
constexpr std::int64_t kNearBorder = 2;  // cells
constexpr double kRise = 1.3;            // of the gradient with the distance: another edge
constexpr double kStray = 1e-4;          // share of cells above the threshold that noise explains
constexpr std::array<double, 9> kWidths{1.0, 0.8, 0.65, 0.5, 0.4, 0.3, 0.22, 0.16, 0.12};

/// The samples at one distance from the segment.
struct Strip {
  double known = 0.0;      ///< share of samples with a value
  double magnitude = 0.0;  ///< median
  double torn = 0.0;       ///< share above the floor
};

class Samples {
 public:
  Samples(const Cells& cells, const Gradients& gradients, const Segment& segment)
      : cells_(cells), gradients_(gradients), segment_(segment) {
    count_ = std::clamp(static_cast<int>(kMiddleShare * segment.length()), 3, kMostSamples);
  }

  Strip strip(double d, double floor) {
    magnitudes_.clear();
    int above = 0;
    visit(d, [&](std::size_t i) {
      magnitudes_.push_back(gradients_.magnitude[i]);
      above += gradients_.magnitude[i] > floor ? 1 : 0;
    });
    if (magnitudes_.empty()) return {};
    const double known = static_cast<double>(magnitudes_.size());
    return {known / count_, median(magnitudes_), above / known};
  }

  /// Values of the cells at this distance, in order along the segment.
  std::vector<double> values(double d) const {
    std::vector<double> v;
    visit(d, [&](std::size_t i) { v.push_back(cells_.value[i]); });
    return v;
  }

 private:
  template <class Function>
  void visit(double d, const Function& function) const {
    for (int k = 0; k < count_; ++k) {
      const double share = 0.5 + kMiddleShare * ((k + 0.5) / count_ - 0.5);
      const Point p = segment_.at(std::lerp(segment_.s0, segment_.s1, share), d);
      if (!(p.x >= 0.0 && p.y >= 0.0 && p.x < static_cast<double>(cells_.width) &&
            p.y < static_cast<double>(cells_.height)))
        continue;
      const auto i =
          static_cast<std::size_t>(static_cast<std::int64_t>(p.y) * cells_.width + static_cast<std::int64_t>(p.x));
      if (!std::isnan(cells_.value[i])) function(i);
    }
  }

  const Cells& cells_;
  const Gradients& gradients_;
  const Segment& segment_;
  int count_ = 0;
  std::vector<double> magnitudes_;
};

struct Side {
  double blur = 0.0, free = 0.0;  // half width of the blur; distance up to which the side has no structure
};

std::optional<Side> side_of(Samples& samples, double sign, double floor, double farthest) {
  Side side;
  double least = samples.strip(0.0, floor).magnitude;
  for (double d = 1.0; d <= std::min(kMostBlur, farthest); d += 1.0) {
    const Strip strip = samples.strip(sign * d, floor);
    if (strip.known < kKnownShare) return std::nullopt;
    // The ridge may lie a cell beside the curve.
    if (d > 1.5 && strip.magnitude > kRise * least + 0.5 * floor) return std::nullopt;
    least = std::min(least, strip.magnitude);
    if (strip.magnitude > floor) continue;
    side.blur = d;
    break;
  }
  if (side.blur == 0.0) return std::nullopt;
  for (side.free = side.blur; side.free < farthest; side.free += 1.0) {
    const Strip strip = samples.strip(sign * (side.free + 1.0), floor);
    if (strip.known < kKnownShare || strip.torn > kTornShare) break;
  }
  return side;
}

/// Median and noise of the cells a little beyond the blur. Neighbours along the edge differ by noise alone.
struct Plateau {
  double value = 0.0, noise_sd = 0.0;
};
std::optional<Plateau> plateau_of(const Samples& samples, double sign, double blur) {
  std::vector<double> all, steps;
  for (const double beyond : {1.0, 2.0, 3.0}) {
    const std::vector<double> v = samples.values(sign * (blur + beyond));
    for (std::size_t i = 1; i < v.size(); ++i)
      if (v[i] != v[i - 1]) steps.push_back(std::abs(v[i] - v[i - 1]));
    all.insert(all.end(), v.begin(), v.end());
  }
  if (all.empty()) return std::nullopt;
  return Plateau{median(all), steps.empty() ? 0.0 : median(steps) / (0.6745 * std::sqrt(2.0))};
}

/// The segment line by line: rows where it is steep, columns where it is flat.
struct Lines {
  bool steep = true;
  std::int64_t first = 0;            ///< number of the first line
  std::vector<double> place;         ///< of the curve in each line
  std::vector<std::int64_t> before;  ///< cells of the edge itself in all lines before; one more than lines
  double slant = 1.0;                ///< distance along a line per distance from the edge
  std::int64_t least = 0, most = 0;  ///< lines of the smallest and largest place
  std::int64_t begin = 0, end = 0;   ///< lines that regions may take: not those that only lie beyond its ends

  std::int64_t last() const { return first + static_cast<std::int64_t>(place.size()); }
};

Lines trace(const Gradients& g, double threshold, const Segment& segment, double width) {
  Lines lines;
  lines.steep = std::abs(segment.normal.x) >= std::abs(segment.normal.y);
  const double normal = lines.steep ? segment.normal.x : segment.normal.y;
  lines.slant = 1.0 / std::abs(normal);
  const std::int64_t count = lines.steep ? g.height : g.width, places = lines.steep ? g.width : g.height;
  const auto line_of = [&](double s) { return lines.steep ? segment.at(s).y : segment.at(s).x; };
  const auto [low, high] = std::minmax({line_of(segment.s0 - width), line_of(segment.s1 + width)});
  lines.first = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(low)), 0, count);
  const std::int64_t end = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::ceil(high)), lines.first, count);
  const Point middle = segment.at(0.5 * (segment.s0 + segment.s1));
  double place = lines.steep ? middle.x : middle.y;
  lines.before.push_back(0);
  for (std::int64_t line = lines.first; line < end; ++line) {
    const auto point = [&](double at) {
      const double middle_of_line = static_cast<double>(line) + 0.5;
      return lines.steep ? Point{at, middle_of_line} : Point{middle_of_line, at};
    };
    const double most = 2.0 * static_cast<double>(places);  // where the curve never meets the line
    for (int k = 0; k < 4; ++k) place = std::clamp(place - segment.across(point(place)) / normal, -most, most);
    lines.place.push_back(place);
    std::int64_t own = 0;
    const double span = width * lines.slant + 2.0;
    const auto from = static_cast<std::int64_t>(std::clamp(place - span, 0.0, static_cast<double>(places)));
    const auto to = static_cast<std::int64_t>(std::clamp(place + span, 0.0, static_cast<double>(places)));
    for (std::int64_t i = from; i < to; ++i)
      if ((lines.steep ? g.at(i, line) : g.at(line, i)) > threshold &&
          std::abs(segment.across(point(static_cast<double>(i) + 0.5))) <= width)
        ++own;
    lines.before.push_back(lines.before.back() + own);
  }
  // An edge that ends near the image's border is continued to it.
  const auto [start, stop] = std::minmax({line_of(segment.s0), line_of(segment.s1)});
  lines.begin = std::clamp<std::int64_t>(std::llround(start), lines.first, end);
  lines.end = std::clamp<std::int64_t>(std::llround(stop), lines.begin, end);
  if (lines.begin <= kNearBorder) lines.begin = lines.first;
  if (lines.end >= count - kNearBorder) lines.end = end;
  const auto [least, most] = std::minmax_element(lines.place.begin(), lines.place.end());
  lines.least = lines.first + (least - lines.place.begin());
  lines.most = lines.first + (most - lines.place.begin());
  return lines;
}

/// The rectangle of lines first .. end - 1 that extends `width` beyond the edge's extremes.
Region rectangle(const Gradients& g, const Lines& lines, std::int64_t first, std::int64_t end, double width) {
  // Along a parabola the extremes are at the ends or where it turns.
  const auto place = [&](std::int64_t line) { return lines.place[static_cast<std::size_t>(line - lines.first)]; };
  double low = std::min(place(first), place(end - 1)), high = std::max(place(first), place(end - 1));
  for (const std::int64_t turn : {lines.least, lines.most})
    if (turn >= first && turn < end) low = std::min(low, place(turn)), high = std::max(high, place(turn));
  const std::int64_t places = lines.steep ? g.width : g.height;
  const auto from = static_cast<std::int64_t>(std::clamp(std::floor(low - width), 0.0, static_cast<double>(places)));
  const auto to = static_cast<std::int64_t>(std::clamp(std::ceil(high + width), 0.0, static_cast<double>(places)));
  Region region;
  if (lines.steep)
    region.x0 = from, region.x1 = to, region.y0 = first, region.y1 = end;
  else
    region.x0 = first, region.x1 = end, region.y0 = from, region.y1 = to;
  return region;
}

}  // namespace

std::optional<Surroundings> survey(const Cells& cells, const Gradients& gradients, const Segment& segment, double floor,
                                   double farthest) {
  Samples samples(cells, gradients, segment);
  const auto bright = side_of(samples, 1.0, floor, farthest), dark = side_of(samples, -1.0, floor, farthest);
  if (!bright || !dark) return std::nullopt;
  const auto above = plateau_of(samples, 1.0, bright->blur), below = plateau_of(samples, -1.0, dark->blur);
  if (!above || !below) return std::nullopt;
  Surroundings found;
  found.blur = std::max(bright->blur, dark->blur);
  found.free = std::min(bright->free, dark->free);
  found.contrast = above->value - below->value;
  found.noise_sd = std::sqrt(cells.pixels_a_cell) * std::max({cells.noise_sd, above->noise_sd, below->noise_sd});
  return found;
}

Structure::Structure(const Gradients& gradients, double threshold) : width_(gradients.width + 1) {
  sum_.assign(static_cast<std::size_t>(width_ * (gradients.height + 1)), 0);
  for (std::int64_t y = 0; y < gradients.height; ++y) {
    mtf::require_going_on();
    std::uint32_t row = 0;
    for (std::int64_t x = 0; x < gradients.width; ++x) {
      row += gradients.at(x, y) > threshold ? 1U : 0U;
      const auto above = static_cast<std::size_t>(y * width_ + x + 1);
      sum_[above + static_cast<std::size_t>(width_)] = sum_[above] + row;
    }
  }
}

std::int64_t Structure::count(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) const {
  const auto at = [&](std::int64_t x, std::int64_t y) {
    return static_cast<std::int64_t>(sum_[static_cast<std::size_t>(y * width_ + x)]);
  };
  return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
}

std::optional<Region> place_region(const Gradients& g, const Structure& structure, double threshold,
                                   const Segment& segment, const Surroundings& surroundings,
                                   const RegionLimits& limits) {
  // Noise lifts single cells above the threshold a little farther out than it lifts medians.
  const double half_band = 1.3 * surroundings.blur + 2.0;
  const Lines lines = trace(g, threshold, segment, half_band);
  if (lines.place.empty()) return std::nullopt;
  const auto own = [&](std::int64_t first, std::int64_t end) {
    return lines.before[static_cast<std::size_t>(end - lines.first)] -
           lines.before[static_cast<std::size_t>(first - lines.first)];
  };
  const auto stray = [](std::int64_t width, std::int64_t height) {
    return static_cast<std::int64_t>(kStray * static_cast<double>(width * height));
  };
  if (structure.count(0, 0, g.width, g.height) - own(lines.first, lines.last()) <= stray(g.width, g.height)) {
    const double across = static_cast<double>(lines.steep ? g.width : g.height) / lines.slant;
    return Region{0, 0, g.width, g.height, segment.length(), 0.5 * across, true};
  }

  const auto is_free = [&](std::int64_t first, std::int64_t end, double width) {
    const Region r = rectangle(g, lines, first, end, width);
    return structure.count(r.x0, r.y0, r.x1, r.y1) - own(first, end) <= stray(r.x1 - r.x0, r.y1 - r.y0);
  };
  std::optional<Region> best;
  double best_merit = 0.0;
  const double widest = limits.half_width > 0.0 ? std::min(limits.half_width, surroundings.free) : surroundings.free;
  const double tail = 4.0 + 2.0 * surroundings.blur;  // half of the merit of endless sides
  for (const double share : kWidths) {
    const double half = share * widest;
    if (half < half_band + 1.0) break;
    // The longest run of lines whose rectangle is free: it only grows with either end.
    std::int64_t first = lines.begin, longest_first = first, longest = 0;
    for (std::int64_t end = lines.begin + 1; end <= lines.end; ++end) {
      while (first < end && !is_free(first, end, half * lines.slant)) ++first;
      if (end - first > longest) longest = end - first, longest_first = first;
    }
    // Corners are round: what is left of them at the ends is cut off, but not at the image's border.
    const std::int64_t count = lines.steep ? g.height : g.width;
    const auto margin = static_cast<std::int64_t>(2.0 + 0.5 * surroundings.blur);
    std::int64_t last = longest_first + longest;
    if (longest_first > kNearBorder) longest_first += margin;
    if (last < count - kNearBorder) last -= margin;
    const double length = static_cast<double>(last - longest_first) * lines.slant;
    const double merit = std::sqrt(std::max(0.0, length)) * half / (half + tail);
    if (length < limits.min_length || merit <= best_merit) continue;
    best_merit = merit;
    best = rectangle(g, lines, longest_first, last, half * lines.slant);
    best->length = length;
    best->half_width = half;
    if (limits.half_width > 0.0) break;
  }
  return best;
}

}  // namespace calib::find
