// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps/taps.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <numeric>

#include "mtf/engines/buffer_pool.h"
#include "mtf/engines/kernels.h"
#include "mtf/engines/uniform_runs.h"
#include "mtf/math/clones.h"
#include "mtf/math/simd.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

// Rows of scene samples that a tile of the output needs, weighted sums of rows, and the outputs that need not be
// computed. Outputs of a row come in groups of kVector. Where all samples that the taps read for a group have one
// value, the group is uniform: H(0) times that value.

constexpr std::int64_t kTileColumns = 320;  // at most
constexpr std::int64_t kVector = 16;        // floats; rows are computed in whole vectors

std::int64_t whole_vectors(std::int64_t n) { return (n + kVector - 1) / kVector * kVector; }

// Floats from one phase of a tile's row to the next: outputs, taps, and room to read whole vectors.
std::int64_t phase_stride(const TapAxis& x) {
  return whole_vectors(std::min(kTileColumns, x.outputs) + x.count / x.ratio + 1) + kVector;
}

// Outputs that are computed together.
struct TileArea {
  std::int64_t x0 = 0, y0 = 0, columns = 0, rows = 0;
};

// Floats of the scratch row of TileRows.
std::int64_t scratch_size(const TapAxis& x) {
  return std::min(kTileColumns, x.outputs) * x.ratio + x.count + x.ratio + kVector;
}

// The samples that a tile of outputs needs: canvas rows y.first + area.y0 x ratio + r, r = 0 ..
class TileRows {
 public:
  TileRows(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border, const TileArea& area);
  // Row r about the channel's mean and scaled, sample i at out[(i % ratio) * phase_stride + i / ratio].
  void load(std::int64_t r, float* scratch, float* out) const;

 private:
  const float* row(std::int64_t r) const;

  const Channel& channel_;
  const TapAxis &x_, &y_;
  Border border_;
  std::int64_t first_row_;             // of the canvas
  std::int64_t begin_, n_;             // samples of a row
  std::int64_t left_, right_;          // of them, left .. right - 1 lie in the image
  std::vector<std::int64_t> outside_;  // where the others come from, in order; -1: the value of a constant border
};

class TapsFlat {
 public:
  using Kind = UniformRuns::Kind;
  static_assert(UniformRuns::kGroup == kVector && kTileColumns % kVector == 0);

  TapsFlat(const Channel& channel, const TapAxis& x, const TapAxis& y, Border border);

  // The value of the samples of a kind other than 0.
  float value(Kind kind) const { return map_->value(kind); }
  // Kinds of the groups of a row of outputs from column x0 on; null where all groups have to be computed.
  const Kind* output(std::int64_t y, std::int64_t x0) const { return at(outputs_, y, x0); }
  // The same for the taps along x alone, on the samples of canvas row y.first + r.
  const Kind* samples(std::int64_t r, std::int64_t x0) const { return at(rows_, r, x0); }
  // Writes the uniform groups of outputs of row `y`.
  void fill_row(const Channel& channel, std::int64_t y) const;
  // The smallest part of a tile, in whole groups, that holds all other groups; it has no rows where there are none.
  TileArea rest(const TileArea& area) const;

  static std::int64_t bytes(const TapAxis& x, const TapAxis& y);

 private:
  const Kind* at(const std::vector<Kind>& kinds, std::int64_t y, std::int64_t x0) const {
    return kinds.empty() ? nullptr : kinds.data() + y * groups_ + x0 / kVector;
  }

  const UniformRuns* map_;
  std::int64_t groups_;
  std::vector<Kind> rows_, outputs_;
};

// Calls run(begin, end, kind) for the columns of each stretch of groups of one kind, in order, up to `columns`; all
// groups are of kind 0 where `kinds` is null.
template <class Run>
void for_stretches(const UniformRuns::Kind* kinds, std::int64_t columns, const Run& run) {
  if (kinds == nullptr) return run(std::int64_t{0}, columns, UniformRuns::Kind{0});
  const std::int64_t groups = (columns + kVector - 1) / kVector;
  for (std::int64_t g = 0, end = 0; g < groups; g = end) {
    for (end = g + 1; end < groups && kinds[end] == kinds[g];) ++end;
    run(g * kVector, std::min(end * kVector, columns), kinds[g]);
  }
}

