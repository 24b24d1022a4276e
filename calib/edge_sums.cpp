// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_sums.h"

#include <algorithm>
#include <cmath>

#include "mtf/engines/clones.h"

namespace calib {
namespace {

constexpr std::size_t kChunk = 256;
constexpr double kNear_px = 16.0, kNearStep_px = 0.01, kFarStep_px = 0.5;  // the step is steep only near the edge

struct Chunk {
  std::array<double, kChunk> distance, along, value;
  std::size_t size = 0;
};

void place(const EdgePixels& pixels, const EdgeCurve& curve, std::size_t first, std::size_t step, Chunk& chunk) {
  const Point n = curve.normal();
  const double per_length = 1.0 / curve.half_length_px;
  const bool straight = curve.shape == EdgeCurve::Shape::line;
  chunk.size = std::min(kChunk, (pixels.size() - first + step - 1) / step);
  for (std::size_t k = 0; k < chunk.size; ++k) {
    const std::size_t i = first + k * step;
    const double x = static_cast<double>(pixels.x[i]) - curve.origin.x;
    const double y = static_cast<double>(pixels.y[i]) - curve.origin.y;
    chunk.distance[k] = n.x * x + n.y * y;
    chunk.along[k] = (n.x * y - n.y * x) * per_length;
    chunk.value[k] = static_cast<double>(pixels.value[i]);
  }
  if (straight) return;
  for (std::size_t k = 0; k < chunk.size; ++k) {
    const bool near = std::abs(chunk.distance[k]) < kNear_px;
    const EdgePoint at =
        bend(curve, chunk.distance[k], chunk.along[k] * curve.half_length_px, near ? kNearStep_px : kFarStep_px);
    chunk.distance[k] = at.distance_px;
    chunk.along[k] = at.along_px * per_length;
  }
}

template <int Order>
[[gnu::always_inline]] inline void add(const Chunk& chunk, const EdgeModel& model, const StepProfile& profile,
                                       double* sums) {
  constexpr int kStride = 3 * Order + 3;
  const DistanceBins& bins = DistanceBins::get();
  const auto level = model.level;
  for (std::size_t k = 0; k < chunk.size; ++k) {
    const double d = chunk.distance[k], t = chunk.along[k];
    if (!(std::abs(d) < kReach_px)) continue;
    const int i = bins.index(d);
    const auto& c = profile.cubic[static_cast<std::size_t>(i)];
    const double x = d - bins.centre(i);
    const double e = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
    const double dark = level[0] + level[2] * d + level[4] * t, bright = level[1] + level[3] * d + level[5] * t;
    const double r = chunk.value[k] - (dark + (bright - dark) * e);
    std::array<double, kStride> term;
    term[0] = 1.0;
    term[1] = t;
    for (std::size_t m = 2; m <= 2 * Order; ++m) term[m] = term[m / 2] * term[m - m / 2];
    for (std::size_t m = 0; m <= Order; ++m) term[2 * Order + 1 + m] = r * term[m];
    term[kStride - 1] = r * r;
    double* s = sums + i * kStride;
    for (std::size_t m = 0; m < kStride; ++m) s[m] += term[m];
  }
}

MTFKIT_CLONES void add_straight(const Chunk& chunk, const EdgeModel& model, const StepProfile& profile, double* sums) {
  add<1>(chunk, model, profile, sums);
}
MTFKIT_CLONES void add_parabola(const Chunk& chunk, const EdgeModel& model, const StepProfile& profile, double* sums) {
  add<2>(chunk, model, profile, sums);
}
MTFKIT_CLONES void add_bent(const Chunk& chunk, const EdgeModel& model, const StepProfile& profile, double* sums) {
  add<kHighestOrder>(chunk, model, profile, sums);
}

// An odd function halfway between knots: by the cubic through four where they are evenly spaced.
double middle(const std::array<double, kSideBins + 1>& values, std::size_t i) {
  const DistanceBins& bins = DistanceBins::get();
  const auto width = [&](std::size_t k) {
    const int at = kSideBins + static_cast<int>(k);
    return bins.knot(at + 1) - bins.knot(at);
  };
  const double mean = 0.5 * (values[i] + values[i + 1]);
  const bool even = i + 2 <= kSideBins && width(i + 1) == width(i) && (i == 0 || width(i - 1) == width(i));
  if (!even) return mean;
  const double before = i == 0 ? -values[1] : values[i - 1];
  return 1.125 * mean - 0.0625 * (before + values[i + 2]);
}

}  // namespace

void EdgeSums::add_to_residual(int i, double more) {
  double* bin = sums.data() + static_cast<std::size_t>(i) * stride();
  bin[3 * order + 2] += more * (2.0 * residual(i, 0) + more * count(i));
  for (int k = 0; k <= order; ++k) bin[2 * order + 1 + k] += more * bin[k];
}

double EdgeSums::pure_error(int i) const {
  const double n = count(i);
  return n > 1.0 ? std::max(0.0, square(i) - residual(i, 0) * residual(i, 0) / n) : 0.0;
}

StepProfile make_profile(const ReferenceTable& table) {
  const DistanceBins& bins = DistanceBins::get();
  StepProfile profile;
  profile.cubic.resize(kBins);
  for (auto* list : {&profile.esf, &profile.lsf, &profile.slope[0], &profile.slope[1], &profile.slope[2]})
    list->resize(kBins);
  for (int side = 0; side < kSideBins; ++side) {
    const auto a = static_cast<std::size_t>(side);
    const double h = bins.knot(kSideBins + side + 1) - bins.knot(kSideBins + side);
    // The cubic through values and slopes at both ends, about the middle.
    const double mean = 0.5 * (table.odd[a] + table.odd[a + 1]), rise = (table.odd[a + 1] - table.odd[a]) / h;
    const double bend = (table.lsf[a + 1] - table.lsf[a]) / h, slope = 0.5 * (table.lsf[a] + table.lsf[a + 1]);
    const double c0 = mean - h * h * bend / 8.0, c1 = 1.5 * rise - 0.5 * slope;
    const double c2 = 0.5 * bend, c3 = 2.0 / (h * h) * (slope - rise);
    const auto bright = static_cast<std::size_t>(kSideBins + side),
               dark = static_cast<std::size_t>(kSideBins - 1 - side);
    profile.cubic[bright] = {0.5 + c0, c1, c2, c3};
    profile.cubic[dark] = {0.5 - c0, c1, -c2, c3};
    for (const auto i : {bright, dark}) {
      profile.esf[i] = profile.cubic[i][0];
      profile.lsf[i] = c1;
    }
    for (std::size_t k = 0; k < kShapes; ++k) {
      profile.slope[k][bright] = middle(table.slope[k], a);
      profile.slope[k][dark] = -profile.slope[k][bright];
    }
  }
  return profile;
}

EdgeSums accumulate(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile, int order,
                    std::size_t step) {
  EdgeSums sums(order);
  Chunk chunk;
  for (std::size_t first = 0; first < pixels.size(); first += kChunk * step) {
    place(pixels, model.curve, first, step, chunk);
    (sums.order == 1   ? add_straight
     : sums.order == 2 ? add_parabola
                       : add_bent)(chunk, model, profile, sums.sums.data());
  }
  return sums;
}

}  // namespace calib
