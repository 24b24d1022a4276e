// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps.h"

#include <algorithm>
#include <cmath>

#include "mtf/engines/kernels.h"
#include "mtf/engines/taps_tile.h"

namespace mtf {
namespace {

using namespace taps;  // NOLINT: the parts of these engines

constexpr std::int64_t kTileFloats = std::int64_t{96} << 10;  // of rows between the two passes: a share of the L2 cache

constexpr std::int64_t kDirectRows = 64;

bool all_mirrored(const std::vector<std::vector<float>>& lists) {
  return std::all_of(lists.begin(), lists.end(), [](const auto& list) { return mirrored(list); });
}

// The taps that a sum of `count` mirrored ones needs: the middle one counts once.
std::vector<float> half_of(const std::vector<float>& full) {
  std::vector<float> half(full.begin(), full.begin() + static_cast<std::ptrdiff_t>((full.size() + 1) / 2));
  if (full.size() % 2 == 1) half.back() *= 0.5F;
  return half;
}

}  // namespace

SeparableEngine::SeparableEngine(const TapAxis& x, const TapAxis& y, Border border, double dc,
                                 std::vector<std::vector<float>> x_taps, std::vector<std::vector<float>> y_taps)
    : x_(x),
      y_(y),
      border_(border),
      dc_(dc),
      x_taps_(std::move(x_taps)),
      y_taps_(std::move(y_taps)),
      mirrored_x_(all_mirrored(x_taps_)),
      mirrored_y_(all_mirrored(y_taps_)) {
  if (mirrored_x_)
    for (auto& list : x_taps_) list = half_of(list);
  if (mirrored_y_)
    for (auto& list : y_taps_) list = half_of(list);
  const std::int64_t rows = kTileFloats / (kTileColumns * static_cast<std::int64_t>(x_taps_.size()));
  tile_rows_ = std::clamp<std::int64_t>((rows - y.count) / y.ratio, std::max<std::int64_t>(16, y.count / y.ratio), 256);
}

std::int64_t SeparableEngine::run_bytes(std::int64_t /*channels*/, int threads) const {
  const std::int64_t rows = (tile_rows_ - 1) * y_.ratio + y_.count;
  return std::int64_t{std::max(threads, 1)} * 4 *
         (rows * kTileColumns * static_cast<std::int64_t>(x_taps_.size()) + x_.ratio * phase_stride(x_) +
          scratch_size(x_));
}

std::int64_t SeparableEngine::filter_bytes() const {
  return static_cast<std::int64_t>(x_taps_.size()) * 4 * (x_.count + y_.count);
}

void SeparableEngine::run(const std::vector<Channel>& channels, int threads) const {
  for_each_tile(channels, x_, y_, tile_rows_, threads,
                [this](const Channel& channel, std::int64_t x0, std::int64_t y0) { tile(channel, x0, y0); });
}

void SeparableEngine::tile(const Channel& channel, std::int64_t x0, std::int64_t y0) const {
  const std::int64_t columns = std::min(kTileColumns, x_.outputs - x0), rows = std::min(tile_rows_, y_.outputs - y0);
  if (const auto level = flat_level(channel, x_, y_, border_, x0, y0, columns, rows)) {
    fill_tile(channel, x0, y0, columns, rows, static_cast<float>(dc_ * *level));
    return;
  }
  const std::int64_t n = whole_vectors(columns), needed = (rows - 1) * y_.ratio + y_.count;
  const std::int64_t stride = phase_stride(x_), rank = static_cast<std::int64_t>(x_taps_.size());
  const AlignedBuffer<float> scratch(static_cast<std::size_t>(scratch_size(x_)));
  const AlignedBuffer<float> samples(static_cast<std::size_t>(x_.ratio * stride));
  const AlignedBuffer<float> between(static_cast<std::size_t>(rank * needed * n)), sums(static_cast<std::size_t>(n));
  std::fill_n(samples.data(), samples.size(), 0.0F);

  const auto tap = [&](std::int64_t t) { return samples.data() + t % x_.ratio * stride + t / x_.ratio; };
  const std::int64_t x_terms = static_cast<std::int64_t>(x_taps_.front().size());
  std::vector<const float*> a, b;
  for (std::int64_t t = 0; t < x_terms; ++t) a.push_back(tap(t)), b.push_back(tap(x_.count - 1 - t));

  for (std::int64_t r = 0; r < needed; ++r) {
    load_row(channel, x_, y_, border_, y0 * y_.ratio + y_.first + r, x0, columns, scratch.data(), samples.data());
    for (std::int64_t k = 0; k < rank; ++k) {
      float* out = between.data() + (k * needed + r) * n;
      const float* taps = x_taps_[static_cast<std::size_t>(k)].data();
      if (mirrored_x_)
        weighted_pairs(a.data(), b.data(), taps, x_terms, n, out);
      else
        weighted_sum(a.data(), taps, x_terms, n, out);
    }
  }

  const auto y_terms = y_taps_.front().size();
  std::vector<float> weights;
  for (const auto& list : y_taps_) weights.insert(weights.end(), list.begin(), list.end());
  a.resize(weights.size());
  b.resize(weights.size());
  for (std::int64_t y = 0; y < rows; ++y) {
    std::size_t c = 0;
    for (std::int64_t k = 0; k < rank; ++k) {
      const float* base = between.data() + (k * needed + y * y_.ratio) * n;
      for (std::size_t t = 0; t < y_terms; ++t, ++c) {
        a[c] = base + static_cast<std::int64_t>(t) * n;
        b[c] = base + (y_.count - 1 - static_cast<std::int64_t>(t)) * n;
      }
    }
    if (mirrored_y_)
      weighted_pairs(a.data(), b.data(), weights.data(), static_cast<std::int64_t>(c), n, sums.data());
    else
      weighted_sum(a.data(), weights.data(), static_cast<std::int64_t>(c), n, sums.data());
    kernels::restore(sums.data(), columns, channel.out_mean, 1.0 / channel.scale, channel.out.row(y0 + y) + x0);
  }
}

DirectEngine::DirectEngine(const TapAxis& x, const TapAxis& y, Border border, double dc, std::vector<float> taps)
    : x_(x), y_(y), border_(border), dc_(dc), taps_(std::move(taps)), mirrored_(true) {
  for (std::int64_t r = 0; r < y.count; ++r)
    for (std::int64_t t = 0; t < x.count; ++t) {
      const auto at = [&](std::int64_t row, std::int64_t column) {
        return taps_[static_cast<std::size_t>(row * x.count + column)];
      };
      mirrored_ = mirrored_ && at(r, t) == at(r, x.count - 1 - t) && at(r, t) == at(y.count - 1 - r, t);
    }
}

std::int64_t DirectEngine::run_bytes(std::int64_t /*channels*/, int threads) const {
  const std::int64_t rows = (kDirectRows - 1) * y_.ratio + 2 * y_.count;
  return std::int64_t{std::max(threads, 1)} * 4 * (rows * x_.ratio * phase_stride(x_) + scratch_size(x_));
}

void DirectEngine::run(const std::vector<Channel>& channels, int threads) const {
  for_each_tile(channels, x_, y_, kDirectRows, threads,
                [this](const Channel& channel, std::int64_t x0, std::int64_t y0) { tile(channel, x0, y0); });
}

void DirectEngine::tile(const Channel& channel, std::int64_t x0, std::int64_t y0) const {
  const std::int64_t columns = std::min(kTileColumns, x_.outputs - x0), rows = std::min(kDirectRows, y_.outputs - y0);
  if (const auto level = flat_level(channel, x_, y_, border_, x0, y0, columns, rows)) {
    fill_tile(channel, x0, y0, columns, rows, static_cast<float>(dc_ * *level));
    return;
  }
  const std::int64_t n = whole_vectors(columns), needed = (rows - 1) * y_.ratio + y_.count;
  const std::int64_t stride = phase_stride(x_), length = x_.ratio * stride, half_rows = (y_.count + 1) / 2;
  const AlignedBuffer<float> scratch(static_cast<std::size_t>(scratch_size(x_))), sums(static_cast<std::size_t>(n));
  const AlignedBuffer<float> samples(static_cast<std::size_t>(needed * length));
  const AlignedBuffer<float> added(static_cast<std::size_t>(mirrored_ ? half_rows * length : 0));
  std::fill_n(samples.data(), samples.size(), 0.0F);
  for (std::int64_t r = 0; r < needed; ++r)
    load_row(channel, x_, y_, border_, y0 * y_.ratio + y_.first + r, x0, columns, scratch.data(),
             samples.data() + r * length);

  std::vector<const float*> a, b;
  std::vector<float> weights;
  for (std::int64_t y = 0; y < rows; ++y) {
    const float* base = samples.data() + y * y_.ratio * length;
    a.clear(), b.clear(), weights.clear();
    const auto take = [&](const float* row, std::int64_t t, float weight) {
      if (weight == 0.0F) return;
      const auto at = [&](std::int64_t i) { return row + i % x_.ratio * stride + i / x_.ratio; };
      a.push_back(at(t)), b.push_back(at(x_.count - 1 - t)), weights.push_back(weight);
    };
    if (mirrored_) {
      for (std::int64_t r = 0; r < half_rows; ++r) {
        const std::int64_t other = y_.count - 1 - r;
        float* row = added.data() + r * length;
        add_rows(base + r * length, base + other * length, length, row);
        for (std::int64_t t = 0; t < (x_.count + 1) / 2; ++t) {
          const float once = (r == other ? 0.5F : 1.0F) * (2 * t + 1 == x_.count ? 0.5F : 1.0F);
          take(row, t, once * taps_[static_cast<std::size_t>(r * x_.count + t)]);
        }
      }
      weighted_pairs(a.data(), b.data(), weights.data(), static_cast<std::int64_t>(a.size()), n, sums.data());
    } else {
      for (std::int64_t r = 0; r < y_.count; ++r)
        for (std::int64_t t = 0; t < x_.count; ++t)
          take(base + r * length, t, taps_[static_cast<std::size_t>(r * x_.count + t)]);
      weighted_sum(a.data(), weights.data(), static_cast<std::int64_t>(a.size()), n, sums.data());
    }
    kernels::restore(sums.data(), columns, channel.out_mean, 1.0 / channel.scale, channel.out.row(y0 + y) + x0);
  }
}

}  // namespace mtf
