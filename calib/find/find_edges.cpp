// SPDX-License-Identifier: Apache-2.0
#include "calib/find/find_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "calib/edge/edge_pixels.h"
#include "calib/find/find_parts.h"
#include "mtf/error.h"
#include "mtf/work/stop.h"

namespace calib {
namespace {

using find::Cells;
using find::Gradients;
using find::Segment;
using find::Surroundings;

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
double score_of(const find::Region& region, const Surroundings& beside, double size) {
  const double noise = std::max(beside.noise_sd, kLeastNoise * beside.contrast);
  return beside.contrast / noise * std::sqrt(region.length * size) * region.half_width /
         (region.half_width + 4.0 + 2.0 * beside.blur);
}

Roi in_pixels(const find::Region& region, int size, mtf::ImageView<const float> image) {
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
    return find::survey(cells, gradients, segment, floor_of(octave), in_cells(half_px));
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
  const find::RegionLimits limits{search.in_cells(options.min_length_px), search.in_cells(options.half_width_px)};
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
    const find::Structure structure(gradients, floor);
    for (const Piece& piece : candidates) {
      mtf::require_going_on();
      const Surroundings& beside = piece.beside;
      const auto region = find::place_region(gradients, structure, floor, piece.segment, beside, limits);
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
