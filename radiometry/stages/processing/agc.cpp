// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/processing/agc.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "mtf/math/clones.h"
#include "mtf/parallel.h"

namespace radiometry {
namespace {

constexpr std::int64_t kRowsAtOnce = 16;
constexpr std::int64_t kRankBins = 1 << 14;
constexpr std::int64_t kPiece = 128;  // pixels of a loop without branches

using Counts = std::vector<std::int64_t>;

/// Number and extremes of the finite pixels.
struct Extent {
  std::int64_t count = 0;
  float low = std::numeric_limits<float>::infinity(), high = -std::numeric_limits<float>::infinity();
};

/// Merges what `part(rows)` says of blocks of rows; sums of whole numbers and extremes know no order.
template <class Result, class Part, class Merge>
Result over_rows(std::int64_t height, int threads, Result result, const Part& part, const Merge& merge) {
  std::mutex lock;
  // As few blocks as there are threads: each has a result of its own to make and to merge.
  const std::int64_t blocks = mtf::threads_of(threads);
  mtf::parallel_for(height, std::max(kRowsAtOnce, (height + blocks - 1) / blocks), threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      const Result one = part(begin, end);
                      const std::scoped_lock guard(lock);
                      merge(result, one);
                    });
  return result;
}

/// Lanes of their own, as the compiler does not reorder comparisons.
MTFKIT_CLONES void take(const float* value, std::int64_t count, Extent& extent) {
  constexpr std::int64_t kLanes = 16;
  alignas(64) float low[kLanes], high[kLanes];
  alignas(64) std::int32_t finite[kLanes];
  std::fill(low, low + kLanes, extent.low);
  std::fill(high, high + kLanes, extent.high);
  std::fill(finite, finite + kLanes, 0);
  const auto add = [&](float v, std::int64_t lane) {
    const bool good = std::abs(v) <= std::numeric_limits<float>::max();
    finite[lane] += good ? 1 : 0;
    low[lane] = good && v < low[lane] ? v : low[lane];
    high[lane] = good && v > high[lane] ? v : high[lane];
  };
  const std::int64_t whole = count / kLanes * kLanes;
  for (std::int64_t x = 0; x < whole; x += kLanes)
    for (std::int64_t lane = 0; lane < kLanes; ++lane) add(value[x + lane], lane);
  for (std::int64_t x = whole; x < count; ++x) add(value[x], 0);
  extent.low = *std::min_element(low, low + kLanes), extent.high = *std::max_element(high, high + kLanes);
  for (const std::int32_t one : finite) extent.count += one;
}

Extent extent_of(mtf::ImageView<const float> frame, int threads) {
  const auto part = [&](std::int64_t begin, std::int64_t end) {
    Extent e;
    for (std::int64_t y = begin; y < end; ++y) take(frame.row(y), frame.width, e);
    return e;
  };
  return over_rows(frame.height, threads, Extent{}, part, [](Extent& all, const Extent& one) {
    all.count += one.count;
    all.low = std::min(all.low, one.low);
    all.high = std::max(all.high, one.high);
  });
}

/// Bin of a value among `bins` between two ends, both included; values outside and NaN have none.
struct Bins {
  double low, scale;
  std::int64_t bins;
};

Bins bins_between(double low, double high, std::int64_t bins) {
  return {low, static_cast<double>(bins) / (high - low), bins};
}

/// The bins of `count` values; `bin.bins` where they have none.
MTFKIT_CLONES void bins_of(const Bins& bin, const float* value, std::int64_t count, std::int32_t* out) {
  const double low = bin.low, scale = bin.scale, most = static_cast<double>(bin.bins);
  const auto last = static_cast<std::int32_t>(bin.bins - 1);
  for (std::int64_t i = 0; i < count; ++i) {
    const double place = (static_cast<double>(value[i]) - low) * scale;
    const bool inside = place >= 0.0 && place <= most;
    const auto number = static_cast<std::int32_t>(inside ? place : 0.0);
    out[i] = !inside ? last + 1 : number < last ? number : last;
  }
}

/// Whether some of `count` values lie from `from` to `to`.
MTFKIT_CLONES bool any_between(const float* value, std::int64_t count, float from, float to) {
  int any = 0;
  for (std::int64_t i = 0; i < count; ++i) any |= static_cast<int>(value[i] >= from) & static_cast<int>(value[i] <= to);
  return any != 0;
}

/// Calls work(values, count) with pieces of a row.
template <class Value, class Work>
void each_piece(Value* row, std::int64_t width, const Work& work) {
  for (std::int64_t x = 0; x < width; x += kPiece) work(row + x, std::min(kPiece, width - x));
}

Counts histogram(mtf::ImageView<const float> frame, const Bins& bin, int threads) {
  const Counts none(static_cast<std::size_t>(bin.bins) + 1, 0);
  const auto part = [&](std::int64_t begin, std::int64_t end) {
    Counts counts = none;
    std::array<std::int32_t, kPiece> number;
    for (std::int64_t y = begin; y < end; ++y)
      each_piece(frame.row(y), frame.width, [&](const float* value, std::int64_t count) {
        bins_of(bin, value, count, number.data());
        for (std::int64_t i = 0; i < count; ++i)
          ++counts[static_cast<std::size_t>(number[static_cast<std::size_t>(i)])];
      });
    return counts;
  };
  Counts all = over_rows(frame.height, threads, none, part, [](Counts& sum, const Counts& one) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one[i];
  });
  all.pop_back();  // values without a bin
  return all;
}

