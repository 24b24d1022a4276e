// SPDX-License-Identifier: Apache-2.0
#include "calib/find/find_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "calib/edge/edge_pixels.h"
#include "calib/edge/median.h"
#include "calib/find/find_segments.h"
#include "mtf/error.h"
#include "mtf/work/stop.h"

namespace calib {
namespace {

using find::Cells;
using find::Gradients;
using find::Segment;

// The surroundings of a segment, and the regions that have room about it. Coordinates are in cells.

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

/// The two sides of a segment.
struct Surroundings {
  double blur = 0.0;      ///< half width of the edge's own blur
  double free = 0.0;      ///< distance on both sides up to which there is no other structure
  double contrast = 0.0;  ///< between the medians just beyond the blur, in parts of the image's range
  double noise_sd = 0.0;  ///< of a pixel there, no less than the image's
};
/// Absent when the gradient does not fall to `floor` on both sides: no edge by itself, or a side without data.
std::optional<Surroundings> surroundings_of(const Cells& cells, const Gradients& gradients, const Segment& segment,
                                            double floor, double farthest) {
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

/// How many cells of a rectangle have a gradient above a threshold, from an integral image.
class Structure {
 public:
  Structure(const Gradients& gradients, double threshold) : width_(gradients.width + 1) {
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
  std::int64_t count(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) const {
    const auto at = [&](std::int64_t x, std::int64_t y) {
      return static_cast<std::int64_t>(sum_[static_cast<std::size_t>(y * width_ + x)]);
    };
    return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
  }

 private:
  std::int64_t width_ = 0;
  std::vector<std::uint32_t> sum_;
};

/// A region in cells with one edge in it.
struct Region {
  std::int64_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< up to, not including, x1, y1
  double length = 0.0;                          ///< of the edge in it
  double half_width = 0.0;
  bool whole = false;  ///< the image holds nothing else
};

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

struct RegionLimits {
  double min_length = 0.0, half_width = 0.0;  ///< in cells; half_width 0 = as suits
};
/// The best rectangle around the segment that holds no other structure; absent when there is none of this length.
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

// The search.

/// Gradients above this share of an edge's own are other structure; weaker ones are shading. Edges without enough room
/// at the strictest share, as most in natural scenes, are tried with the others and get a lower score.
constexpr std::array<double, 3> kStructureShares{0.05, 0.1, 0.2};
constexpr double kWidestHalf_px = 64.0;
constexpr double kMinLength_cells = 5.0;
constexpr double kLeastNoise = 1e-4;  // of the contrast: noise-free images have a score too

void check(const FindOptions& options) {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (options.most < 1 || options.most_pieces < 1)
    throw mtf::UsageError("find_edges: most = 0 regions or pieces; ask for one or more");
  if (!positive(options.min_length_px))
    throw mtf::UsageError("find_edges: the least length of an edge has to be a number of pixels above 0");
  if (!positive(options.min_cnr)) throw mtf::UsageError("find_edges: the least contrast/noise has to be above 0");
  if (!(options.half_width_px >= 0.0) || !std::isfinite(options.half_width_px))
    throw mtf::UsageError("find_edges: the half width has to be 0 (as far as suits) or a number of pixels");
}

/// Why segments gave no region.
struct Passed {
  int blurred = 0, faint = 0, crowded = 0;
};

std::string number(double v) {
  std::string text = std::to_string(std::round(v * 10.0) / 10.0);
  text.erase(text.find('.') + 2);
  if (text.ends_with(".0")) text.erase(text.size() - 2);
  return text;
}

std::string no_usable(const Passed& passed, const FindOptions& options) {
  const int seen = passed.blurred + passed.faint + passed.crowded;
  if (seen == 0)
    return "no smooth edge of " + number(options.min_length_px) +
           " pixels or more rises above the noise; lower the least length, or give a region";
  std::string text =
      std::to_string(seen) + (seen == 1 ? " edge was seen, but it is not" : " edges were seen, none") + " usable:";
  const auto add = [&](int count, const std::string& why) {
    if (count > 0) text += " " + std::to_string(count) + " " + why + ",";
  };
  add(passed.blurred, "without a plateau on both sides (too near to another edge, to the border or too blurred)");
  add(passed.faint, "below a contrast/noise of " + number(options.min_cnr));
  add(passed.crowded, "with other structure too close along all of its length");
  text.back() = ';';
  return text + " give a region, or lower the limits";
}

/// Contrast / noise times the root of the pixels along the edge, to which the precision of an MTF is proportional (for
/// a Gaussian blur sd(MTF50) / MTF50 = sqrt(4 sqrt(pi) / (L sigma)) / CNR), less where the sides are short against the
/// blur.
double score_of(const Region& region, const Surroundings& beside, double size) {
  const double noise = std::max(beside.noise_sd, kLeastNoise * beside.contrast);
  return beside.contrast / noise * std::sqrt(region.length * size) * region.half_width /
         (region.half_width + 4.0 + 2.0 * beside.blur);
}

Roi in_pixels(const Region& region, int size, mtf::ImageView<const float> image) {
  Roi roi{region.x0 * size, region.y0 * size, 0, 0};
  roi.width = std::min(region.x1 * size, image.width) - roi.x;
  roi.height = std::min(region.y1 * size, image.height) - roi.y;
  return roi;
}

struct Search {
  mtf::ImageView<const float> image;
  const FindOptions& options;
  Cells cells;
  Gradients gradients;
  FoundEdges found;
  int without_plateau = 0;  ///< pieces without a plateau on both sides at any share
  Passed passed;            ///< at the last share that was tried

  double in_cells(double px) const { return px / cells.size_px; }
  /// Integral images are made for gradients above the threshold x 2^k. This is the k for a share of a segment's peak.
  int octave_of(const Segment& segment, double share) const {
    const double times = share * segment.peak / gradients.threshold;
    return times > 1.0 ? std::ilogb(times) : 0;
  }
  double floor_of(int octave) const { return std::ldexp(gradients.threshold, octave); }
  std::optional<Surroundings> survey(const Segment& segment, int octave) const {
    const double half_px = options.half_width_px > 0.0 ? options.half_width_px : kWidestHalf_px;
    return surroundings_of(cells, gradients, segment, floor_of(octave), in_cells(half_px));
  }
};

/// A segment with a plateau on both sides.
struct Piece {
  Segment segment;
  double share = 0.0;       ///< the strictest at which it has them
  Surroundings beside;      ///< at that share
  double most_score = 0.0;  ///< if its sides were free without limit
};

/// The strongest first.
std::vector<Piece> pieces_of(Search& search) {
  std::vector<Piece> pieces;
  const std::size_t most = search.options.most_pieces;
  const auto keep_best = [&] {
    if (pieces.size() <= most) return;
    const auto end = pieces.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(pieces.begin(), end, pieces.end(),
                     [](const Piece& a, const Piece& b) { return a.most_score > b.most_score; });
    search.found.not_tried += pieces.size() - most;
    pieces.erase(end, pieces.end());
  };
  // The length that regions lose at corners is not lost at the image's border.
  const double least = std::max(kMinLength_cells, search.in_cells(search.options.min_length_px) - 3.0);
  find::make_segments(search.gradients, least, [&](const Segment& segment) {
    for (const double share : kStructureShares) {
      const auto beside = search.survey(segment, search.octave_of(segment, share));
      if (!beside) continue;
      const double noise = std::max(beside->noise_sd, kLeastNoise * beside->contrast);
      pieces.push_back({segment, share, *beside, beside->contrast / noise * std::sqrt(segment.length()) / share});
      if (pieces.size() >= 2 * most) keep_best();
      return;
    }
    ++search.without_plateau;
  });
  keep_best();
  const auto strength = [](const Piece& p) { return p.segment.peak * std::sqrt(p.segment.length()); };
  std::ranges::stable_sort(pieces, [&](const Piece& a, const Piece& b) { return strength(a) > strength(b); });
  return pieces;
}

/// Finds regions for the pieces that have room at this share and takes them off the list. Returns true when the image
/// is crossed by one edge, which is then the only one found.
bool place_regions(Search& search, double share, std::vector<Piece>& pieces) {
  const Gradients& gradients = search.gradients;
  const FindOptions& options = search.options;
  const RegionLimits limits{search.in_cells(options.min_length_px), search.in_cells(options.half_width_px)};
  std::map<int, std::vector<Piece>, std::greater<>> by_octave;
  std::vector<Piece> left;
  search.passed = {.blurred = search.without_plateau};
  for (Piece& piece : pieces) {
    const int octave = search.octave_of(piece.segment, share);
    auto beside = piece.share == share  ? std::optional(piece.beside)
                  : piece.share < share ? search.survey(piece.segment, octave)
                                        : std::nullopt;
    if (beside) {
      piece.beside = *beside;
      by_octave[octave].push_back(piece);
    } else {
      ++search.passed.blurred;
      left.push_back(piece);
    }
  }
  for (const auto& [octave, candidates] : by_octave) {
    const double floor = search.floor_of(octave);
    const Structure structure(gradients, floor);
    for (const Piece& piece : candidates) {
      mtf::require_going_on();
      const Surroundings& beside = piece.beside;
      const auto region = place_region(gradients, structure, floor, piece.segment, beside, limits);
      // The whole image belongs to one edge only when it has no other. That edge is taken however faint it is.
      const bool crowded = !region || (region->whole && !search.found.edges.empty());
      const bool faint = beside.contrast < options.min_cnr * beside.noise_sd && !(region && region->whole);
      if (crowded || faint) {
        ++(faint ? search.passed.faint : search.passed.crowded);
        left.push_back(piece);
        continue;
      }
      const double score = score_of(*region, beside, search.cells.size_px) * kStructureShares.front() / share;
      const FoundEdge edge{in_pixels(*region, search.cells.size_px, search.image), score};
      search.found.edges.push_back(edge);
      if (region->whole) return true;
    }
  }
  pieces = std::move(left);
  return false;
}

}  // namespace

FoundEdges find_edges(mtf::ImageView<const float> image, const FindOptions& options) {
  check(options);
  const auto none = [](std::string reason) { return FoundEdges{{}, std::move(reason)}; };
  if (image.width < 1 || image.height < 1) return none("the image is empty");
  Search search{image, options, find::make_cells(image), {}, {}, 0, {}};
  if (search.cells.valid == 0.0) {
    const std::string reason = why_infinite(image, {0, 0, image.width, image.height});
    return none(reason.empty() ? "all pixels are masked or no numbers; use another mask or channel" : reason);
  }
  if (search.cells.range == 0.0) return none("all pixels have the same value; is it the right file and channel?");

  search.gradients = find::make_gradients(search.cells);
  std::vector<Piece> pieces = pieces_of(search);
  for (const double share : kStructureShares)
    if (place_regions(search, share, pieces)) return search.found;

  FoundEdges& found = search.found;
  std::ranges::stable_sort(found.edges, [](const FoundEdge& a, const FoundEdge& b) { return a.score > b.score; });
  if (found.edges.size() > options.most) {
    found.left_out = found.edges.size() - options.most;
    found.edges.resize(options.most);
  }
  if (found.edges.empty()) found.reason = no_usable(search.passed, options);
  return found;
}

}  // namespace calib
