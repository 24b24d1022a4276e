// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/residual_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "mtf/math/clones.h"
#include "mtf/work/stop.h"

namespace calib {
namespace {

// Distances of many pixels from an edge at once, in loops that the compiler can vectorise.

constexpr double kNear_px = 16.0, kNearStep_px = 0.01, kFarStep_px = 0.5;
constexpr std::size_t kPowers = 4;  // t^2 .. t^5
constexpr std::size_t kTogether = 128;

MTFKIT_CLONES void bend_circle(double k, double* u, double* s, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double square = s[i] * s[i] + u[i] * u[i], away = 1.0 - k * u[i], turn = k * s[i];
    const double root = std::sqrt(turn * turn + away * away);  // distance from the centre x k
    u[i] = (2.0 * u[i] - k * square) / (1.0 + root);
    s[i] = root > 0.0 ? s[i] / root : 0.0;
  }
}

struct Polynomial {
  std::array<double, kPowers> c{};
  double half_length_px = 1.0;
};

// One step of Newton's method for the feet s of the points (u, start), with (s - start) + g'(s) (g(s) - u) = 0, its
// derivative kept positive; `height` becomes g at the new feet. Returns whether a step was longer than the search may
// end with.
MTFKIT_CLONES bool step_feet(const Polynomial& curve, const double* u, const double* start, double* s, double* height,
                             std::size_t n) {
  const double half = curve.half_length_px, per_px = 1.0 / half;
  const auto [c2, c3, c4, c5] = curve.c;
  int longer = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double inside = std::min(std::max(s[i], -half), half), beyond = s[i] - inside, t = inside * per_px;
    const double slope = t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5))) * per_px;
    const double g = t * t * (c2 + t * (c3 + t * (c4 + t * c5))) + slope * beyond;  // beyond the ends a tangent
    const double curved = (2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))) * per_px * per_px;
    const double bend = beyond == 0.0 ? curved : 0.0;
    const double pull = (s[i] - start[i]) + slope * (g - u[i]);
    const double step = pull / std::max(1.0 + slope * slope + bend * (g - u[i]), 0.25);
    s[i] -= step;
    height[i] = g - step * (slope - 0.5 * step * bend);
    longer |= std::abs(step) > (std::abs(u[i]) < kNear_px ? kNearStep_px : kFarStep_px) ? 1 : 0;
  }
  return longer != 0;
}

MTFKIT_CLONES void measure_feet(const double* start, const double* height, const double* s, double* u, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double away = u[i] - height[i], along = s[i] - start[i];
    u[i] = std::copysign(std::sqrt(along * along + away * away), away);
  }
}

/// u across and s along the tangent at the curve's origin, in px (edge_curve.h), become distances from the curve and
/// positions of the feet on it. The search for the feet ends with a step below 0.01 px near the edge and 0.5 px where
/// the edge spread function is flat; the error of a distance is of third order in that step.
void bend_all(const EdgeCurve& curve, std::span<double> u_px, std::span<double> s_px) {
  if (curve.shape == EdgeCurve::Shape::line) return;
  if (curve.shape == EdgeCurve::Shape::circle) {
    bend_circle(curve.curvature_per_px, u_px.data(), s_px.data(), u_px.size());
    return;
  }
  Polynomial polynomial{.half_length_px = curve.half_length_px};
  std::copy_n(curve.coefficient.begin(), std::min(kPowers, curve.coefficient.size()), polynomial.c.begin());
  std::array<double, kTogether> start, height;
  for (std::size_t first = 0; first < u_px.size(); first += kTogether) {
    const std::size_t n = std::min(kTogether, u_px.size() - first);
    double *const u = u_px.data() + first, *const s = s_px.data() + first;
    std::copy_n(s, n, start.begin());
    constexpr int kMostSteps = 40;
    for (int k = 0; k < kMostSteps; ++k)
      if (!step_feet(polynomial, u, start.data(), s, height.data(), n)) break;
    measure_feet(start.data(), height.data(), s, u, n);
  }
}

