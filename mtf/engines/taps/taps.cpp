// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/taps/taps.h"

#include <algorithm>
#include <numeric>

#include "mtf/engines/buffer_pool.h"
#include "mtf/engines/kernels.h"
#include "mtf/engines/taps/taps_tiles.h"

namespace mtf {
namespace {

using namespace taps;  // NOLINT: the parts of these engines

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
