// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/defects/cut_values.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "mtf/work/stop.h"

namespace calib {
namespace {

// How many pixels have the last value, the least one for sign = 1, and how many the next one.
struct Heap {
  std::int64_t last = 0, next = 0;
  float next_value = 0.0F;
};
Heap heap_at(mtf::ImageView<const float> image, const Roi& roi, float end, float sign) {
  Heap heap;
  for (std::int64_t j = roi.y; j < roi.y + roi.height; ++j) {
    mtf::require_going_on();
    const float* row = image.row(j) + roi.x;
    for (std::int64_t i = 0; i < roi.width; ++i) heap.last += row[i] == end ? 1 : 0;
  }
  if (heap.last < 2) return heap;
  float nearest = std::numeric_limits<float>::infinity();
  for (std::int64_t j = roi.y; j < roi.y + roi.height; ++j) {
    mtf::require_going_on();
    const float* row = image.row(j) + roi.x;
    for (std::int64_t i = 0; i < roi.width; ++i) {
      const float away = sign * (row[i] - end);
      if (!(away > 0.0F) || away > nearest) continue;
      if (away < nearest) heap.next = 0;
      nearest = away;
      ++heap.next;
    }
  }
  heap.next_value = end + sign * nearest;
  return heap;
}

// Whether noise has been cut off where the values end.
bool is_cut(const Heap& heap, double end, const RegionFacts& region, double noise_sd) {
  constexpr std::int64_t kFewest = 5;
  constexpr double kMostShare = 0.1;  // of the pixels: more are a side that is clipped altogether
  constexpr double kHeap = 1.5;
  if (heap.last < kFewest || static_cast<double>(heap.last) > kMostShare * static_cast<double>(region.finite))
    return false;
  const bool continuous = std::abs(static_cast<double>(heap.next_value) - end) < noise_sd;
  // Light has no negative values: zero is a limit though one count is as wide as the noise.
  return continuous && (end == 0.0 || static_cast<double>(heap.last) > kHeap * static_cast<double>(heap.next));
}

// Mean and standard deviation of a standard normal number below z.
struct Tail {
  double mean, sd;
};
Tail tail_below(double z) {
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
  const double ratio = density / std::max(1e-300, 0.5 * std::erfc(-z / std::numbers::sqrt2));
  return {-ratio, std::sqrt(std::max(0.0, 1.0 - ratio * (z + ratio)))};
}

// Mean and noise of a pixel under the model.
struct Expected {
  double mean, sd;
};
Expected expected_at(Point at, const EdgeModel& model, const FitState& state) {
  const EdgePoint point = locate(model.curve, at);
  const double d = std::clamp(point.distance_px, -0.999 * kRange_px, 0.999 * kRange_px);
  const double t = point.along_px / model.curve.half_length_px;
  const double esf = state.profile.esf()[static_cast<std::size_t>(DistanceBins::get().index(d))];
  double mean = 0.0;
  for (int a = 0; a < kPlateauTerms; ++a) {
    const auto [across, along] = plateau_powers(a);
    mean += (a % 2 == 0 ? 1.0 - esf : esf) * model.plateau[static_cast<std::size_t>(a)] * std::pow(d, across) *
            std::pow(t, along);
  }
  return {mean, std::sqrt(state.noise.at(esf))};
}

}  // namespace

FoundLimits find_limits(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& region,
                        const MeasureOptions& options, double noise_sd) {
  FoundLimits found{.limits = {options.saturation, options.floor}};
  const auto search = [&](double end, float sign, std::optional<double>& limit) {
    if (limit) return;
    const Heap heap = heap_at(image, roi, static_cast<float>(end), sign);
    if (!is_cut(heap, end, region, noise_sd)) return;
    limit = end;
    found.heaped += heap.last;
  };
  search(region.low, 1.0F, found.limits.floor);
  search(region.high, -1.0F, found.limits.saturation);
  return found;
}

CutPixels gather_cut(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& region,
                     const ValueLimits& limits, const EdgeCurve& curve, double range_px, const Rounding& rounding) {
  CutPixels cut;
  // As gather_pixels scales values, to the last digit.
  const double scale = 1.0 / region.scale;
  const auto scaled = [&](double limit) {
    return (static_cast<double>(static_cast<float>(limit)) - region.offset) * scale;
  };
  const auto gather = [&](const RegionFacts& beyond) {
    const EdgePixels some = gather_pixels(image, roi, beyond, {}, curve, range_px);
    EdgePixels both(cut.pixels.size() + some.size());
    for (const EdgePixels* list : {&std::as_const(cut.pixels), &some})
      for (std::size_t i = 0; i < list->size(); ++i) both.add(list->x()[i], list->y()[i], list->value()[i]);
    cut.pixels = std::move(both);
  };
  // What is rounded to the limit lies within half a step of it.
  if (limits.floor) {
    RegionFacts below = region;
    below.high = static_cast<double>(static_cast<float>(*limits.floor));
    cut.low = scaled(*limits.floor) + 0.5 * rounding.dark;
    gather(below);
  }
  if (limits.saturation) {
    RegionFacts above = region;
    above.low = static_cast<double>(static_cast<float>(*limits.saturation));
    cut.high = scaled(*limits.saturation) - 0.5 * rounding.bright;
    gather(above);
  }
  return cut;
}

std::size_t add_cut(EdgePixels& pixels, const CutPixels& cut, const EdgeModel& model, const FitState& state) {
  constexpr double kMost = 4.0;  // standard deviations
  EdgePixels all(pixels.size() + cut.pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) all.add(pixels.x()[i], pixels.y()[i], pixels.value()[i]);
  for (std::size_t i = 0; i < cut.pixels.size(); ++i) {
    const Point at{cut.pixels.x()[i], cut.pixels.y()[i]};
    const double value = cut.pixels.value()[i];
    const auto [mean, sd] = expected_at(at, model, state);
    if ((value <= cut.low && mean - cut.low < kMost * sd) || (value >= cut.high && cut.high - mean < kMost * sd))
      all.add(at.x, at.y, value);
  }
  const std::size_t added = all.size() - pixels.size();
  pixels = std::move(all);
  return added;
}

void expect_cut(EdgePixels& pixels, const CutPixels& limits, const EdgeModel& model, const FitState& state) {
  double side = 1.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    double& value = pixels.value()[i];
    if (value > limits.low && value < limits.high) continue;
    const auto [mean, sd] = expected_at({pixels.x()[i], pixels.y()[i]}, model, state);
    const bool low = value <= limits.low;
    const Tail tail = tail_below((low ? limits.low - mean : mean - limits.high) / sd);
    const double away = sd * (tail.mean + side * tail.sd);  // does not exceed the limit
    value = low ? mean + away : mean - away;
    side = -side;
  }
}

}  // namespace calib