constexpr std::size_t kChunk = 128;

struct Chunk {
  std::array<double, kChunk> distance, along;  // px, then parts of the half length
  std::array<double, kChunk> esf, residual;    // residual: the value, then less the model
  std::array<std::int32_t, kChunk> bin;        // kBins for pixels beyond the range
  std::size_t size = 0;
};

// Coordinates about the tangent at the curve's origin.
MTFKIT_CLONES void place(const double* x, const double* y, const double* value, std::size_t step, Point origin, Point n,
                         Chunk& chunk) {
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    const double dx = x[k * step] - origin.x, dy = y[k * step] - origin.y;
    chunk.distance[k] = n.x * dx + n.y * dy;
    chunk.along[k] = n.x * dy - n.y * dx;
    chunk.residual[k] = value[k * step];
  }
}

// Counted outwards from the edge, the number of a bin is linear in the distance in each zone, with a smaller slope in
// each next one: it is the least of these linear functions.
struct ZoneLine {
  double start, per_px;
};
constexpr std::array<ZoneLine, kDistanceZones.size()> zone_lines() {
  std::array<ZoneLine, kDistanceZones.size()> lines{};
  double bins = 0.0, from = 0.0;
  for (std::size_t z = 0; z < lines.size(); ++z) {
    const DistanceZone& zone = kDistanceZones[z];
    lines[z] = {bins - from / zone.step_px, 1.0 / zone.step_px};
    bins += (zone.end_px - from) / zone.step_px;
    from = zone.end_px;
  }
  return lines;
}

// The bin of each distance, kBins beyond the range.
MTFKIT_CLONES void find_bins(const double* __restrict distance, std::int32_t* __restrict bin, std::size_t size) {
  constexpr std::array kLines = zone_lines();
  for (std::size_t k = 0; k < size; ++k) {
    const double d = distance[k], away = std::abs(d);
    double outwards = kLines[0].per_px * away;
    for (std::size_t z = 1; z < kLines.size(); ++z)
      outwards = std::min(outwards, kLines[z].start + kLines[z].per_px * away);
    const bool inside = outwards < kSideBins;  // a distance just below the range may round up to its end
    const auto whole = static_cast<std::int32_t>(inside ? outwards : 0.0);
    const std::int32_t found = d < 0.0 ? kSideBins - 1 - whole : kSideBins + whole;
    bin[k] = inside ? found : kBins;
  }
}

MTFKIT_CLONES void interpolate(const StepProfile& profile, const DistanceBins& bins, Chunk& chunk) {
  const double *const c0 = profile.cubic(0).data(), *const c1 = profile.cubic(1).data(),
                      *const c2 = profile.cubic(2).data(), *const c3 = profile.cubic(3).data();
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    const int i = std::min(chunk.bin[k], kBins - 1);  // beyond the range any bin will do
    const double x = chunk.distance[k] - bins.centre(i);
    chunk.esf[k] = c0[i] + x * (c1[i] + x * (c2[i] + x * c3[i]));
  }
}

MTFKIT_CLONES void subtract_model(const std::array<double, kPlateauTerms>& plateau, const double* __restrict distance,
                                  const double* __restrict along, const double* __restrict esf,
                                  double* __restrict residual, std::size_t size) {
  const std::array<double, kPlateauTerms> p = plateau;
  for (std::size_t k = 0; k < size; ++k) {
    const double d = distance[k], t = along[k];
    const double dark = p[0] + d * (p[2] + p[6] * d + p[8] * t) + t * (p[4] + p[10] * t);
    const double bright = p[1] + d * (p[3] + p[7] * d + p[9] * t) + t * (p[5] + p[11] * t);
    residual[k] -= dark + (bright - dark) * esf[k];
  }
}

using Four [[gnu::vector_size(4 * sizeof(double))]] = double;

