// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan_cost.h"

#include <cmath>

namespace mtf {
namespace {

// Nanoseconds of one complex transform of length n, an eighth of kLanes at once: proportional to n times the sum of
// its prime factors' weights. FFTW turns large primes into a convolution of two transforms of a larger length.
double transform_ns(std::int64_t n) {
  double weight = 0.5;
  const auto length = static_cast<double>(n);
  std::int64_t rest = n;
  for (const std::int64_t p : {2, 3, 5, 7, 11, 13})
    for (; rest % p == 0; rest /= p) weight += p == 2 ? 1.0 : p == 3 ? 1.8 : 0.75 * static_cast<double>(p);
  if (rest > 1) weight += 8.0 * std::log2(static_cast<double>(rest));
  return 0.28 * length * weight;
}

}  // namespace

double fft_cost_ms(const AxisJob& x, const AxisJob& y, bool complex_otf) {
  const auto count = [](std::int64_t n) { return static_cast<double>(n); };
  const auto inverse = [](const AxisJob& job) {
    const double once = transform_ns(inverse_length(job));
    return job.resampling == Resampling::chirp ? 2.3 * once : once;
  };
  const bool cosine = x.frequency.basis == Basis::cosine;
  const double columns = count(x.keep) * (cosine ? 0.5 : 1.0);  // complex ones
  const double rows = count(y.samples) * 0.5 * transform_ns(x.frequency.length) +
                      count(y.outputs) * inverse(x) * (x.resampling == Resampling::chirp ? 1.0 : 0.5);
  const double otf = (complex_otf ? 0.9 : 0.5) * count(y.keep) * (y.frequency.basis == Basis::cosine ? 1.0 : 2.0);
  const double across = columns * (transform_ns(y.frequency.length) + otf + inverse(y));
  const double touch = 0.6 * (count(x.samples) * count(y.samples) + count(x.outputs) * count(y.outputs));
  return 1e-6 * (rows + across + touch) + 2e-3;
}

double separable_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t rank) {
  const auto count = [](std::int64_t n) { return static_cast<double>(n); };
  const double pixels = count(x.outputs) * count(y.outputs), rows = count(y.outputs) * count(y.ratio);
  const double across = rows * count(x.outputs) * count(rank) * (0.05 + 0.022 * count(x.count));
  const double down = pixels * (0.15 + 0.022 * count(rank) * count(y.count));
  return 1e-6 * (across + down + 0.25 * count(x.samples) * count(y.samples)) + 2e-3;
}

double direct_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t used, bool mirrored) {
  const auto count = [](std::int64_t n) { return static_cast<double>(n); };
  const double pixels = count(x.outputs) * count(y.outputs);
  const double sums = mirrored ? 0.012 * count(used) + 0.03 * count(y.count) * count(x.ratio) : 0.025 * count(used);
  return 1e-6 * (pixels * (0.2 + sums) + 0.3 * count(x.samples) * count(y.samples)) + 2e-3;
}

}  // namespace mtf
