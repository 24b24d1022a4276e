// SPDX-License-Identifier: Apache-2.0
#include "calib/find_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>

#include "calib/find_parts.h"
#include "mtf/error.h"

namespace calib {
namespace {

using find::Cells;
using find::Gradients;
using find::Segment;
using find::Surroundings;

/// Gradients of this share of an edge's own are other structure; weaker ones are shading. Edges that have no room by
/// the strict share, as most have in natural scenes, are tried by the others, and count for less.
constexpr std::array<double, 3> kStructureShares{0.05, 0.1, 0.2};
constexpr double kWidestHalf_px = 64.0;
constexpr double kMinLength_cells = 5.0;
constexpr double kLeastNoise = 1e-4;  // of the contrast: noise-free images have a score too

void check(const FindOptions& options) {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (options.most < 1) throw mtf::UsageError("find_edges: most = 0 regions; ask for one or more");
  if (!positive(options.min_length_px))
    throw mtf::UsageError("find_edges: the least length of an edge has to be a number of pixels above 0");
  if (!positive(options.min_cnr)) throw mtf::UsageError("find_edges: the least contrast/noise has to be above 0");
  if (!(options.half_width_px >= 0.0) || !std::isfinite(options.half_width_px))
    throw mtf::UsageError("find_edges: the half width has to be 0 (as far as suits) or a number of pixels");
}

/// Why segments were passed over.
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
  add(passed.blurred, "without a level on both sides (too near to another edge, to the border or too blurred)");
  add(passed.faint, "below a contrast/noise of " + number(options.min_cnr));
  add(passed.crowded, "with other structure too close along all of its length");
  text.back() = ';';
  return text + " give a region, or lower the limits";
}

/// Contrast / noise times the root of the pixels along the edge, which is what the precision of an MTF goes with (for a
/// Gaussian blur sd(MTF50) / MTF50 = sqrt(4 sqrt(pi) / (L sigma)) / CNR), less where the sides are short against the
/// blur.
double score_of(const find::Region& region, const Surroundings& beside, double size) {
  const double noise = std::max(beside.noise_sd, kLeastNoise * beside.contrast);
  return beside.contrast / noise * std::sqrt(region.length * size) * region.half_width /
         (region.half_width + 4.0 + 2.0 * beside.reach);
}

Roi in_pixels(const find::Region& region, int size, mtf::ImageView<const float> image) {
  Roi roi{region.x0 * size, region.y0 * size, 0, 0};
  roi.width = std::min(region.x1 * size, image.width) - roi.x;
  roi.height = std::min(region.y1 * size, image.height) - roi.y;
  return roi;
}

}  // namespace

FoundEdges find_edges(mtf::ImageView<const float> image, const FindOptions& options) {
  check(options);
  FoundEdges found;
  const auto none = [&](std::string reason) {
    found.reason = std::move(reason);
    return found;
  };
  if (image.width < 1 || image.height < 1) return none("the image is empty");
  const Cells cells = find::make_cells(image);
  if (cells.valid == 0.0) return none("all pixels are masked or no numbers; use another mask or channel");
  if (cells.range == 0.0) return none("all pixels have the same value; is it the right file and channel?");

  const double size = cells.size_px;
  const Gradients gradients = find::make_gradients(cells);
  const find::RegionLimits limits{options.min_length_px / size, options.half_width_px / size};
  const double farthest = (options.half_width_px > 0.0 ? options.half_width_px : kWidestHalf_px) / size;
  // A margin for what regions lose at corners is not asked for here: at the border nothing is lost.
  const std::vector<Segment> segments =
      find::make_segments(gradients, std::max(kMinLength_cells, limits.min_length - 3.0));

  Passed passed;
  std::vector<Segment> left = segments;
  for (const double share : kStructureShares) {
    passed = {};
    struct Candidate {
      Segment segment;
      Surroundings surroundings;
    };
    std::map<int, std::vector<Candidate>, std::greater<>> by_level;  // level = threshold x 2^key
    std::vector<Segment> refused;
    for (const Segment& segment : left) {
      const double times = share * segment.peak / gradients.threshold;
      const int level = times > 1.0 ? std::ilogb(times) : 0;
      const auto beside = find::survey(cells, gradients, segment, std::ldexp(gradients.threshold, level), farthest);
      if (beside && beside->contrast >= options.min_cnr * beside->noise_sd) {
        by_level[level].push_back({segment, *beside});
        continue;
      }
      ++(beside ? passed.faint : passed.blurred);
      refused.push_back(segment);
    }
    for (const auto& [level, candidates] : by_level) {
      const double floor = std::ldexp(gradients.threshold, level);
      const find::Structure structure(gradients, floor);
      for (const auto& [segment, beside] : candidates) {
        const auto region = find::place_region(gradients, structure, floor, segment, beside, limits);
        if (!region) {
          ++passed.crowded;
          refused.push_back(segment);
          continue;
        }
        const FoundEdge edge{in_pixels(*region, cells.size_px, image),
                             score_of(*region, beside, size) * kStructureShares.front() / share};
        if (region->whole && found.edges.empty()) {
          found.edges = {edge};
          return found;
        }
        found.edges.push_back(edge);
      }
    }
    left = std::move(refused);
  }
  std::stable_sort(found.edges.begin(), found.edges.end(),
                   [](const FoundEdge& a, const FoundEdge& b) { return a.score > b.score; });
  if (found.edges.size() > options.most) found.edges.resize(options.most);
  if (found.edges.empty()) found.reason = no_usable(passed, options);
  return found;
}

}  // namespace calib