// 1, t, t^2, r and r t, r^2: the first four as products of two rows of 0, 1, t and r.
MTFKIT_CLONES void add_plain(const Chunk& chunk, double* sums) {
  constexpr Four kOne{1, 0, 0, 0}, kT{0, 1, 1, 0}, kR{0, 0, 0, 1}, kOtherOne{1, 1, 0, 1}, kOtherT{0, 0, 1, 0};
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    const double t = chunk.along[k], r = chunk.residual[k];
    double* s = sums + 8 * static_cast<std::ptrdiff_t>(chunk.bin[k]);
    Four first, second;
    std::memcpy(&first, s, sizeof first);
    std::memcpy(&second, s + 4, sizeof second);
    first += (kOne + kT * t + kR * r) * (kOtherOne + kOtherT * t);
    second += Four{t * r, r * r, 0.0, 0.0};
    std::memcpy(s, &first, sizeof first);
    std::memcpy(s + 4, &second, sizeof second);
  }
}

// t^3, t^4, r t^2, then t^5, t^6, r t^3 and so on, four numbers an order above the first, in bins from `first` on.
MTFKIT_CLONES void add_bent(const Chunk& chunk, int orders, int first, int bins, double* sums) {
  const std::size_t size = chunk.size;
  for (std::size_t k = 0; k < size; ++k) {
    const int bin = chunk.bin[k] - first;
    if (bin < 0 || bin >= bins) continue;
    const double t = chunk.along[k], t2 = t * t;
    const Four more{t2, t2, t, 0.0};
    Four powers{t2 * t, t2 * t2, chunk.residual[k] * t2, 0.0};
    double* s = sums + 4 * static_cast<std::ptrdiff_t>(bin * orders);
    for (int order = 0; order < orders; ++order, s += 4, powers *= more) {
      Four sum;
      std::memcpy(&sum, s, sizeof sum);
      sum += powers;
      std::memcpy(s, &sum, sizeof sum);
    }
  }
}

// Transposes four numbers a bin, those of the next bin `stride` further on, to four rows.
MTFKIT_CLONES void turn(const double* sums, std::size_t stride, std::size_t first, std::size_t end,
                        const std::array<double*, 4>& rows) {
  for (std::size_t i = first; i < end; i += 4, sums += 4 * stride) {
    Four a, b, c, d;
    std::memcpy(&a, sums, sizeof a);
    std::memcpy(&b, sums + stride, sizeof b);
    std::memcpy(&c, sums + 2 * stride, sizeof c);
    std::memcpy(&d, sums + 3 * stride, sizeof d);
    const Four ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Four cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
    b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
    c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
    d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
    std::memcpy(rows[0] + i, &a, sizeof a);
    std::memcpy(rows[1] + i, &b, sizeof b);
    std::memcpy(rows[2] + i, &c, sizeof c);
    std::memcpy(rows[3] + i, &d, sizeof d);
  }
}

// Calls visit(chunk) for every `step`-th pixel, a chunk at a time.
template <class Visit>
void visit_chunks(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile, std::size_t step,
                  const Visit& visit) {
  const double per_length = 1.0 / model.curve.half_length_px;
  const Point normal = model.curve.normal();
  Chunk chunk;
  for (std::size_t first = 0; first < pixels.size(); first += kChunk * step) {
    mtf::require_going_on();
    chunk.size = std::min(kChunk, (pixels.size() - first + step - 1) / step);
    place(pixels.x() + first, pixels.y() + first, pixels.value() + first, step, model.curve.origin, normal, chunk);
    bend_all(model.curve, {chunk.distance.data(), chunk.size}, {chunk.along.data(), chunk.size});
    for (std::size_t k = 0; k < chunk.size; ++k) chunk.along[k] *= per_length;
    find_bins(chunk.distance.data(), chunk.bin.data(), chunk.size);
    interpolate(profile, DistanceBins::get(), chunk);
    subtract_model(model.plateau, chunk.distance.data(), chunk.along.data(), chunk.esf.data(), chunk.residual.data(),
                   chunk.size);
    visit(chunk);
  }
}

}  // namespace

