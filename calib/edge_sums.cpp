// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_sums.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "calib/edge_distances.h"
#include "mtf/engines/clones.h"

namespace calib {
namespace {

constexpr std::size_t kChunk = 128;

struct Chunk {
  std::array<double, kChunk> distance, along;  // px, then parts of the half length
  std::array<double, kChunk> esf, residual;    // residual: the value, then less the model
  std::array<std::int32_t, kChunk> bin;        // kBins for pixels out of reach
  std::size_t size = 0;
};

// Coordinates about the tangent at the curve's origin.
MTFKIT_CLONES void place(const float* x, const float* y, const float* value, std::size_t step, Point origin, Point n,
                         Chunk& chunk) {
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    const double dx = static_cast<double>(x[k * step]) - origin.x, dy = static_cast<double>(y[k * step]) - origin.y;
    chunk.distance[k] = n.x * dx + n.y * dy;
    chunk.along[k] = n.x * dy - n.y * dx;
    chunk.residual[k] = static_cast<double>(value[k * step]);
  }
}

// Distances in units of the finest bin, from the end of the reach; those beyond it are the one after the last.
MTFKIT_CLONES void count_steps(const double* __restrict distance, std::int32_t* __restrict steps, std::size_t size) {
  constexpr double kMiddle = kReach_px * kFinest;
  for (std::size_t k = 0; k < size; ++k) {
    const double at = distance[k] * kFinest + kMiddle;
    steps[k] = static_cast<std::int32_t>(at >= 0.0 && at < 2.0 * kMiddle ? at : 2.0 * kMiddle);
  }
}

MTFKIT_CLONES void look_up(const std::array<double, 4>* __restrict cubic, const DistanceBins& bins, Chunk& chunk) {
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    const int i = bins.at_step(chunk.bin[k]);
    const std::array<double, 4>& c = cubic[static_cast<std::size_t>(i)];
    const double x = chunk.distance[k] - bins.centre(i);
    chunk.bin[k] = i;
    chunk.esf[k] = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
  }
}

MTFKIT_CLONES void subtract_model(const std::array<double, kLevels>& level, const double* __restrict distance,
                                  const double* __restrict along, const double* __restrict esf,
                                  double* __restrict residual, std::size_t size) {
  const double a0 = level[0], b0 = level[1], a_d = level[2], b_d = level[3], a_t = level[4], b_t = level[5];
  for (std::size_t k = 0; k < size; ++k) {
    const double d = distance[k], t = along[k];
    const double dark = a0 + a_d * d + a_t * t, bright = b0 + b_d * d + b_t * t;
    residual[k] -= dark + (bright - dark) * esf[k];
  }
}

using Four [[gnu::vector_size(4 * sizeof(double))]] = double;
using Two [[gnu::vector_size(2 * sizeof(double))]] = double;

// 1, t, t^2, r and r t, r^2: the first four as products of two rows of 0, 1, t and r.
MTFKIT_CLONES void add_plain(const Chunk& chunk, double* sums) {
  constexpr Four kOne{1, 0, 0, 0}, kT{0, 1, 1, 0}, kR{0, 0, 0, 1}, kOtherOne{1, 1, 0, 1}, kOtherT{0, 0, 1, 0};
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    const double t = chunk.along[k], r = chunk.residual[k];
    double* s = sums + 8 * static_cast<std::ptrdiff_t>(chunk.bin[k]);
    Four first;
    Two second;
    std::memcpy(&first, s, sizeof first);
    std::memcpy(&second, s + 4, sizeof second);
    first += (kOne + kT * t + kR * r) * (kOtherOne + kOtherT * t);
    second += Two{t, r} * r;
    std::memcpy(s, &first, sizeof first);
    std::memcpy(s + 4, &second, sizeof second);
  }
}

// t^3 .. t^10, r t^2 .. r t^5.
MTFKIT_CLONES void add_bent(const Chunk& chunk, const StepProfile& profile, double* sums) {
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    if (!profile.shows_bends(chunk.bin[k])) continue;
    const double t = chunk.along[k], r = chunk.residual[k], t2 = t * t, t3 = t2 * t, t4 = t2 * t2;
    const std::array<double, 12> term{t3,          t4,           t4 * t, t4 * t2, t4 * t3, t4 * t4,
                                      t4 * t4 * t, t4 * t4 * t2, r * t2, r * t3,  r * t4,  r * t4 * t};
    double* s = sums + 12 * static_cast<std::ptrdiff_t>(chunk.bin[k]);
    for (std::size_t m = 0; m < 12; ++m) s[m] += term[m];
  }
}

// How much of the second difference goes into the value halfway between knots: that of the cubic through four where
// they are evenly spaced, of the straight line elsewhere.
constexpr std::array<double, kSideBins> bulges() {
  std::array<double, kSideBins> bulge{};
  std::size_t i = 0;
  double from = 0.0;
  for (const DistanceZone& zone : kDistanceZones) {
    const auto count = static_cast<std::size_t>((zone.end_px - from) / zone.step_px);
    for (std::size_t k = 0; k < count; ++k) bulge[i + k] = (k > 0 || i == 0) && k + 1 < count ? 0.0625 : 0.0;
    i += count;
    from = zone.end_px;
  }
  return bulge;
}

