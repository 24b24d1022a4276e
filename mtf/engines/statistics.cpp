// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mtf/engines/kernels.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

double square(double x) { return x * x; }

}  // namespace

RowMoments row_moments(const float* values, std::int64_t n) {
  RowMoments row;
  row.first = values[0];
  row.last = values[n - 1];
  if (const kernels::RowSummary quick = kernels::summarise_row(values, n); std::isfinite(quick.sum)) {
    row.min = quick.min;
    row.max = quick.max;
    row.finite = n;
    row.mean = row.min == row.max ? row.min : quick.sum / static_cast<double>(n);
    row.squares = kernels::squares_about(values, n, row.mean);
    return row;
  }
  double sum = 0.0;
  for (std::int64_t x = 0; x < n; ++x) {
    const double v = values[x];
    if (!std::isfinite(v)) {
      if (row.first_bad < 0) row.first_bad = x;
      continue;
    }
    if (row.finite++ == 0) row.min = row.max = v;
    row.min = std::min(row.min, v);
    row.max = std::max(row.max, v);
    sum += v;
  }
  if (row.finite == 0) return row;
  row.mean = row.min == row.max ? row.min : sum / static_cast<double>(row.finite);
  for (std::int64_t x = 0; x < n; ++x)
    if (const double d = values[x] - row.mean; std::isfinite(d)) row.squares += d * d;
  return row;
}

std::vector<RowMoments> row_moments(ImageView<const float> plane, int threads) {
  constexpr std::int64_t kRowsAtOnce = 64;
  std::vector<RowMoments> rows(static_cast<std::size_t>(plane.width > 0 ? plane.height : 0));
  parallel_for_each(std::ssize(rows), kRowsAtOnce, threads, [&](std::int64_t y) {
    rows[static_cast<std::size_t>(y)] = row_moments(plane.row(y), plane.width);
  });
  return rows;
}

Statistics statistics_of(std::span<const RowMoments> rows, std::int64_t width) {
  Statistics s;
  double sum = 0.0;
  std::int64_t finite = 0;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    const RowMoments& row = rows[y];
    if (row.first_bad >= 0 && s.first_x < 0) s.first_x = row.first_bad, s.first_y = static_cast<std::int64_t>(y);
    s.not_finite += width - row.finite;
    if (row.finite == 0) continue;
    s.min = finite == 0 ? row.min : std::min(s.min, row.min);
    s.max = finite == 0 ? row.max : std::max(s.max, row.max);
    finite += row.finite;
    sum += row.mean * static_cast<double>(row.finite);
  }
  if (finite == 0) return s;
  s.mean = s.min == s.max ? s.min : sum / static_cast<double>(finite);
  const double scale = std::max(s.max - s.mean, s.mean - s.min);
  if (scale == 0.0) return s;
  double squares = 0.0;
  for (const RowMoments& row : rows)
    if (row.finite > 0)
      squares += row.squares / scale / scale + static_cast<double>(row.finite) * square((row.mean - s.mean) / scale);
  s.std = scale * std::sqrt(squares / static_cast<double>(finite));
  return s;
}

// Each sample counts as often as the canvas repeats it: those of an edge n + 1 times per replicated side.
double canvas_norm_of(std::span<const RowMoments> rows, std::int64_t width, Border border, double border_value,
                      double mean) {
  const auto height = static_cast<std::int64_t>(rows.size());
  const auto n = static_cast<double>(width);
  const double copies = border == Border::reflect ? 2.0 : 1.0;
  double sum = 0.0;
  for (std::int64_t y = 0; y < height; ++y) {
    const RowMoments& row = rows[static_cast<std::size_t>(y)];
    double along = copies * (row.squares + static_cast<double>(row.finite) * square(row.mean - mean));
    double weight = copies;
    if (border == Border::replicate) {
      along += n * (square(row.first - mean) + square(row.last - mean));
      weight += (y == 0 ? static_cast<double>(height) : 0.0) + (y == height - 1 ? static_cast<double>(height) : 0.0);
    }
    sum += weight * along;
  }
  const double area = n * static_cast<double>(height);
  if (border == Border::constant) sum += 8.0 * area * square(border_value - mean);
  return std::sqrt(sum / area);
}

// The bits of a float without its sign are in the order of its magnitude, NaN beyond infinity.
bool all_finite(ImageView<const float> image) {
  constexpr std::uint32_t magnitude = 0x7fffffffU, infinity = 0x7f800000U;
  std::uint32_t largest = 0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    const float* row = image.row(y);
    for (std::int64_t x = 0; x < image.width; ++x)
      largest = std::max(largest, std::bit_cast<std::uint32_t>(row[x]) & magnitude);
  }
  return largest < infinity;
}

Statistics statistics(ImageView<const float> image, int threads) {
  return statistics_of(row_moments(image, threads), image.width);
}

}  // namespace mtf
