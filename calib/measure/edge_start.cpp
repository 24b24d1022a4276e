// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calib/measure/edge_fit.h"
#include "mtf/math/clones.h"

namespace calib {
namespace {

constexpr int kDirections = 16;
constexpr int kStrips = 96;  // across the largest extent of the blocks
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
  const double per_strip = 0.5 * kStrips / radius;
  const std::size_t size = samples.size;
  for (std::size_t i = 0; i < size; ++i) {
    const double at = (c * samples.x[i] + s * samples.y[i] + radius) * per_strip;
    strip[i] = static_cast<std::int32_t>(std::clamp(at, 0.0, kStrips - 1.0));
  }
}

Division divide(const Samples& samples, double angle_rad, double radius) {
  struct Strip {
    double count = 0.0, sum = 0.0;
  };
  std::array<std::int32_t, kMostSamples> strip;
  find_strips(samples, std::cos(angle_rad), std::sin(angle_rad), radius, strip);
  std::array<Strip, kStrips> strips{};
  for (std::size_t i = 0; i < samples.size; ++i) {
    Strip& one = strips[static_cast<std::size_t>(strip[i])];
    one.count += 1.0;
    one.sum += samples.value[i];
  }
  Division best{.angle_rad = angle_rad};
  const auto n = static_cast<double>(samples.size);
  double n1 = 0.0, sum1 = 0.0;
  for (std::size_t k = 0; k + 1 < kStrips; ++k) {
    n1 += strips[k].count;
    sum1 += strips[k].sum;
    if (strips[k].count == 0.0 || n1 == n) continue;
    const double a = sum1 / n1, b = (samples.total - sum1) / (n - n1);
    const double score = n1 * (n - n1) / n * (b - a) * (b - a);
    if (score > best.score)
      best = {score, angle_rad, (static_cast<double>(k) + 1.0) * 2.0 * radius / kStrips - radius, a, b};
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

}  // namespace

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

}  // namespace calib