/// The values at two ranks of the sorted pixels: a histogram says in which bins they are, and only those are sorted.
std::array<double, 2> values_at(mtf::ImageView<const float> frame, const Extent& extent,
                                const std::array<std::int64_t, 2>& ranks, int threads) {
  if (!(extent.high > extent.low)) return {static_cast<double>(extent.low), static_cast<double>(extent.low)};
  const Bins bin = bins_between(static_cast<double>(extent.low), static_cast<double>(extent.high), kRankBins);
  const Counts counts = histogram(frame, bin, threads);
  std::array<std::int64_t, 2> rank = ranks, wanted{};
  std::array<float, 2> from{}, to{};
  for (std::size_t k = 0; k < 2; ++k) {
    while (rank[k] >= counts[static_cast<std::size_t>(wanted[k])])
      rank[k] -= counts[static_cast<std::size_t>(wanted[k]++)];
    // A comparison rejects nearly all pieces; bins_of decides the others.
    const auto edge = [&](double at) { return static_cast<float>(bin.low + at / bin.scale); };
    from[k] = edge(static_cast<double>(wanted[k]) - 0.01);
    to[k] = edge(static_cast<double>(wanted[k]) + 1.01);
  }
  using Values = std::array<std::vector<float>, 2>;
  const auto part = [&](std::int64_t begin, std::int64_t end) {
    Values values;
    std::array<std::int32_t, kPiece> number;
    for (std::int64_t y = begin; y < end; ++y)
      each_piece(frame.row(y), frame.width, [&](const float* value, std::int64_t count) {
        for (std::size_t k = 0; k < 2; ++k) {
          if (!any_between(value, count, from[k], to[k])) continue;
          bins_of(bin, value, count, number.data());
          for (std::int64_t i = 0; i < count; ++i)
            if (number[static_cast<std::size_t>(i)] == wanted[k]) values[k].push_back(value[i]);
        }
      });
    return values;
  };
  Values values = over_rows(frame.height, threads, Values{}, part, [](Values& all, const Values& one) {
    for (std::size_t k = 0; k < 2; ++k) all[k].insert(all[k].end(), one[k].begin(), one[k].end());
  });
  std::array<double, 2> found{};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto at = values[k].begin() + rank[k];
    std::nth_element(values[k].begin(), at, values[k].end());
    found[k] = static_cast<double>(*at);
  }
  return found;
}

/// Where values are on a curve: the interval, and the share of it that is below them. `scale`: intervals of the curve
/// for one unit of value.
MTFKIT_CLONES void places_on(const float* value, std::int64_t count, double low, double scale, std::int32_t intervals,
                             std::int32_t* interval, float* share) {
  const auto most = static_cast<double>(intervals);
  for (std::int64_t i = 0; i < count; ++i) {
    const double place = (static_cast<double>(value[i]) - low) * scale;
    const double inside = !(place > 0.0) ? 0.0 : place < most ? place : most;
    const auto number = static_cast<std::int32_t>(inside);
    interval[i] = number < intervals ? number : intervals - 1;
    share[i] = static_cast<float>(inside - static_cast<double>(interval[i]));
  }
}

