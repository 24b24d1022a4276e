// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/processing/agc.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "mtf/parallel.h"

namespace radiometry {
namespace {

constexpr std::int64_t kRowsAtOnce = 16;
constexpr std::int64_t kRankBins = 1 << 14;

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

Extent extent_of(mtf::ImageView<const float> frame, int threads) {
  const auto part = [&](std::int64_t begin, std::int64_t end) {
    Extent e;
    for (std::int64_t y = begin; y < end; ++y) {
      const float* row = frame.row(y);
      for (std::int64_t x = 0; x < frame.width; ++x) {
        const bool finite = std::abs(row[x]) <= std::numeric_limits<float>::max();
        e.count += finite ? 1 : 0;
        e.low = finite && row[x] < e.low ? row[x] : e.low;
        e.high = finite && row[x] > e.high ? row[x] : e.high;
      }
    }
    return e;
  };
  return over_rows(frame.height, threads, Extent{}, part, [](Extent& all, const Extent& one) {
    all.count += one.count;
    all.low = std::min(all.low, one.low);
    all.high = std::max(all.high, one.high);
  });
}

/// Bin of a value among `bins` between low and high, both included; values outside and NaN have none, -1.
struct Bins {
  double low, scale;
  std::int64_t bins;

  Bins(double from, double to, std::int64_t count)
      : low(from), scale(static_cast<double>(count) / (to - from)), bins(count) {}
  std::int64_t operator()(float value) const {
    const double place = (static_cast<double>(value) - low) * scale;
    if (!(place >= 0.0 && place <= static_cast<double>(bins))) return -1;
    return std::min(static_cast<std::int64_t>(place), bins - 1);
  }
};

Counts histogram(mtf::ImageView<const float> frame, const Bins& bin, int threads) {
  const Counts none(static_cast<std::size_t>(bin.bins), 0);
  const auto part = [&](std::int64_t begin, std::int64_t end) {
    Counts counts = none;
    for (std::int64_t y = begin; y < end; ++y)
      for (std::int64_t x = 0; x < frame.width; ++x)
        if (const std::int64_t i = bin(frame.at(x, y)); i >= 0) ++counts[static_cast<std::size_t>(i)];
    return counts;
  };
  return over_rows(frame.height, threads, none, part, [](Counts& all, const Counts& one) {
    for (std::size_t i = 0; i < all.size(); ++i) all[i] += one[i];
  });
}

/// The values at two ranks of the sorted pixels: a histogram says in which bins they are, and only those are sorted.
std::array<double, 2> values_at(mtf::ImageView<const float> frame, const Extent& extent,
                                const std::array<std::int64_t, 2>& ranks, int threads) {
  if (!(extent.high > extent.low)) return {static_cast<double>(extent.low), static_cast<double>(extent.low)};
  const Bins bin(static_cast<double>(extent.low), static_cast<double>(extent.high), kRankBins);
  const Counts counts = histogram(frame, bin, threads);
  std::array<std::int64_t, 2> rank = ranks, wanted{};
  std::array<float, 2> from{}, to{};
  for (std::size_t k = 0; k < 2; ++k) {
    while (rank[k] >= counts[static_cast<std::size_t>(wanted[k])])
      rank[k] -= counts[static_cast<std::size_t>(wanted[k]++)];
    // A comparison rejects nearly all pixels; `bin` decides those at the rounded edges.
    const auto edge = [&](double at) { return static_cast<float>(bin.low + at / bin.scale); };
    from[k] = edge(static_cast<double>(wanted[k]) - 0.01);
    to[k] = edge(static_cast<double>(wanted[k]) + 1.01);
  }
  using Values = std::array<std::vector<float>, 2>;
  const auto part = [&](std::int64_t begin, std::int64_t end) {
    Values values;
    for (std::int64_t y = begin; y < end; ++y) {
      const float* row = frame.row(y);
      for (std::int64_t x = 0; x < frame.width; ++x)
        for (std::size_t k = 0; k < 2; ++k)
          if (row[x] >= from[k] && row[x] <= to[k] && bin(row[x]) == wanted[k]) values[k].push_back(row[x]);
    }
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

/// The display level of a value that is not NaN; `scale`: intervals of the curve for one unit of value.
float on_curve(float value, double low, double scale, const std::vector<float>& level) {
  const auto intervals = static_cast<double>(level.size() - 1);
  const double place = (static_cast<double>(value) - low) * scale;
  if (!(place > 0.0)) return level.front();
  if (place >= intervals) return level.back();
  const auto i = static_cast<std::size_t>(place);
  const auto t = static_cast<float>(place - static_cast<double>(i));
  return level[i] * (1.0F - t) + level[i + 1] * t;
}

}  // namespace

float ToneCurve::at(float value) const {
  if (std::isnan(value)) return value;
  return on_curve(value, low, static_cast<double>(level.size() - 1) / (high - low), level);
}

ToneCurve tone_curve(mtf::ImageView<const float> frame, const AutomaticGain& gain, int threads) {
  require_valid("agc", gain);
  const Extent extent = extent_of(frame, threads);
  if (extent.count == 0) throw mtf::UsageError("agc: a frame without a finite pixel; give a frame with one");
  const auto rank = [&](double part) {
    return static_cast<std::int64_t>(std::floor(part * static_cast<double>(extent.count - 1) + 0.5));
  };
  const auto [low, high] = values_at(frame, extent, {rank(gain.clip), rank(1.0 - gain.clip)}, threads);
  ToneCurve curve{.low = low, .high = high, .level = {}};
  const auto most = static_cast<float>(gain.most_level);
  if (!(curve.high > curve.low)) {
    // The frame has one value but for the clipped ends: values below it are dark, those above it bright.
    const double width = std::max(std::abs(curve.low), 1.0) * 1e-6;
    return {curve.low - width, curve.low + width, {0.0F, most}};
  }
  curve.level = {0.0F, most};
  if (gain.method == GainMethod::linear) return curve;

  const Counts pixels = histogram(frame, Bins(curve.low, curve.high, gain.bins), threads);
  std::vector<double> count(pixels.begin(), pixels.end());
  // A cap below 1 pixel would leave no display levels at all.
  const double cap = std::max(1.0, gain.plateau * static_cast<double>(extent.count));
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
  if (curve.level.size() < 2 || !(curve.high > curve.low))
    throw mtf::UsageError("agc: a curve of " + std::to_string(curve.level.size()) + " levels from " +
                          mtf::format_double(curve.low) + " to " + mtf::format_double(curve.high) +
                          "; make it with tone_curve");
  const double scale = static_cast<double>(curve.level.size() - 1) / (curve.high - curve.low);
  mtf::parallel_for(image.height, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      float* row = image.row(y);
      for (std::int64_t x = 0; x < image.width; ++x)
        if (!std::isnan(row[x])) row[x] = on_curve(row[x], curve.low, scale, curve.level);
    }
  });
}

void invert_polarity(mtf::ImageView<float> image, double most_level) {
  const auto most = static_cast<float>(most_level);
  for (std::int64_t y = 0; y < image.height; ++y) {
    float* row = image.row(y);
    for (std::int64_t x = 0; x < image.width; ++x) row[x] = most - row[x];
  }
}

}  // namespace radiometry