using Wide = float __attribute__((vector_size(kVector * sizeof(float)), aligned(4), may_alias));

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
  bool border = false;  // whether it also reads the value of a constant border
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

// out[i] = sum over c of weights[c] x a[c][i], first <= i < last, whole vectors.
// Four vectors at a time, or two, hide the latency of the additions.
MTFKIT_CLONES void weighted_sum(const float* const* a, const float* weights, std::int64_t count, std::int64_t first,
                                std::int64_t last, float* out) {
  add_weighted(
      count, first, last, out, [=](std::int64_t c, std::int64_t i, Wide & sum) __attribute__((always_inline)) {
        sum += weights[c] * wide(a[c] + i);
      });
}

// out[i] = sum over c of weights[c] x (a[c][i] + b[c][i]).
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

// Writes all uniform groups, then calls tile(channel, flat, area) for all tiles of `rows` output rows of all channels,
// on `threads` threads.
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

constexpr std::int64_t kTileFloats = std::int64_t{96} << 10;  // of rows between the two passes: a share of the L2 cache

constexpr std::int64_t kDirectRows = 64;

// Taps that equal themselves backwards.
bool all_mirrored(const std::vector<std::vector<float>>& lists) {
  return std::ranges::all_of(lists,
                             [](const auto& list) { return std::equal(list.begin(), list.end(), list.rbegin()); });
}

// The taps that a sum of `count` mirrored ones needs: the middle one counts once.
std::vector<float> half_of(const std::vector<float>& full) {
  std::vector<float> half(full.begin(), full.begin() + static_cast<std::ptrdiff_t>((full.size() + 1) / 2));
  if (full.size() % 2 == 1) half.back() *= 0.5F;
  return half;
}

// Whether a row of `n` outputs has any that are not uniform.
bool is_busy(const UniformRuns::Kind* kinds, std::int64_t n) {
  return kinds == nullptr || std::find(kinds, kinds + n / kVector, 0) != kinds + n / kVector;
}

// Rows of samples and what each counts for; with `pairs` mirrored samples are added first.
struct WeightedRows {
  std::vector<const float*> a, b;
  void sum(bool pairs, const float* weights, std::int64_t terms, std::int64_t begin, std::int64_t end,
           float* out) const {
    if (pairs)
      weighted_pairs(a.data(), b.data(), weights, terms, begin, end, out);
    else
      weighted_sum(a.data(), weights, terms, begin, end, out);
  }
};

// Walks over the tiles of all channels.
class TapsEngine : public Engine {
 public:
  void run(const std::vector<Channel>& channels, int threads) const override {
    for_each_tile(channels, x_, y_, border_, tile_rows_, threads,
                  [this](const Channel& channel, const TapsFlat& flat, const TileArea& whole) {
                    if (const TileArea area = flat.rest(whole); area.rows > 0) tile(channel, flat, area);
                  });
  }

 protected:
  TapsEngine(const TapAxis& x, const TapAxis& y, Border border) : x_(x), y_(y), border_(border) {}
  virtual void tile(const Channel& channel, const TapsFlat& flat, const TileArea& area) const = 0;

  std::int64_t rows_read(std::int64_t rows) const { return (rows - 1) * y_.ratio + y_.count; }
  BufferPool::Loan<float> floats(std::int64_t count) const { return {pool_, static_cast<std::size_t>(count)}; }
  // What is not flat of a finished row of sums.
  static void write_row(const Channel& channel, const TileArea& area, std::int64_t y, const TapsFlat& flat,
                        const float* sums) {
    float* out = channel.out.row(area.y0 + y) + area.x0;
    for_stretches(flat.output(area.y0 + y, area.x0), area.columns,
                  [&](std::int64_t begin, std::int64_t end, auto kind) {
                    if (kind == 0)
                      kernels::restore(sums + begin, end - begin, channel.out_mean(), 1.0 / channel.scale, out + begin);
                  });
  }

  TapAxis x_, y_;
  Border border_;
  std::int64_t tile_rows_ = kDirectRows;

 private:
  mutable BufferPool pool_;
};

