// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan_cost.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mtf {
namespace {

double count(std::int64_t n) { return static_cast<double>(n); }

double groups(std::int64_t n, std::int64_t size) { return std::ceil(count(n) / count(size)); }

// Nanoseconds of a transform of kLanes sequences of length n: by its prime factors up to 13, FFTW's beyond.
double transform_ns(std::int64_t n) {
  double weight = 0.0;
  std::int64_t rest = n;
  for (const auto& [p, w] : {std::pair{2, 1.0}, {3, 1.8}, {5, 2.6}, {7, 3.6}, {11, 5.5}, {13, 6.5}})
    for (; rest % p == 0; rest /= p) weight += w;
  return rest == 1 ? 0.88 * count(n) * weight : 25.0 * count(n) * std::log2(count(n));
}

// A chirp goes forwards and backwards.
double inverse_ns(const AxisJob& job) {
  return transform_ns(inverse_length(job)) * (job.resampling == Resampling::chirp ? 2.0 : 1.0);
}

}  // namespace

// Everything is counted in rows of kRow numbers: 5.7 ns each time one is rearranged on its way through an axis, and as
// much again and more where image, buffer and OTF together exceed the second-level cache.
double fft_cost_ms(const AxisJob& x, const AxisJob& y, bool complex_otf) {
  const bool x_cosine = x.frequency.basis == Basis::cosine, y_cosine = y.frequency.basis == Basis::cosine;
  const double blocks = groups(x.keep, x_cosine ? kRow : kLanes), coefficients = blocks * kRow;
  const double terms = count(y_cosine ? y.keep : 2 * y.keep - 1);
  const double x_terms = count(x_cosine ? x.keep : 2 * x.keep - 1);
  const double forward =
      transform_ns(x.frequency.length) + 5.7 * (count(x.samples) + count(x.frequency.length) + coefficients);
  const double backward = inverse_ns(x) + 5.7 * (coefficients + x_terms + count(inverse_length(x) + x.outputs));
  const double column = transform_ns(y.frequency.length) + inverse_ns(y) + 0.77 * terms * (complex_otf ? 2.0 : 1.0);
  const double images = (count(x.samples) * count(y.samples) + count(x.outputs) * count(y.outputs)) / kRow;
  const double rows = blocks * (count(std::max(y.samples, y.outputs)) + terms) + images;
  const double far = std::max(0.0, rows - 12000.0);
  return 1e-6 *
         (groups(y.samples, kRow) * forward + groups(y.outputs, kRow) * backward + blocks * column + 7.3 * far + 700.0);
}

double separable_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t rank) {
  const double pixels = count(x.outputs) * count(y.outputs), rows = count(y.outputs) * count(y.ratio);
  const double across = rows * count(x.outputs) * count(rank) * (0.05 + 0.022 * count(x.count));
  const double down = pixels * (0.15 + 0.022 * count(rank) * count(y.count));
  return 1e-6 * (across + down + 0.25 * count(x.samples) * count(y.samples)) + 2e-3;
}

double direct_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t used, bool mirrored) {
  const double pixels = count(x.outputs) * count(y.outputs);
  const double sums = mirrored ? 0.012 * count(used) + 0.03 * count(y.count) * count(x.ratio) : 0.025 * count(used);
  return 1e-6 * (pixels * (0.2 + sums) + 0.3 * count(x.samples) * count(y.samples)) + 2e-3;
}

}  // namespace mtf
