// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan_cost.h"

#include <algorithm>
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

namespace {

double whole_vectors(std::int64_t n) { return 16.0 * std::ceil(static_cast<double>(n) / 16.0); }

// Nanoseconds of fetching the rows of samples that tiles of `tile_rows` output rows need: a call a row, samples beyond
// the edges one by one, and the others, which ratios other than 1, 2 and 4 sort into phases with strides.
double load_ns(const TapAxis& x, const TapAxis& y, double tile_rows, double& rows) {
  const double outputs = static_cast<double>(y.outputs), tiles = std::ceil(outputs / tile_rows);
  rows = outputs * static_cast<double>(y.ratio) + tiles * static_cast<double>(y.count);
  const double sample = x.ratio == 1 ? 0.25 : x.ratio == 2 || x.ratio == 4 ? 0.32 : 0.65;
  const double calls = 35.0 * std::ceil(static_cast<double>(x.outputs) / 256.0);
  return rows * (calls + 5.5 * static_cast<double>(x.count) +
                 sample * static_cast<double>(x.outputs) * static_cast<double>(x.ratio));
}

}  // namespace

double separable_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t rank) {
  const auto terms = static_cast<double>(rank), x_count = static_cast<double>(x.count),
             y_count = static_cast<double>(y.count), ratio = static_cast<double>(y.ratio);
  const double tile_rows = std::clamp((384.0 / terms - y_count) / ratio, std::max(16.0, y_count / ratio), 256.0);
  const double width = whole_vectors(x.outputs), height = static_cast<double>(y.outputs);
  double rows = 0.0;
  const double load = load_ns(x, y, tile_rows, rows);
  return 1e-6 * (load + width * (0.030 * rows * terms * x_count + height * (0.2 + 0.025 * terms * y_count))) + 1e-3;
}

double direct_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t used, bool mirrored) {
  const double width = whole_vectors(x.outputs), height = static_cast<double>(y.outputs);
  const auto taps = static_cast<double>(used);
  double rows = 0.0;
  const double load = load_ns(x, y, 64.0, rows), calls = height * std::ceil(width / 256.0) * taps;
  const double added = static_cast<double>(y.count * x.ratio) * (width + 32.0);
  const double sums = mirrored ? height * (width * (0.5 + 0.0132 * taps) + 0.0085 * added) + 2.1 * calls
                               : height * width * 0.0286 * taps + 6.3 * calls;
  return 1e-6 * (load + sums) + 1e-3;
}

}  // namespace mtf
