// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps/taps_tiles.h"

#include <cstring>

#include "mtf/engines/kernels.h"
#include "mtf/math/clones.h"
#include "mtf/parallel.h"

namespace mtf::taps {
namespace {

using Wide = float __attribute__((vector_size(kVector * sizeof(float)), aligned(4), may_alias));

#define MTFKIT_INLINE inline __attribute__((always_inline))

MTFKIT_INLINE const Wide& wide(const float* p) { return *reinterpret_cast<const Wide*>(p); }
MTFKIT_INLINE Wide& wide(float* p) { return *reinterpret_cast<Wide*>(p); }

// Sums of vectors, four at once where there are so many: `add(c, i, sum)` adds what row c has from i on.
template <class Add>
MTFKIT_INLINE void add_weighted(std::int64_t count, std::int64_t first, std::int64_t last, float* out, const Add& add) {
  const auto sums = [&]<int N>(std::int64_t i) __attribute__((always_inline)) {
    Wide sum[N]{};
    for (std::int64_t c = 0; c < count; ++c)
#pragma GCC unroll 4
      for (int k = 0; k < N; ++k) add(c, i + k * kVector, sum[k]);
#pragma GCC unroll 4
    for (int k = 0; k < N; ++k) wide(out + i + k * kVector) = sum[k];
  };
  std::int64_t i = first;
  for (; i + 4 * kVector <= last; i += 4 * kVector) sums.template operator()<4>(i);
  for (; i + 2 * kVector <= last; i += 2 * kVector) sums.template operator()<2>(i);
  for (; i < last; i += kVector) sums.template operator()<1>(i);
}

MTFKIT_CLONES void deinterleave(const float* __restrict in, std::int64_t ratio, std::int64_t stride, std::int64_t n,
                                float* __restrict out) {
  if (ratio == 2) {
    for (std::int64_t i = 0; i < n; ++i) out[i] = in[2 * i], out[stride + i] = in[2 * i + 1];
    return;
  }
  if (ratio == 4) {
    for (std::int64_t i = 0; i < n; ++i) {
      out[i] = in[4 * i], out[stride + i] = in[4 * i + 1];
      out[2 * stride + i] = in[4 * i + 2], out[3 * stride + i] = in[4 * i + 3];
    }
    return;
  }
  for (std::int64_t p = 0; p < ratio; ++p)
    for (std::int64_t i = 0; i < n; ++i) out[p * stride + i] = in[i * ratio + p];
}

using Kind = UniformRuns::Kind;

// Groups of samples that a group of outputs reads.
struct Support {
  struct Range {
    std::int64_t first, last;
  };
  std::vector<Range> ranges;
  bool border = false;  ///< whether it also reads the value of a constant border
};

Support support_of(const TapAxis& x, Border border, std::int64_t group) {
  const std::int64_t n = x.samples, outputs = std::min(group * kVector + kVector, x.outputs) - 1;
  const std::int64_t first = group * kVector * x.ratio + x.first, last = outputs * x.ratio + x.first + x.count - 1;
  const std::int64_t left = std::max<std::int64_t>(0, -first), right = std::max<std::int64_t>(0, last - n + 1);
  Support support;
  const auto add = [&](std::int64_t from, std::int64_t to) {
    if (from <= to) support.ranges.push_back({from / kVector, to / kVector});
  };
  support.border = border == Border::constant && left + right > 0;
  if (std::max(left, right) > n) {
    add(0, n - 1);
    return support;
  }
  add(std::max<std::int64_t>(first, 0), std::min(last, n - 1));
  if (border == Border::reflect) add(0, left - 1), add(n - right, n - 1);
  if (border == Border::periodic) add(n - left, n - 1), add(0, right - 1);
  if (border == Border::replicate && left > 0) add(0, 0);
  if (border == Border::replicate && right > 0) add(n - 1, n - 1);
  return support;
}

Kind kind_within(const Kind* row, const Support& support, Kind border_kind) {
  const Kind kind = row[support.ranges.front().first];
  if (support.border && border_kind != kind) return 0;
  for (const Support::Range& range : support.ranges)
    for (std::int64_t i = range.first; i <= range.last; ++i)
      if (row[i] != kind) return 0;
  return kind;
}

// The next row down: `alike` counts for how many rows each group has kept its kind, and `out` is that kind where it has
// kept it for `count` rows, else 0.
MTFKIT_CLONES void add_row(const Kind* __restrict row, const Kind* __restrict above, std::int64_t groups,
                           std::int32_t count, std::int32_t* __restrict alike, Kind* __restrict out) {
  for (std::int64_t g = 0; g < groups; ++g) {
    alike[g] = row[g] == above[g] ? alike[g] + 1 : 1;
    out[g] = alike[g] >= count ? row[g] : Kind{0};
  }
}

}  // namespace

// Four vectors at a time, or two, hide the latency of the additions.
MTFKIT_CLONES void weighted_sum(const float* const* a, const float* weights, std::int64_t count, std::int64_t first,
                                std::int64_t last, float* out) {
  add_weighted(
      count, first, last, out, [=](std::int64_t c, std::int64_t i, Wide & sum) __attribute__((always_inline)) {
        sum += weights[c] * wide(a[c] + i);
      });
}

MTFKIT_CLONES void weighted_pairs(const float* const* a, const float* const* b, const float* weights,
                                  std::int64_t count, std::int64_t first, std::int64_t last, float* out) {
  add_weighted(
      count, first, last, out, [=](std::int64_t c, std::int64_t i, Wide & sum) __attribute__((always_inline)) {
        sum += weights[c] * (wide(a[c] + i) + wide(b[c] + i));
      });
}

MTFKIT_CLONES void add_rows(const float* a, const float* b, std::int64_t n, float* out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = a[i] + b[i];
}

TileRows::TileRows(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border, const TileArea& area)
    : channel_(channel),
      x_(x),
      y_(y),
      border_(border),
      first_row_(y.first + area.y0 * y.ratio),
      begin_(x.first + area.x0 * x.ratio),
      n_((area.columns - 1) * x.ratio + x.count),
      left_(std::clamp<std::int64_t>(-begin_, 0, n_)),
      right_(std::clamp<std::int64_t>(x.samples - begin_, left_, n_)) {
  for (std::int64_t i = 0; i < n_; ++i)
    if (i < left_ || i >= right_) outside_.push_back(border_source(border, begin_ + i, x.samples));
}

const float* TileRows::row(std::int64_t r) const {
  const std::int64_t source = border_source(border_, first_row_ + r, y_.samples);
  return source < 0 ? nullptr : channel_.in.row(source);
}

void TileRows::load(std::int64_t r, float* scratch, float* out) const {
  const float* samples = row(r);
  const std::int64_t inside = right_ - left_;
  if (const float* soon = row(r + 2); soon != nullptr) kernels::prefetch(soon + begin_ + left_, inside);
  float* centred = x_.ratio == 1 ? out : scratch;
  const auto value = [&](double v) { return static_cast<float>((v - channel_.mean) * channel_.scale); };
  if (samples == nullptr) {
    std::fill_n(centred, n_, value(channel_.border_value));
  } else {
    kernels::center(samples + begin_ + left_, inside, channel_.mean, channel_.scale, centred + left_);
    for (std::size_t k = 0; k < outside_.size(); ++k) {
      const auto i = static_cast<std::int64_t>(k);
      centred[i < left_ ? i : i + inside] = value(outside_[k] < 0 ? channel_.border_value : samples[outside_[k]]);
    }
  }
  if (x_.ratio == 1) return;
  const std::int64_t phases = (n_ + x_.ratio - 1) / x_.ratio;
  std::fill(scratch + n_, scratch + phases * x_.ratio, 0.0F);
  deinterleave(scratch, x_.ratio, phase_stride(x_), phases, out);
}

TapsFlat::TapsFlat(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border)
    : map_(channel.flat), groups_((x.outputs + kVector - 1) / kVector) {
  if (map_ == nullptr || !map_->any()) return;
  const Kind border_kind = map_->kind_of(static_cast<float>(channel.border_value));
  std::vector<Support> supports;
  for (std::int64_t g = 0; g < groups_; ++g) supports.push_back(support_of(x, border, g));

  const std::int64_t needed = (y.outputs - 1) * y.ratio + y.count;
  const auto groups = static_cast<std::size_t>(groups_), samples = static_cast<std::size_t>(map_->groups());
  rows_.resize(static_cast<std::size_t>(needed) * groups);
  outputs_.resize(static_cast<std::size_t>(y.outputs) * groups);
  std::vector<std::int32_t> alike(groups, 0);
  std::vector<Kind> made(groups);
  const Kind* before = nullptr;  // many rows equal the one above
  std::int64_t alike_rows = 0;   // so far; nothing changes once the taps read no other rows
  for (std::int64_t r = 0; r < needed; ++r) {
    Kind* row = rows_.data() + static_cast<std::size_t>(r) * groups;
    const std::int64_t source = border_source(border, y.first + r, y.samples);
    const Kind* kinds = source < 0 ? nullptr : map_->row(source);
    ++alike_rows;
    if (kinds != nullptr && before != nullptr && std::memcmp(kinds, before, samples) == 0) {
      std::memcpy(row, row - groups, groups);
    } else {
      alike_rows = 0;
      for (std::size_t g = 0; g < groups; ++g)
        row[g] = kinds == nullptr ? border_kind : kind_within(kinds, supports[g], border_kind);
    }
    before = kinds;
    if (alike_rows <= y.count)
      add_row(row, r == 0 ? row : row - groups, groups_, static_cast<std::int32_t>(y.count), alike.data(), made.data());
    if (r >= y.count - 1 && (r - y.count + 1) % y.ratio == 0)
      std::memcpy(outputs_.data() + static_cast<std::size_t>((r - y.count + 1) / y.ratio) * groups, made.data(),
                  groups);
  }
}

void TapsFlat::fill_row(const Channel& channel, std::int64_t y) const {
  if (outputs_.empty()) return;
  for_stretches(output(y, 0), channel.out.width, [&](std::int64_t begin, std::int64_t end, Kind kind) {
    if (kind != 0)
      std::fill(channel.out.row(y) + begin, channel.out.row(y) + end, static_cast<float>(channel.dc * value(kind)));
  });
}

TileArea TapsFlat::rest(const TileArea& area) const {
  if (outputs_.empty()) return area;
  const std::int64_t groups = (area.columns + kVector - 1) / kVector;
  std::int64_t left = area.columns, right = 0, top = area.rows, bottom = 0;
  for (std::int64_t y = 0; y < area.rows; ++y) {
    const Kind *kinds = output(area.y0 + y, area.x0), *end = kinds + groups;
    const Kind* first = std::find(kinds, end, 0);
    if (first == end) continue;
    const Kind* last = end;
    while (*(last - 1) != 0) --last;
    left = std::min(left, (first - kinds) * kVector);
    right = std::max(right, std::min((last - kinds) * kVector, area.columns));
    top = std::min(top, y), bottom = y + 1;
  }
  if (bottom == 0) return {area.x0, area.y0, 0, 0};
  return {area.x0 + left, area.y0 + top, right - left, bottom - top};
}

std::int64_t TapsFlat::bytes(const TapAxis& x, const TapAxis& y) {
  const std::int64_t groups = (x.outputs + kVector - 1) / kVector;
  return groups * (y.outputs * (y.ratio + 1) + y.count);
}

void for_each_tile(const std::vector<Channel>& channels, const TapAxis& x, const TapAxis& y, Border border,
                   std::int64_t rows, int threads,
                   const std::function<void(const Channel&, const TapsFlat&, const TileArea&)>& tile) {
  std::vector<TapsFlat> flat;
  struct Task {
    std::size_t channel;
    TileArea area;
  };
  std::vector<Task> tasks;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    flat.emplace_back(channels[c], x, y, border);
    parallel_for_each(y.outputs, 64, threads, [&](std::int64_t j) { flat.back().fill_row(channels[c], j); });
    // Tiles of about the same width: a narrow tile costs as much as a wider one.
    const TileArea work = flat.back().rest({0, 0, x.outputs, y.outputs});
    const std::int64_t across = (work.columns + kTileColumns - 1) / kTileColumns;
    const std::int64_t width = across > 0 ? whole_vectors((work.columns + across - 1) / across) : kTileColumns;
    for (std::int64_t y0 = 0; y0 < work.rows; y0 += rows)
      for (std::int64_t x0 = 0; x0 < work.columns; x0 += width)
        tasks.push_back(
            {c, {work.x0 + x0, work.y0 + y0, std::min(width, work.columns - x0), std::min(rows, work.rows - y0)}});
  }
  parallel_for_each(std::ssize(tasks), 1, threads, [&](std::int64_t i) {
    const Task& task = tasks[static_cast<std::size_t>(i)];
    tile(channels[task.channel], flat[task.channel], task.area);
  });
}

}  // namespace mtf::taps
