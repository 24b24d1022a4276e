// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "mtf/engines/kernels.h"
#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/plan_impl.h"
#include "mtf/statistics.h"

namespace mtf {
namespace {

// Mean and extremes of a plane, summed row by row in a fixed order; only a plane with bad pixels pays for their
// details. The same look tells where it is flat, while its rows are at hand.
struct Level {
  double mean = 0.0;       ///< to float: taken off a float, it leaves one rounding of the difference
  double deviation = 0.0;  ///< largest |value - mean|
  double std = 0.0;        ///< where asked for
};

struct RowLook {
  kernels::RowSummary summary;
  double squares = 0.0;  ///< about a level of the plane
};

// What is flat of a row needs no sums.
RowLook look_at(const float* row, std::int64_t width, std::int64_t y, FlatMap& flat, bool squares) {
  if (!flat.any()) return {kernels::summarise_row(row, width)};
  const FlatMap::Kind* kinds = flat.look(y);
  RowLook all{{0.0, row[0], row[0]}};
  for (std::int64_t g = 0, end = 0; g < flat.groups(); g = end) {
    for (end = g + 1; end < flat.groups() && kinds[end] == kinds[g];) ++end;
    const std::int64_t first = g * FlatMap::kGroup, count = std::min(end * FlatMap::kGroup, width) - first;
    const double level = row[first], n = static_cast<double>(count), away = level - flat.level(1);
    const kernels::RowSummary part = kinds[g] == 0 ? kernels::summarise_row(row + first, count)
                                                   : kernels::RowSummary{n * level, row[first], row[first]};
    all.summary = {all.summary.sum + part.sum, std::min(all.summary.min, part.min),
                   std::max(all.summary.max, part.max)};
    if (squares)
      all.squares += kinds[g] == 0 ? kernels::squares_about(row + first, count, flat.level(1)) : n * away * away;
  }
  return all;
}

Level level_of(ImageView<const float> plane, int threads, FlatMap& flat, bool with_std) {
  flat = FlatMap(plane);
  std::vector<RowLook> rows(static_cast<std::size_t>(plane.height));
  parallel_for(plane.height, 64, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      if (y + 1 < end) kernels::prefetch(plane.row(y + 1), plane.width);
      rows[static_cast<std::size_t>(y)] = look_at(plane.row(y), plane.width, y, flat, with_std);
    }
  });
  double sum = 0.0, squares = 0.0, low = rows.front().summary.min, high = rows.front().summary.max;
  for (const RowLook& row : rows) {
    sum += row.summary.sum;
    squares += row.squares;
    low = std::min<double>(low, row.summary.min);
    high = std::max<double>(high, row.summary.max);
  }
  if (!std::isfinite(sum)) {
    const Statistics s = statistics(plane);
    if (s.not_finite > 0)
      throw RuntimeError(std::to_string(s.not_finite) + " pixels are NaN or infinite, the first at column " +
                         std::to_string(s.first_x) + ", row " + std::to_string(s.first_y) +
                         "; replace them (mtf simulate --nan fill|propagate)");
  }
  if (low == high) return {low, 0.0};
  const double samples = static_cast<double>(plane.width) * static_cast<double>(plane.height), mean = sum / samples;
  const double away = flat.any() ? mean - flat.level(1) : 0.0;
  const double level = static_cast<float>(mean);
  return {level, std::max(high - level, level - low), std::sqrt(std::max(0.0, squares / samples - away * away))};
}

void check_size(std::int64_t width, std::int64_t height, const SampleGrid& grid, const char* name) {
  if (width == grid.width && height == grid.height) return;
  throw UsageError(std::string(name) + " image is " + std::to_string(width) + "x" + std::to_string(height) +
                   ", the plan was made for " + std::to_string(grid.width) + "x" + std::to_string(grid.height));
}

void fill(ImageView<float> out, float value) {
  for (std::int64_t y = 0; y < out.height; ++y) std::fill_n(out.row(y), out.width, value);
}

bool share_memory(ImageView<const float> a, ImageView<const float> b) {
  const std::less<const float*> before;
  return before(a.data, b.row(b.height)) && before(b.data, a.row(a.height));
}

Image copy_of(ImageView<const float> plane) {
  Image copy(plane.width, plane.height);
  for (std::int64_t y = 0; y < plane.height; ++y) std::copy_n(plane.row(y), plane.width, copy.view().row(y));
  return copy;
}

}  // namespace

const PlanReport& Plan::report() const { return impl_->report; }
double Plan::dc() const { return impl_->dc; }

void Plan::run(ImageView<const float> in, ImageView<float> out, double border_value, int threads) const {
  run(std::span(&in, 1), std::span(&out, 1), border_value, threads);
}

void Plan::run(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out, double border_value,
               int threads) const {
  if (in.size() != out.size()) throw UsageError("as many output as input planes are needed");
  const bool constant = impl_->options.border == Border::constant;
  if (constant && !(std::abs(border_value) <= std::numeric_limits<float>::max()))
    throw UsageError("the border level has to be a finite float");
  std::vector<Channel> channels;
  std::vector<Image> copies;
  std::vector<FlatMap> flat(in.size());
  const bool reads_first =
      impl_->report.method.starts_with("fft");  // transforms have all of an input before they write
  for (std::size_t c = 0; c < in.size(); ++c) {
    check_size(in[c].width, in[c].height, impl_->report.in, "input");
    check_size(out[c].width, out[c].height, impl_->report.out, "output");
    const Level level = level_of(in[c], threads, flat[c], impl_->report.predicted.flat > 0.0);
    const double step = constant ? std::abs(border_value - level.mean) : 0.0;
    const double deviation = std::max(level.deviation, step);
    if (deviation == 0.0) {
      fill(out[c], static_cast<float>(impl_->dc * level.mean));
    } else if (!impl_->engine) {
      for (std::int64_t y = 0; y < out[c].height; ++y)
        std::memmove(out[c].row(y), in[c].row(y), static_cast<std::size_t>(out[c].width) * sizeof(float));
    } else {
      // A power of two: exact, and neither 1e-30 nor 1e30 leaves the range of float inside the transforms. It and its
      // inverse are floats themselves.
      const double scale = std::ldexp(1.0, -std::clamp(std::ilogb(deviation), -126, 126));
      ImageView<const float> from = in[c];
      if (!reads_first && share_memory(in[c], out[c])) from = copies.emplace_back(copy_of(in[c])).view();
      channels.push_back({from, out[c], level.mean, scale, impl_->dc * level.mean, border_value, &flat[c],
                          impl_->report.predicted.flat * level.std});
    }
  }
  if (!channels.empty()) impl_->engine->run(channels, threads);
}

}  // namespace mtf