class SeparableEngine final : public TapsEngine {
 public:
  SeparableEngine(const TapAxis& x, const TapAxis& y, Border border, std::vector<std::vector<float>> x_taps,
                  std::vector<std::vector<float>> y_taps)
      : TapsEngine(x, y, border),
        x_taps_(std::move(x_taps)),
        y_taps_(std::move(y_taps)),
        mirrored_x_(all_mirrored(x_taps_)),
        mirrored_y_(all_mirrored(y_taps_)) {
    for (const auto& list : x_taps_) x_gains_.push_back(std::accumulate(list.begin(), list.end(), 0.0));
    if (mirrored_x_)
      for (auto& list : x_taps_) list = half_of(list);
    if (mirrored_y_)
      for (auto& list : y_taps_) list = half_of(list);
    const std::int64_t rows = kTileFloats / (kTileColumns * rank());
    tile_rows_ =
        std::clamp<std::int64_t>((rows - y.count) / y.ratio, std::max<std::int64_t>(16, y.count / y.ratio), 256);
  }

  std::int64_t run_bytes(std::int64_t channels, int threads) const override {
    return std::int64_t{std::max(threads, 1)} * 4 *
               (rows_read(tile_rows_) * kTileColumns * rank() + x_.ratio * phase_stride(x_) + scratch_size(x_)) +
           channels * TapsFlat::bytes(x_, y_);
  }
  std::int64_t filter_bytes() const override { return rank() * 4 * (x_.count + y_.count); }

 private:
  std::int64_t rank() const { return static_cast<std::int64_t>(x_taps_.size()); }

  void tile(const Channel& channel, const TapsFlat& flat, const TileArea& area) const override {
    const std::int64_t n = whole_vectors(area.columns), needed = rows_read(area.rows), stride = phase_stride(x_);
    const auto scratch = floats(scratch_size(x_)), samples = floats(x_.ratio * stride),
               between = floats(rank() * needed * n), sums = floats(n);
    std::fill_n(samples.data(), x_.ratio * stride, 0.0F);

    const auto tap = [&](std::int64_t t) { return samples.data() + t % x_.ratio * stride + t / x_.ratio; };
    const TileRows rows(channel, x_, y_, border_, area);
    const std::int64_t x_terms = static_cast<std::int64_t>(x_taps_.front().size());
    WeightedRows along_x, along_y;
    for (std::int64_t t = 0; t < x_terms; ++t) along_x.a.push_back(tap(t)), along_x.b.push_back(tap(x_.count - 1 - t));

    for (std::int64_t r = 0; r < needed; ++r) {
      const UniformRuns::Kind* kinds = flat.samples(area.y0 * y_.ratio + r, area.x0);
      if (is_busy(kinds, n)) rows.load(r, scratch.data(), samples.data());
      for (std::int64_t k = 0; k < rank(); ++k) {
        float* out = between.data() + (k * needed + r) * n;
        const float* taps = x_taps_[static_cast<std::size_t>(k)].data();
        for_stretches(kinds, n, [&](std::int64_t begin, std::int64_t end, auto kind) {
          if (kind == 0)
            along_x.sum(mirrored_x_, taps, x_terms, begin, end, out);
          else
            std::fill(out + begin, out + end,
                      static_cast<float>((flat.value(kind) - channel.mean) * channel.scale *
                                         x_gains_[static_cast<std::size_t>(k)]));
        });
      }
    }

    const auto y_terms = static_cast<std::int64_t>(y_taps_.front().size());
    std::vector<float> weights;
    for (const auto& list : y_taps_) weights.insert(weights.end(), list.begin(), list.end());
    for (std::int64_t y = 0; y < area.rows; ++y) {
      along_y.a.clear(), along_y.b.clear();
      for (std::int64_t k = 0; k < rank(); ++k) {
        const float* base = between.data() + (k * needed + y * y_.ratio) * n;
        for (std::int64_t t = 0; t < y_terms; ++t)
          along_y.a.push_back(base + t * n), along_y.b.push_back(base + (y_.count - 1 - t) * n);
      }
      for_stretches(flat.output(area.y0 + y, area.x0), n, [&](std::int64_t begin, std::int64_t end, auto kind) {
        if (kind == 0) along_y.sum(mirrored_y_, weights.data(), std::ssize(weights), begin, end, sums.data());
      });
      write_row(channel, area, y, flat, sums.data());
    }
  }

  std::vector<std::vector<float>> x_taps_, y_taps_;
  std::vector<double> x_gains_;  // sums of the x taps
  bool mirrored_x_, mirrored_y_;
};