// An odd function halfway between knots, on both sides.
void halfway(const std::array<double, kSideBins + 1>& values, double* out) {
  static constexpr std::array<double, kSideBins> kBulge = bulges();
  const auto put = [&](std::size_t i, double before, double after) {
    const double sum = values[i] + values[i + 1], value = 0.5 * sum + kBulge[i] * (sum - before - after);
    out[kSideBins + i] = value;
    out[kSideBins - 1 - i] = -value;
  };
  put(0, -values[1], values[2]);
  for (std::size_t i = 1; i + 1 < kSideBins; ++i) put(i, values[i - 1], values[i + 2]);
  put(kSideBins - 1, values[kSideBins - 2], values[kSideBins]);
}

}  // namespace

EdgeSums::EdgeSums(bool bends) : plain_((kBins + 1) * kPlain) {
  if (bends) bent_.resize((kBins + 1) * kBent);
}

void EdgeSums::take_from_residual(int i, const std::array<double, kHighestOrder + 1>& change, bool bends) {
  const auto bin = static_cast<std::size_t>(i);
  double* s = plain_.data() + bin * kPlain;
  if (!bends) {
    const auto [a, b] = std::array{change[0], change[1]};
    const double r = a * s[0] + b * s[1], rt = a * s[1] + b * s[2];
    s[5] -= a * (2.0 * s[3] - r) + b * (2.0 * s[4] - rt);
    s[3] -= r;
    s[4] -= rt;
    return;
  }
  std::array<double, kHighestOrder + 1> taken{};
  for (int k = 0; k <= kHighestOrder; ++k)
    for (int j = 0; j <= kHighestOrder; ++j)
      taken[static_cast<std::size_t>(k)] += change[static_cast<std::size_t>(j)] * moment(i, j + k);
  for (int k = 0; k <= kHighestOrder; ++k) {
    const auto at = static_cast<std::size_t>(k);
    s[5] -= change[at] * (2.0 * residual(i, k) - taken[at]);
  }
  double* b = bent_.data() + bin * kBent;
  for (std::size_t k = 0; k <= kHighestOrder; ++k) (k < 2 ? s[3 + k] : b[6 + k]) -= taken[k];
}

double EdgeSums::pure_error(int i) const {
  const double n = count(i);
  return n > 1.0 ? std::max(0.0, square(i) - residual(i, 0) * residual(i, 0) / n) : 0.0;
}

StepProfile make_profile(const ReferenceTable& table) {
  const DistanceBins& bins = DistanceBins::get();
  StepProfile profile;
  profile.cubic.resize(kBins + 1);
  for (auto* list : {&profile.esf, &profile.lsf, &profile.slope[0], &profile.slope[1], &profile.slope[2]})
    list->resize(kBins);
  for (int side = 0; side < kSideBins; ++side) {
    const auto a = static_cast<std::size_t>(side);
    const double h = bins.width(kSideBins + side);
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
  }
  for (std::size_t k = 0; k < kShapes; ++k) halfway(table.slope[k], profile.slope[k].data());
  find_bend_bins(profile);
  return profile;
}

void find_bend_bins(StepProfile& profile) {
  const double least = 1e-3 * std::abs(profile.lsf[kSideBins]);
  const auto seen = [least](double value) { return std::abs(value) > least; };
  const auto first = std::find_if(profile.lsf.begin(), profile.lsf.end(), seen);
  const auto last = std::find_if(profile.lsf.rbegin(), profile.lsf.rend(), seen);
  profile.bend_first = static_cast<int>(first - profile.lsf.begin());
  profile.bend_end = static_cast<int>(profile.lsf.rend() - last);
}

EdgeSums accumulate(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile, bool bends,
                    std::size_t step) {
  EdgeSums sums(bends);
  const double per_length = 1.0 / model.curve.half_length_px;
  const Point normal = model.curve.normal();
  Chunk chunk;
  for (std::size_t first = 0; first < pixels.size(); first += kChunk * step) {
    chunk.size = std::min(kChunk, (pixels.size() - first + step - 1) / step);
    place(&pixels.x[first], &pixels.y[first], &pixels.value[first], step, model.curve.origin, normal, chunk);
    bend_all(model.curve, {chunk.distance.data(), chunk.size}, {chunk.along.data(), chunk.size});
    for (std::size_t k = 0; k < chunk.size; ++k) chunk.along[k] *= per_length;
    count_steps(chunk.distance.data(), chunk.bin.data(), chunk.size);
    look_up(profile.cubic.data(), DistanceBins::get(), chunk);
    subtract_model(model.level, chunk.distance.data(), chunk.along.data(), chunk.esf.data(), chunk.residual.data(),
                   chunk.size);
    add_plain(chunk, sums.plain_.data());
    if (bends) add_bent(chunk, profile, sums.bent_.data());
  }
  return sums;
}

}  // namespace calib
