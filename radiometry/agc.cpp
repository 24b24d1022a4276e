// SPDX-License-Identifier: Apache-2.0
#include "radiometry/agc.h"

#include <algorithm>
#include <cmath>

#include "mtf/parallel.h"

namespace radiometry {
namespace {

constexpr std::int64_t kRowsAtOnce = 16;

/// The value that a part of the sorted values lies below; reorders them.
double quantile(std::vector<float>& values, double part) {
  const auto at = static_cast<std::ptrdiff_t>(std::floor(part * static_cast<double>(values.size() - 1) + 0.5));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(at)]);
}

}  // namespace

float ToneCurve::at(float value) const {
  if (std::isnan(value)) return value;
  const auto intervals = static_cast<double>(level.size() - 1);
  const double place = (static_cast<double>(value) - low) / (high - low) * intervals;
  if (!(place > 0.0)) return level.front();
  if (place >= intervals) return level.back();
  const auto i = static_cast<std::size_t>(place);
  const auto t = static_cast<float>(place - static_cast<double>(i));
  return level[i] * (1.0F - t) + level[i + 1] * t;
}

ToneCurve tone_curve(mtf::ImageView<const float> frame, const AutomaticGain& gain) {
  require_valid("agc", gain);
  std::vector<float> values;
  for (std::int64_t y = 0; y < frame.height; ++y)
    for (std::int64_t x = 0; x < frame.width; ++x)
      if (std::isfinite(frame.at(x, y))) values.push_back(frame.at(x, y));
  if (values.empty()) throw mtf::UsageError("agc: a frame without a finite pixel; there is nothing to go by");
  ToneCurve curve{.low = quantile(values, gain.clip), .high = quantile(values, 1.0 - gain.clip), .level = {}};
  const auto most = static_cast<float>(gain.most_level);
  if (!(curve.high > curve.low)) {
    // One value, the clipped ends aside: what is below is dark, above bright.
    const double width = std::max(std::abs(curve.low), 1.0) * 1e-6;
    return {curve.low - width, curve.low + width, {0.0F, most}};
  }
  curve.level = {0.0F, most};
  if (gain.method == GainMethod::linear) return curve;

  const auto bins = static_cast<std::size_t>(gain.bins);
  std::vector<double> count(bins, 0.0);
  const double scale = static_cast<double>(bins) / (curve.high - curve.low);
  for (const float value : values) {
    const double place = (static_cast<double>(value) - curve.low) * scale;
    if (place >= 0.0 && place <= static_cast<double>(bins))
      ++count[std::min(static_cast<std::size_t>(place), bins - 1)];
  }
  // Ends below 1 pixel would leave no levels at all.
  const double cap = std::max(1.0, gain.plateau * static_cast<double>(values.size()));
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
  mtf::parallel_for(image.height, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      float* row = image.row(y);
      for (std::int64_t x = 0; x < image.width; ++x) row[x] = curve.at(row[x]);
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
