// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/defects/neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace calib {
namespace {

constexpr int kSide = 96;  // px, as far as the pixels of an edge are taken from
constexpr int kStrips = 2 * kSide;
constexpr double kMost = 20.0;  // of the range of the region's values: more is a broken pixel

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
      strip.sum += std::clamp((value - region.offset) / region.scale, -kMost, kMost);
    }
  return strips;
}

}  // namespace

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

}  // namespace calib
