// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/plan_cost.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mtf/engines/fft/spectral.h"

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
double inverse_ns(const AxisTransform& job) {
  return transform_ns(inverse_length(job)) * (job.resampling == Resampling::chirp ? 2.0 : 1.0);
}

}  // namespace

// Costs are counted in rows of kRow numbers: 5.7 ns each time an axis rearranges one, and 7.3 ns more for each row by
// which image, buffer and OTF together exceed the second-level cache.
double fft_cost_ms(const AxisTransform& x, const AxisTransform& y, bool real_otf) {
  const double parts = count(static_cast<std::int64_t>(otf_parts(x, y, real_otf).size())), planes = x.odd ? 2.0 : 1.0;
  const bool x_cosine = x.frequency.basis == Basis::cosine, y_cosine = y.frequency.basis == Basis::cosine;
  const double blocks = groups(x.keep, x_cosine ? kRow : kLanes), coefficients = blocks * kRow;
  const double terms = count(y_cosine ? y.keep : 2 * y.keep - 1);
  const double x_terms = count(x_cosine ? x.keep : 2 * x.keep - 1);
  const double forward =
      transform_ns(x.frequency.length) + 5.7 * (count(x.samples) + count(x.frequency.length) + coefficients);
  const double backward = inverse_ns(x) + 5.7 * (coefficients + x_terms + count(inverse_length(x) + x.outputs));
  const double product = 0.77 * terms * (real_otf || x_cosine ? 1.0 : 2.0);
  const double column = transform_ns(y.frequency.length) + parts * (inverse_ns(y) + product) +
                        (parts - planes) * 9.0 * count(y.outputs);  // what is added to another part
  const double images = (count(x.samples) * count(y.samples) + count(x.outputs) * count(y.outputs)) / kRow;
  const double rows = blocks * (planes * count(std::max(y.samples, y.outputs)) + parts * terms) + images;
  const double far = std::max(0.0, rows - 12000.0);
  return 1e-6 * (groups(y.samples, kRow) * forward + planes * groups(y.outputs, kRow) * backward + blocks * column +
                 7.3 * far + 700.0);
}

namespace {

double whole_vectors(std::int64_t n) { return 16.0 * std::ceil(static_cast<double>(n) / 16.0); }

// Nanoseconds of one pass over the whole scene (its mean), and of fetching the rows of samples that tiles of
// `tile_rows` output rows need: a call a row, samples beyond the edges one by one, and the others, which ratios other
// than 1, 2 and 4 sort into phases with strides.
double load_ns(const TapAxis& x, const TapAxis& y, double tile_rows, double& rows) {
  const double tiles = std::ceil(count(y.outputs) / tile_rows);
  rows = count(y.outputs * y.ratio) + tiles * count(y.count);
  const double sample = x.ratio == 1 ? 0.22 : x.ratio == 2 || x.ratio == 4 ? 0.36 : 0.6;
  const double row = 35.0 * groups(x.outputs, 256) + 5.5 * count(x.count) + sample * count(x.outputs * x.ratio);
  return count(y.samples) * (20.0 + 0.15 * count(x.samples)) + rows * row;
}

}  // namespace

double separable_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t rank) {
  const double tile_rows = std::clamp((384.0 / count(rank) - count(y.count)) / count(y.ratio),
                                      std::max(16.0, count(y.count) / count(y.ratio)), 256.0);
  const double width = whole_vectors(x.outputs);
  double rows = 0.0;
  const double load = load_ns(x, y, tile_rows, rows);
  const double across = rows * count(rank) * (0.18 + 0.030 * count(x.count));
  const double down = count(y.outputs) * (0.2 + 0.025 * count(rank * y.count));
  return 1e-6 * (load + width * (across + down)) + 1e-3;
}

double direct_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t used, bool mirrored) {
  const double width = whole_vectors(x.outputs), height = count(y.outputs), taps = count(used);
  double rows = 0.0;
  const double load = load_ns(x, y, 64.0, rows), calls = groups(x.outputs, 256) * taps;
  const double added = count(y.count * x.ratio) * (width + 32.0);
  const double row =
      mirrored ? width * (0.5 + 0.0132 * taps) + 0.0085 * added + 2.1 * calls : width * 0.0286 * taps + 6.3 * calls;
  return 1e-6 * (load + height * row) + 1e-3;
}

}  // namespace mtf
