// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/mean_and_deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

constexpr std::int64_t kPlaces = 8, kTogether = 16;  // places along each side, samples at each

double largest_deviation(double mean, double low, double high) { return std::max(high - mean, mean - low); }

kernels::RowSummary together(const kernels::RowSummary& a, const kernels::RowSummary& b) {
  return {a.sum + b.sum, std::min(a.min, b.min), std::max(a.max, b.max)};
}

// Uniform runs of a row need no sums.
kernels::RowSummary summarise(const float* row, std::int64_t width, std::int64_t y, UniformRuns& flat) {
  if (!flat.any()) return kernels::summarise_row(row, width);
  const UniformRuns::Kind* kinds = flat.classify_row(y);
  kernels::RowSummary all{0.0, row[0], row[0]};
  for (std::int64_t g = 0, end = 0; g < flat.groups(); g = end) {
    for (end = g + 1; end < flat.groups() && kinds[end] == kinds[g];) ++end;
    const float* first = row + g * UniformRuns::kGroup;
    const std::int64_t count = std::min(end * UniformRuns::kGroup, width) - g * UniformRuns::kGroup;
    all = together(all, kinds[g] == 0 ? kernels::summarise_row(first, count)
                                      : kernels::RowSummary{static_cast<double>(count) * *first, *first, *first});
  }
  return all;
}

}  // namespace

std::optional<MeanAndDeviation> sampled_mean_and_deviation(ImageView<const float> plane) {
  const std::int64_t count = std::min(kTogether, plane.width);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  kernels::RowSummary all{0.0, kInfinity, -kInfinity};
  for (std::int64_t j = 0; j < kPlaces; ++j)
    for (std::int64_t i = 0; i < kPlaces; ++i)
      all = together(all, kernels::summarise_row(plane.row((2 * j + 1) * plane.height / (2 * kPlaces)) +
                                                     (2 * i + 1) * (plane.width - count) / (2 * kPlaces),
                                                 count));
  if (!std::isfinite(all.sum) || all.min == all.max) return std::nullopt;
  const double mean = static_cast<float>(all.sum / static_cast<double>(kPlaces * kPlaces * count));
  return MeanAndDeviation{mean, largest_deviation(mean, all.min, all.max)};
}

MeanAndDeviation mean_and_deviation(ImageView<const float> plane, int threads, UniformRuns& flat) {
  flat = UniformRuns(plane);
  std::vector<kernels::RowSummary> rows(static_cast<std::size_t>(plane.height));
  parallel_for(plane.height, 64, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      if (y + 1 < end) kernels::prefetch(plane.row(y + 1), plane.width);
      rows[static_cast<std::size_t>(y)] = summarise(plane.row(y), plane.width, y, flat);
    }
  });
  kernels::RowSummary all{0.0, rows.front().min, rows.front().max};
  for (const kernels::RowSummary& row : rows) all = together(all, row);
  if (!std::isfinite(all.sum)) {
    const Statistics s = statistics(plane);
    if (s.not_finite > 0)
      throw RuntimeError(std::to_string(s.not_finite) + " pixels are NaN or infinite, the first at column " +
                         std::to_string(s.first_x) + ", row " + std::to_string(s.first_y) +
                         "; replace them (mtf simulate --nan fill|propagate)");
  }
  if (all.min == all.max) return {all.min, 0.0};
  const double mean =
      static_cast<float>(all.sum / (static_cast<double>(plane.width) * static_cast<double>(plane.height)));
  return {mean, largest_deviation(mean, all.min, all.max)};
}

double canvas_deviation(const MeanAndDeviation& plane, Border border, double border_value) {
  return std::max(plane.deviation, border == Border::constant ? std::abs(border_value - plane.mean) : 0.0);
}

double std_of(const kernels::Moments& moments, std::int64_t samples) {
  const double n = static_cast<double>(samples);
  return std::sqrt(std::max(0.0, moments.squares - moments.sum * moments.sum / n) / n);
}

bool is_near(const kernels::Moments& moments, std::int64_t samples) {
  constexpr double kNear = 0.25;
  return std::isfinite(moments.squares) &&
         std::abs(moments.sum) / static_cast<double>(samples) <= kNear * std_of(moments, samples);
}

Channel recentred(Channel channel, Border border, int threads) {
  UniformRuns unused;
  const MeanAndDeviation plane = mean_and_deviation(channel.in, threads, unused);
  channel.mean = plane.mean;
  channel.scale = scale_for(canvas_deviation(plane, border, channel.border_value));
  channel.sampled = false;
  return channel;
}

double scale_for(double deviation) { return std::ldexp(1.0, -std::clamp(std::ilogb(deviation), -126, 126)); }

}  // namespace mtf