class DirectEngine final : public TapsEngine {
 public:
  DirectEngine(const TapAxis& x, const TapAxis& y, Border border, std::vector<float> taps)
      : TapsEngine(x, y, border), taps_(std::move(taps)) {
    for (std::int64_t r = 0; r < y.count; ++r)
      for (std::int64_t t = 0; t < x.count; ++t)
        mirrored_ = mirrored_ && at(r, t) == at(r, x.count - 1 - t) && at(r, t) == at(y.count - 1 - r, t);
  }

  std::int64_t run_bytes(std::int64_t channels, int threads) const override {
    const std::int64_t rows = (kDirectRows - 1) * y_.ratio + 2 * y_.count;
    return std::int64_t{std::max(threads, 1)} * 4 * (rows * x_.ratio * phase_stride(x_) + scratch_size(x_)) +
           channels * TapsFlat::bytes(x_, y_);
  }
  std::int64_t filter_bytes() const override { return static_cast<std::int64_t>(taps_.size()) * 4; }

 private:
  float at(std::int64_t row, std::int64_t column) const {
    return taps_[static_cast<std::size_t>(row * x_.count + column)];
  }

  void tile(const Channel& channel, const TapsFlat& flat, const TileArea& area) const override {
    const std::int64_t n = whole_vectors(area.columns), needed = rows_read(area.rows), stride = phase_stride(x_),
                       length = x_.ratio * stride, half_rows = (y_.count + 1) / 2;
    const auto scratch = floats(scratch_size(x_)), sums = floats(kTileColumns),
               samples = floats(rows_read(kDirectRows) * length), added = floats(mirrored_ ? half_rows * length : 0);
    std::fill_n(samples.data(), needed * length, 0.0F);
    const TileRows rows(channel, x_, y_, border_, area);
    for (std::int64_t r = 0; r < needed; ++r) rows.load(r, scratch.data(), samples.data() + r * length);

    WeightedRows terms;
    std::vector<float> weights;
    for (std::int64_t y = 0; y < area.rows; ++y) {
      const UniformRuns::Kind* kinds = flat.output(area.y0 + y, area.x0);
      const bool busy = is_busy(kinds, n);
      const float* base = samples.data() + y * y_.ratio * length;
      terms.a.clear(), terms.b.clear(), weights.clear();
      const auto take = [&](const float* row, std::int64_t t, float weight) {
        if (weight == 0.0F) return;
        const auto place = [&](std::int64_t i) { return row + i % x_.ratio * stride + i / x_.ratio; };
        terms.a.push_back(place(t)), terms.b.push_back(place(x_.count - 1 - t)), weights.push_back(weight);
      };
      for (std::int64_t r = 0; busy && r < (mirrored_ ? half_rows : y_.count); ++r) {
        if (!mirrored_) {
          for (std::int64_t t = 0; t < x_.count; ++t) take(base + r * length, t, at(r, t));
          continue;
        }
        const std::int64_t other = y_.count - 1 - r;
        float* row = added.data() + r * length;
        add_rows(base + r * length, base + other * length, length, row);
        for (std::int64_t t = 0; t < (x_.count + 1) / 2; ++t) {
          const float once = (r == other ? 0.5F : 1.0F) * (2 * t + 1 == x_.count ? 0.5F : 1.0F);
          take(row, t, once * at(r, t));
        }
      }
      for_stretches(kinds, n, [&](std::int64_t begin, std::int64_t end, auto kind) {
        if (kind == 0) terms.sum(mirrored_, weights.data(), std::ssize(weights), begin, end, sums.data());
      });
      write_row(channel, area, y, flat, sums.data());
    }
  }

  std::vector<float> taps_;
  bool mirrored_ = true;  // along both axes
};

}  // namespace

std::shared_ptr<const Engine> make_separable_engine(const TapAxis& x, const TapAxis& y, Border border,
                                                    std::vector<std::vector<float>> x_taps,
                                                    std::vector<std::vector<float>> y_taps) {
  return std::make_shared<SeparableEngine>(x, y, border, std::move(x_taps), std::move(y_taps));
}

std::shared_ptr<const Engine> make_direct_engine(const TapAxis& x, const TapAxis& y, Border border,
                                                 std::vector<float> taps) {
  return std::make_shared<DirectEngine>(x, y, border, std::move(taps));
}

}  // namespace mtf
