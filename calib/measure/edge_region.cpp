// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "calib/measure/edge_facts.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/residual_sums.h"
#include "mtf/math/clones.h"

namespace calib {
namespace {

constexpr int kDirections = 16;
constexpr int kBlockStrips = 96;  // across the largest extent of the blocks
constexpr std::size_t kMostSamples = 700;

struct Division {
  double score = -1.0;  // sum of squares that the two means explain
  double angle_rad = 0.0, offset = 0.0;
  double below = 0.0, above = 0.0;
};

// A subset of the blocks.
struct Samples {
  std::array<double, kMostSamples> x, y, value;
  std::size_t size = 0;
  double total = 0.0;
};

// Which strip each sample lies in.
MTFKIT_CLONES void find_strips(const Samples& samples, double c, double s, double radius,
                               std::array<std::int32_t, kMostSamples>& strip) {
  const double per_strip = 0.5 * kBlockStrips / radius;
  const std::size_t size = samples.size;
  for (std::size_t i = 0; i < size; ++i) {
    const double at = (c * samples.x[i] + s * samples.y[i] + radius) * per_strip;
    strip[i] = static_cast<std::int32_t>(std::clamp(at, 0.0, kBlockStrips - 1.0));
  }
}

Division divide(const Samples& samples, double angle_rad, double radius) {
  struct Strip {
    double count = 0.0, sum = 0.0;
  };
  std::array<std::int32_t, kMostSamples> strip;
  find_strips(samples, std::cos(angle_rad), std::sin(angle_rad), radius, strip);
  std::array<Strip, kBlockStrips> strips{};
  for (std::size_t i = 0; i < samples.size; ++i) {
    Strip& one = strips[static_cast<std::size_t>(strip[i])];
    one.count += 1.0;
    one.sum += samples.value[i];
  }
  Division best{.angle_rad = angle_rad};
  const auto n = static_cast<double>(samples.size);
  double n1 = 0.0, sum1 = 0.0;
  for (std::size_t k = 0; k + 1 < kBlockStrips; ++k) {
    n1 += strips[k].count;
    sum1 += strips[k].sum;
    if (strips[k].count == 0.0 || n1 == n) continue;
    const double a = sum1 / n1, b = (samples.total - sum1) / (n - n1);
    const double score = n1 * (n - n1) / n * (b - a) * (b - a);
    if (score > best.score)
      best = {score, angle_rad, (static_cast<double>(k) + 1.0) * 2.0 * radius / kBlockStrips - radius, a, b};
  }
  return best;
}

Division best_division(const EdgePixels& blocks) {
  Samples samples;
  const std::size_t step = (blocks.size() + kMostSamples - 1) / kMostSamples;
  for (std::size_t i = 0; i < blocks.size(); i += step) {
    samples.x[samples.size] = blocks.x()[i];
    samples.y[samples.size] = blocks.y()[i];
    samples.value[samples.size++] = blocks.value()[i];
    samples.total += blocks.value()[i];
  }
  double square = 1.0;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    square = std::max(square, blocks.x()[i] * blocks.x()[i] + blocks.y()[i] * blocks.y()[i]);
  const double radius = std::sqrt(square);
  Division best;
  for (int k = 0; k < kDirections; ++k) {
    const Division one = divide(samples, std::numbers::pi * k / kDirections, radius);
    if (one.score > best.score) best = one;
  }
  return best;
}

/// Moves the origin of the curve to the middle of the part of its tangent that lies inside a rectangle about the middle
/// of the region; returns half the length of that part, 0 where the line misses the rectangle.
double centre_on_region(EdgeCurve& curve, double width_px, double height_px) {
  const Point n = curve.normal();
  double low = -INFINITY, high = INFINITY;
  const auto cut = [&](double origin, double direction, double half) {
    if (std::abs(direction) < 1e-12) {
      if (std::abs(origin) > half) high = -INFINITY;
      return;
    }
    const double a = (-half - origin) / direction, b = (half - origin) / direction;
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  };
  cut(curve.origin.x, -n.y, 0.5 * width_px);
  cut(curve.origin.y, n.x, 0.5 * height_px);
  if (!(high > low)) return 0.0;
  const double middle = 0.5 * (low + high);
  curve.origin.x += -n.y * middle;
  curve.origin.y += n.x * middle;
  return 0.5 * (high - low);
}

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

EdgeModel start_edge(const EdgePixels& blocks, double block_px, double width_px, double height_px) {
  // Lengths are in blocks, so that any region fits the range of the tables.
  EdgePixels scaled(blocks.size());
  const double per_px = 1.0 / block_px;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    scaled.add(blocks.x()[i] * per_px, blocks.y()[i] * per_px, blocks.value()[i]);
  const Division division = best_division(scaled);
  EdgeModel model;
  const bool turned = division.above < division.below;  // the normal points to the brighter side
  model.curve.angle_rad = division.angle_rad - (turned ? std::numbers::pi : 0.0);
  model.curve.origin = {division.offset * std::cos(division.angle_rad), division.offset * std::sin(division.angle_rad)};
  model.plateau = {std::min(division.below, division.above), std::max(division.below, division.above)};
  const double width = width_px / block_px, height = height_px / block_px;
  model.curve.half_length_px = std::max(1.0, centre_on_region(model.curve, width, height));
  model.shape.v_px2 = 1.0 + 0.004 * model.curve.half_length_px * model.curve.half_length_px;

  FitSettings settings{
      .max_iterations = 8, .tolerance = 3.0, .every = step_for(scaled, kMostSamples), .least_variance = 1e-4};
  for (const int a : {0, 1, kFirstShift, kFirstShift + 1, kFirstShape + 1})
    settings.unknowns.set(static_cast<std::size_t>(a));
  fit_reference(scaled, model, settings);

  model.curve.origin.x *= block_px;
  model.curve.origin.y *= block_px;
  // The start is no sharper than blocks can tell: an upright edge would stay between the two rows of pixels where it
  // is.
  constexpr double kSharpest = 0.02;
  model.shape.v_px2 = std::max(kSharpest, model.shape.v_px2 - 1.0 / 12.0) * block_px * block_px;
  if (model.plateau[1] < model.plateau[0]) {
    std::swap(model.plateau[0], model.plateau[1]);
    model.curve.angle_rad = std::remainder(model.curve.angle_rad + std::numbers::pi, 2.0 * std::numbers::pi);
  }
  model.curve.half_length_px = centre_on_region(model.curve, width_px, height_px);
  return model;
}

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
