// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/blinking_pixels.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/characterize/components.h"

namespace calib {
namespace {

constexpr double kNoisyWithin_sd = 3.5;  // of its variance: of pixels at the limit that few are not noisy
constexpr double kApart_sd = 4.0;        // of either level to the value that parts them

/// X: an excess in a single frame makes a pixel noisy, and levels are apart.
double least_excess(double frames, double white, double shot) {
  const double dof = frames - 1.0, above = dof * (f_quantile(1.0 - kNoisy_p, dof, 1e9) - 1.0);
  double shift = above;  // of chi-square
  for (int pass = 0; pass < 50; ++pass) shift = above + kNoisyWithin_sd * std::sqrt(2.0 * (dof + 2.0 * shift));
  double least = std::sqrt(white * shift * frames / dof);
  for (int pass = 0; pass < 50; ++pass)
    least = std::max(least, kApart_sd * (std::sqrt(white) + std::sqrt(white + shot * least)));
  return least;
}

struct Levels {
  double low = 0.0, high = 0.0, limit = 0.0, squares = 0.0, error = 0.0;
};

/// The two levels of a series; nothing where the noise about them is not that of two levels.
std::optional<Levels> levels_of(const std::vector<double>& values, double white, double shot) {
  const auto [least, most] = std::ranges::minmax(values);
  Levels l{.low = least, .high = most};
  for (int pass = 0; pass < 100; ++pass) {
    const double w = std::sqrt(white), s = std::sqrt(white + shot * (l.high - l.low));
    const double limit = (l.low * s + l.high * w) / (w + s);
    double low = 0.0, high = 0.0, n = 0.0;
    for (const double value : values)
      if (value > limit)
        high += value, n += 1.0;
      else
        low += value;
    const double rest = static_cast<double>(values.size()) - n;
    if (!(n > 0.0 && rest > 0.0)) return std::nullopt;
    const bool same = limit == l.limit;
    l = {.low = low / rest, .high = high / n, .limit = limit};
    if (same) break;
  }
  const double bright = white + shot * (l.high - l.low);
  double of_low = 0.0, of_high = 0.0;
  for (const double value : values) {
    const bool is_high = value > l.limit;
    const double left = value - (is_high ? l.high : l.low);
    l.squares += left * left / (is_high ? bright : white);
    (is_high ? of_high : of_low) += 1.0;
  }
  l.error = white / of_low + bright / of_high;
  const double dof = static_cast<double>(values.size()) - 2.0;
  if (l.squares > kAlikeNoise * dof * f_quantile(1.0 - kAlike_p, dof, 1e9)) return std::nullopt;
  return l;
}

/// The chance of a change from the mean number of changes in `steps`, of pixels that have one.
void find_change(double mean, double steps, double pixels, BlinkingNoise& found) {
  const auto chance = [&](double of_mean) {
    double low = 1e-12, high = 1.0 - 1e-12;
    for (int pass = 0; pass < 200; ++pass) {
      const double middle = 0.5 * (low + high);
      (steps * middle / seen_part(middle, steps) < of_mean ? low : high) = middle;
    }
    return 0.5 * (low + high);
  };
  const double p = chance(mean), seen = seen_part(p, steps), squares = (steps * p * (1.0 - p) + steps * steps * p * p);
  const double variance = squares / seen - mean * mean;
  found.change = {p, p * (1.0 - p) / std::sqrt(pixels * variance)};
  // Those beyond the first of each are nearly Poisson numbers, with a variance from a little above their mean down to
  // half of it, as of binomial numbers with the p of 1/2 of levels that are new in every frame. Above, as levels in
  // turn have it, half is too much, and the limits are wide.
  const double scale = std::max(0.5, variance / (mean - 1.0)), more = pixels * (mean - 1.0);
  const std::array<double, 2> limits = poisson_limits(more / scale);
  for (std::size_t k = 0; k < 2; ++k) found.change95[k] = chance(1.0 + limits[k] * scale / pixels);
}

}  // namespace

void PixelSeries::add(mtf::ImageView<const float> frame) {
  for (const std::int64_t place : places) values.push_back(frame.at(place % frame.width, place / frame.width));
  ++frames;
}

double seen_part(double change, double steps) { return -std::expm1(steps * std::log1p(-change)); }

double BlinkingNoise::share_variance(double n) const {
  const double r = 1.0 - 2.0 * change.value;  // correlation of successive frames
  const double sum = n * r / (1.0 - r) - r * (1.0 - std::pow(r, n)) / ((1.0 - r) * (1.0 - r));  // (n - k) r^k
  return 0.25 * (n + 2.0 * sum) / (n * n);
}

BlinkingNoise estimate_blinking(const PixelSeries& series, double white, double shot) {
  BlinkingNoise found{.frames = series.frames};
  const auto T = static_cast<double>(series.frames);
  found.least = least_excess(T, white, shot);
  std::vector<double> values(static_cast<std::size_t>(series.frames));
  double changes = 0.0;
  for (std::size_t i = 0; i < series.places.size(); ++i) {
    for (std::size_t t = 0; t < values.size(); ++t)
      values[t] = static_cast<double>(series.values[t * series.places.size() + i]);
    const std::optional<Levels> levels = levels_of(values, white, shot);
    if (!levels || !(levels->high - levels->low > found.least)) continue;
    BlinkingPixel pixel{.place = series.places[i], .excess = levels->high - levels->low};
    for (std::size_t t = 0; t < values.size(); ++t) {
      pixel.high += values[t] > levels->limit ? 1.0 / T : 0.0;
      if (t > 0) pixel.changes += (values[t] > levels->limit) != (values[t - 1] > levels->limit) ? 1.0 : 0.0;
    }
    changes += pixel.changes;
    found.scatter += levels->error;
    found.pixels.push_back(pixel);
  }
  const auto n = static_cast<double>(found.pixels.size());
  if (n == 0.0) return found;
  found.scatter = std::sqrt(found.scatter / n);
  if (!(changes > n)) return found;  // a single change each: they may be rare or of all times
  find_change(changes / n, T - 1.0, n, found);
  found.seen = seen_part(found.change.value, T - 1.0);
  return found;
}

}  // namespace calib