void EdgeSums::take_from_residual(const BinRow& change, const StepProfile& profile) {
  for (std::size_t i = 0; i < kBins; ++i) rows_[0][i] -= change[i] * (2.0 * residual(0)[i] - change[i] * moment(0)[i]);
  for (int k = 0; k <= order(); ++k) {
    BinRow& sum = rows_[residual_row(k)];
    const auto first = static_cast<std::size_t>(k > 1 ? profile.bend_first : 0);
    const auto end = static_cast<std::size_t>(k > 1 ? profile.bend_end : kBins);
    for (std::size_t i = first; i < end; ++i) sum[i] -= change[i] * moment(k)[i];
  }
}

double EdgeSums::pure_error(int i) const {
  const auto at = static_cast<std::size_t>(i);
  const double n = moment(0)[at], r = residual(0)[at];
  return n > 1.0 ? std::max(0.0, square()[at] - r * r / n) : 0.0;
}

EdgeSums accumulate(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile, int order,
                    std::size_t step) {
  const int first_bent = profile.bend_first, orders = order - 1;
  const int bent_bins = orders > 0 ? profile.bend_end - first_bent : 0;
  // One cache line a bin, and one more bin for pixels beyond the range.
  constexpr std::size_t kPlain = 8, kBent = 4;
  alignas(64) std::array<double, (kBins + 1) * kPlain> plain{};
  std::vector<double> bent(kBent * static_cast<std::size_t>(bent_bins * orders));
  visit_chunks(pixels, model, profile, step, [&](const Chunk& chunk) {
    add_plain(chunk, plain.data());
    if (orders > 0) add_bent(chunk, orders, first_bent, bent_bins, bent.data());
  });
  EdgeSums sums;
  sums.rows_.resize(EdgeSums::rows_of(order));
  const auto moment = [&](int k) { return sums.rows_[EdgeSums::moment_row(k)].data(); };
  const auto residual = [&](int k) { return sums.rows_[EdgeSums::residual_row(k)].data(); };
  BinRow unused;
  turn(plain.data(), kPlain, 0, kBins, {moment(0), moment(1), moment(2), residual(0)});
  turn(plain.data() + 4, kPlain, 0, kBins, {residual(1), sums.rows_[0].data(), unused.data(), unused.data()});
  for (int k = 2; k <= order; ++k)
    turn(bent.data() + kBent * static_cast<std::size_t>(k - 2), kBent * static_cast<std::size_t>(orders),
         static_cast<std::size_t>(first_bent), static_cast<std::size_t>(profile.bend_end),
         {moment(2 * k - 1), moment(2 * k), residual(k), unused.data()});
  return sums;
}

double largest_deviation(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile,
                         const BinRow& variance) {
  double square = 0.0;
  visit_chunks(pixels, model, profile, 1, [&](const Chunk& chunk) {
    for (std::size_t k = 0; k < chunk.size; ++k) {
      const auto bin = static_cast<std::size_t>(chunk.bin[k]);
      if (bin < kBins) square = std::max(square, chunk.residual[k] * chunk.residual[k] / variance[bin]);
    }
  });
  return std::sqrt(square);
}

PixelResiduals residuals_of(const EdgePixels& pixels, const EdgeModel& model, const StepProfile& profile) {
  PixelResiduals all;
  all.bin.reserve(pixels.size());
  all.residual.reserve(pixels.size());
  visit_chunks(pixels, model, profile, 1, [&](const Chunk& chunk) {
    const auto size = static_cast<std::ptrdiff_t>(chunk.size);
    all.bin.insert(all.bin.end(), chunk.bin.begin(), chunk.bin.begin() + size);
    all.residual.insert(all.residual.end(), chunk.residual.begin(), chunk.residual.begin() + size);
  });
  return all;
}

}  // namespace calib
