// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "calib/measure/edge_facts.h"
#include "calib/measure/edge_start.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/residual_sums.h"

namespace calib {
namespace {

// Edges beside the region, along the edge that is measured: their tails of diffraction extend into it. A step by c at
// the distance x adds 2 S c / (pi^3 (x - d)) at the distance d, several thousandths of its contrast 20 px away, which
// neither plateaus nor gradients describe and which would be taken for part of the contrast. Where these edges are and
// how large they are is read from the image beyond the region: from the mean of its pixels by distance. S is that of
// the fit; nothing else is unknown. Structure that crosses the normal obliquely counts with its mean.

struct Neighbours {
  std::vector<double> tails;  ///< by bin, what they add to a pixel per S, in units of EdgePixels::value; empty: nothing
  double nearest_px = 0.0;    ///< distance of the nearest one from the edge
};

constexpr int kSide = 96;  // px, as far as the pixels of an edge are taken from
constexpr int kStrips = 2 * kSide;
constexpr double kBroken = 20.0;  // of the range of the region's values: more is a broken pixel

// Means of strips of one pixel along the edge, beyond the region as well as in it.
struct Strip {
  double sum = 0.0;
  std::int64_t inside = 0, beyond = 0;  // pixels in the region, beyond it
  double count() const { return static_cast<double>(inside + beyond); }
  double mean() const { return sum / count(); }
};
using Strips = std::array<Strip, kStrips>;

double centre_of(int strip) { return static_cast<double>(strip - kSide) + 0.5; }

Strips strips_of(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& region, const EdgeCurve& curve) {
  const Point n = curve.normal();
  const Point origin{curve.origin.x + region.middle.x, curve.origin.y + region.middle.y};
  const auto bounds = [](double at, double across, double along, double half, std::int64_t end) {
    const double most = std::abs(across) * kSide + std::abs(along) * half;
    return std::pair{std::max<std::int64_t>(0, static_cast<std::int64_t>(std::floor(at - most))),
                     std::min(end, static_cast<std::int64_t>(std::ceil(at + most)))};
  };
  const auto [left, right] = bounds(origin.x, n.x, n.y, curve.half_length_px, image.width);
  const auto [top, bottom] = bounds(origin.y, n.y, n.x, curve.half_length_px, image.height);
  Strips strips;
  for (std::int64_t j = top; j < bottom; ++j)
    for (std::int64_t i = left; i < right; ++i) {
      const double x = static_cast<double>(i) + 0.5 - origin.x, y = static_cast<double>(j) + 0.5 - origin.y;
      const double d = n.x * x + n.y * y, s = n.x * y - n.y * x;
      const auto value = static_cast<double>(image.at(i, j));
      if (std::abs(d) >= kSide || std::abs(s) > curve.half_length_px || !std::isfinite(value)) continue;
      Strip& strip = strips[static_cast<std::size_t>(std::floor(d) + kSide)];
      const bool inside = i >= roi.x && i < roi.x + roi.width && j >= roi.y && j < roi.y + roi.height;
      ++(inside ? strip.inside : strip.beyond);
      strip.sum += std::clamp((value - region.offset) / region.scale, -kBroken, kBroken);
    }
  return strips;
}

/// `start` is in the coordinates of the region's pixels; structure below 5 % of its contrast does not count.
Neighbours find_neighbours(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& region,
                           const EdgeModel& start) {
  constexpr double kLeast = 0.05;      // of the contrast
  constexpr double kFewest = 8.0;      // pixels of a strip
  constexpr double kClosest_px = 2.0;  // nearer than that the tail is not that of its asymptote
  Neighbours found;
  if (roi.width == image.width && roi.height == image.height) return found;
  const Strips strips = strips_of(image, roi, region, start.curve);
  struct Step {
    double at, height;
  };
  std::vector<Step> steps;
  for (const int direction : {-1, 1}) {
    const double plateau = start.plateau[direction < 0 ? 0 : 1];
    const Strip* last = nullptr;
    bool last_far = false;  // a single strip may be so by one hot pixel
    for (int k = direction < 0 ? kSide - 1 : kSide; k >= 0 && k < kStrips; k += direction) {
      const Strip& strip = strips[static_cast<std::size_t>(k)];
      if (strip.count() < kFewest) continue;
      const Strip* before = std::exchange(last, &strip);
      if (strip.beyond <= strip.inside || before == nullptr) continue;
      steps.push_back({centre_of(k) - 0.5 * direction, direction * (strip.mean() - before->mean())});
      const bool far = std::abs(strip.mean() - plateau) > kLeast * start.contrast();
      if (std::exchange(last_far, far) && far && (found.nearest_px == 0.0 || std::abs(centre_of(k)) < found.nearest_px))
        found.nearest_px = std::abs(centre_of(k));
    }
  }
  if (found.nearest_px == 0.0) return found;
  constexpr double kTail = 2.0 / (std::numbers::pi * std::numbers::pi * std::numbers::pi);
  found.tails.assign(kBins, 0.0);
  for (int i = 0; i < kBins; ++i)
    for (const auto& [at, height] : steps) {
      const double away = at - DistanceBins::get().centre(i);
      found.tails[static_cast<std::size_t>(i)] +=
          kTail * height / std::copysign(std::max(kClosest_px, std::abs(away)), away);
    }
  return found;
}

// The step between neighbouring values of the image where the pixels' (scaled) value is this, in the pixels' unit.
double step_at(double value, const RegionFacts& region, const MeasureOptions& options) {
  const double step = options.quantum_at ? options.quantum_at(region.offset + region.scale * value) : options.quantum;
  return std::isfinite(step) ? std::max(0.0, step) / region.scale : 0.0;
}

// Noise and rounding of the pixels, as far as they are known before a fit.
FitSettings noise_settings(const EdgeModel& start, const RegionFacts& region, const MeasureOptions& options) {
  FitSettings settings;
  settings.rounding = {step_at(start.plateau[0], region, options), step_at(start.plateau[1], region, options)};
  if (!options.noise_sd) return settings;
  constexpr double kMost = 1e3;  // of the range of values: under such noise no edge is seen
  const double sd = std::min(*options.noise_sd / region.scale, kMost);
  const double step = std::max(settings.rounding.dark, settings.rounding.bright);
  settings.variance = std::max({settings.least_variance, step * step / 12.0, sd * sd});
  return settings;
}

// Block means of a large region give the place of the edge to a fraction of a block only: a Gaussian step whose blur
// begins as wide as that is fitted to the pixels.
void sharpen_start(const EdgePixels& pixels, EdgeModel& start, double block_px, FitSettings settings) {
  constexpr std::size_t kSome = 6000;
  start.shape.v_px2 = std::min(0.1 * block_px * block_px, 200.0);
  settings.unknowns = basic_unknowns();
  settings.unknowns.reset(kFirstShape).reset(kFirstShape + 2);
  settings.max_iterations = 40;
  settings.tolerance = 3.0;
  settings.every = step_for(pixels, kSome);
  settings.least_variance = std::max(settings.least_variance, 1e-4);
  fit_reference(pixels, start, settings);
}

}  // namespace

std::optional<EdgeRegion> gather_edge(mtf::ImageView<const float> image, const Roi& roi, RegionFacts& region,
                                      const MeasureOptions& options) {
  constexpr std::int64_t kFineBlocks_px = 4;
  const double local_noise_sd = local_noise(image, roi, region);
  const auto [limits, heaped] = find_limits(image, roi, region, options, region.scale * local_noise_sd);
  region.clipped += heaped;
  std::int64_t block_px = 1;
  const EdgePixels blocks = gather_blocks(image, roi, region, limits, block_px);
  const auto block = static_cast<double>(block_px);
  EdgeModel start = start_edge(blocks, block, static_cast<double>(roi.width), static_cast<double>(roi.height));
  if (!(start.curve.half_length_px > 0.0)) return std::nullopt;
  EdgePixels pixels = gather_pixels(image, roi, region, limits, start.curve, kRange_px);
  FitSettings settings = noise_settings(start, region, options);
  const double extent_px = 0.5 * static_cast<double>(pixels.size()) / (2.0 * start.curve.half_length_px);
  if (block_px > kFineBlocks_px) sharpen_start(pixels, start, block, settings);
  const Neighbours neighbours = find_neighbours(image, roi, region, start);
  settings.tails = neighbours.tails;
  CutPixels cut;
  if (region.clipped > 0) cut = gather_cut(image, roi, region, limits, start.curve, kRange_px, settings.rounding);
  return EdgeRegion{.pixels = std::move(pixels),
                    .cut = std::move(cut),
                    .start = std::move(start),
                    .extent_px = extent_px,
                    .local_noise_sd = local_noise_sd,
                    .settings = settings,
                    .neighbour_px = neighbours.nearest_px};
}

}  // namespace calib