void require_curve(const ToneCurve& curve) {
  if (curve.level.size() < 2 || !(curve.high > curve.low))
    throw mtf::UsageError("agc: a curve of " + std::to_string(curve.level.size()) + " levels from " +
                          mtf::format_double(curve.low) + " to " + mtf::format_double(curve.high) +
                          "; make it with tone_curve");
}

/// Puts display levels in the place of values; a NaN stays one.
void on_curve(float* value, std::int64_t count, const ToneCurve& curve) {
  const std::size_t intervals = curve.level.size() - 1;
  const double scale = curve.scale();
  std::array<std::int32_t, kPiece> interval;
  std::array<float, kPiece> share;
  each_piece(value, count, [&](float* piece, std::int64_t here) {
    places_on(piece, here, curve.low, scale, static_cast<std::int32_t>(intervals), interval.data(), share.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(here); ++i) {
      const float* const level = curve.level.data() + interval[i];
      if (!std::isnan(piece[i])) piece[i] = level[0] * (1.0F - share[i]) + level[1] * share[i];
    }
  });
}

}  // namespace

float ToneCurve::at(float value) const {
  require_curve(*this);
  on_curve(&value, 1, *this);
  return value;
}

ToneCurve tone_curve(mtf::ImageView<const float> frame, const AutomaticGain& gain, int threads) {
  const Extent extent = extent_of(frame, threads);
  return tone_curve({.finite = extent.count,
                     .values_at = [&](const auto& ranks) { return values_at(frame, extent, ranks, threads); },
                     .histogram =
                         [&](double low, double scale, std::int64_t bins) {
                           return histogram(frame, {low, scale, bins}, threads);
                         }},
                    gain);
}

ToneCurve tone_curve(const FramePixels& pixels, const AutomaticGain& gain) {
  require_valid("agc", gain);
  if (pixels.finite == 0) throw mtf::UsageError("agc: a frame without a finite pixel; give a frame with one");
  const auto rank = [&](double part) {
    return static_cast<std::int64_t>(std::floor(part * static_cast<double>(pixels.finite - 1) + 0.5));
  };
  const auto [low, high] = pixels.values_at({rank(gain.clip), rank(1.0 - gain.clip)});
  ToneCurve curve{.low = low, .high = high};
  const auto most = static_cast<float>(gain.most_level);
  if (!(curve.high > curve.low)) {
    // The frame has one value but for the clipped ends: values below it are dark, those above it bright.
    const double width = std::max(std::abs(curve.low), 1.0) * 1e-6;
    return {curve.low - width, curve.low + width, {0.0F, most}};
  }
  curve.level = {0.0F, most};
  if (gain.method == GainMethod::linear) return curve;

  const Bins bin = bins_between(curve.low, curve.high, gain.bins);
  const Counts counts = pixels.histogram(bin.low, bin.scale, bin.bins);
  std::vector<double> count(counts.begin(), counts.end());
  // A cap below 1 pixel would leave no display levels at all.
  const double cap = std::max(1.0, gain.plateau * static_cast<double>(pixels.finite));
  double total = 0.0;
  for (double& c : count) total += c = std::min(c, cap);
  curve.level.assign(1, 0.0F);
  double sum = 0.0;
  for (const double c : count) {
    sum += c;
    curve.level.push_back(static_cast<float>(gain.most_level * (sum / total)));
  }
  return curve;
}

void apply(mtf::ImageView<float> image, const ToneCurve& curve, int threads) {
  require_curve(curve);
  mtf::parallel_for_each(image.height, kRowsAtOnce, threads,
                         [&](std::int64_t y) { on_curve(image.row(y), image.width, curve); });
}

void invert_polarity(mtf::ImageView<float> image, double most_level) {
  const auto most = static_cast<float>(most_level);
  for (std::int64_t y = 0; y < image.height; ++y) {
    float* row = image.row(y);
    for (std::int64_t x = 0; x < image.width; ++x) row[x] = most - row[x];
  }
}

}  // namespace radiometry
