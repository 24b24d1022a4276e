// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/processing/correction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/units.h"

namespace radiometry {
namespace {

using mtf::UsageError;

constexpr std::int64_t kReach = 8, kRowsAtOnce = 64;

std::string size_of(mtf::ImageView<const float> image) { return radiometry::size_of(image.width, image.height); }

struct Mean {
  double sum = 0.0;
  std::int64_t count = 0;

  void add(float value) {
    sum += static_cast<double>(value);
    ++count;
  }
  double value() const { return sum / static_cast<double>(count); }
};

mtf::Image mean_flat(std::int64_t width, std::int64_t height, double fill, int frames, std::uint32_t first,
                     const FlatFrame& flat) {
  mtf::Image image(width, height);
  std::vector<double> sum(static_cast<std::size_t>(image.size()), 0.0);
  for (int n = 0; n < frames; ++n) {
    flat(fill, first - static_cast<std::uint32_t>(n), image.view());
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(image.data()[i]);
  }
  for (std::size_t i = 0; i < sum.size(); ++i) image.data()[i] = static_cast<float>(sum[i] / frames);
  return image;
}

/// "low = 0.2 of the full well", "cold = 283 K"
std::string signal_of(const CorrectionSettings& settings, double fill) {
  const bool low = fill == settings.low;
  if (settings.cold_k && settings.hot_k)
    return (low ? "cold = " : "hot = ") + mtf::format_double(low ? *settings.cold_k : *settings.hot_k) + " K";
  return (low ? "low = " : "high = ") + mtf::format_double(fill) + " of the full well";
}

}  // namespace

TwoPoint two_point_correction(mtf::ImageView<const float> cold, mtf::ImageView<const float> hot, double limit) {
  if (cold.width != hot.width || cold.height != hot.height || cold.width < 1 || cold.height < 1)
    throw UsageError("two-point correction: flat frames of " + size_of(cold) + " and " + size_of(hot) +
                     " pixels; give both one size");
  if (!(limit > 0.0 && limit <= 1.0))
    throw UsageError("two-point correction: a limit of " + mtf::format_double(limit) + "; it has to be above 0 to 1");
  const auto response = [&](std::int64_t x, std::int64_t y) {
    return static_cast<double>(hot.at(x, y)) - static_cast<double>(cold.at(x, y));
  };
  std::vector<double> responses;
  for (std::int64_t y = 0; y < cold.height; ++y)
    for (std::int64_t x = 0; x < cold.width; ++x)
      if (std::isfinite(response(x, y))) responses.push_back(response(x, y));
  const auto middle = responses.begin() + static_cast<std::ptrdiff_t>(responses.size() / 2);
  if (!responses.empty()) std::nth_element(responses.begin(), middle, responses.end());
  if (responses.empty() || !(*middle > 0.0))
    throw UsageError(
        "two-point correction: the hot frame is not brighter than the cold one; exchange them, or take "
        "frames of two different signals");
  const double median = *middle;
  const auto is_good = [&](std::int64_t x, std::int64_t y) {
    return std::abs(response(x, y) - median) <= limit * median;
  };

  Mean mean_cold, mean_hot;
  for (std::int64_t y = 0; y < cold.height; ++y)
    for (std::int64_t x = 0; x < cold.width; ++x)
      if (is_good(x, y)) {
        mean_cold.add(cold.at(x, y));
        mean_hot.add(hot.at(x, y));
      }
  TwoPoint correction{mtf::Image(cold.width, cold.height), mtf::Image(cold.width, cold.height), {}};
  for (std::int64_t y = 0; y < cold.height; ++y)
    for (std::int64_t x = 0; x < cold.width; ++x) {
      // A response of 0 is within a limit of 1, but has no gain.
      const bool good = is_good(x, y) && response(x, y) > 0.0;
      const double gain = good ? (mean_hot.value() - mean_cold.value()) / response(x, y) : 1.0;
      const double offset = good ? mean_cold.value() - gain * static_cast<double>(cold.at(x, y)) : 0.0;
      correction.gain.at(x, y) = static_cast<float>(gain);
      correction.offset.at(x, y) = static_cast<float>(offset);
      if (!good) correction.bad.push_back({x, y});
    }
  return correction;
}

void correct(mtf::ImageView<float> image, const TwoPoint& correction, int threads) {
  const auto gain = correction.gain.view(), offset = correction.offset.view();
  if (gain.width != image.width || gain.height != image.height)
    throw UsageError("two-point correction: maps of " + size_of(gain) + " for an image of " + size_of(image) +
                     " pixels; measure the correction with frames of its size");
  mtf::parallel_for_each(image.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    float* row = image.row(y);
    const float *g = gain.row(y), *o = offset.row(y);
    for (std::int64_t x = 0; x < image.width; ++x) row[x] = g[x] * row[x] + o[x];
  });
}

void replace_bad(mtf::ImageView<float> image, std::span<const Place> bad) {
  if (bad.empty()) return;
  const std::int64_t pixels = image.width * image.height;
  std::vector<bool> is_bad(static_cast<std::size_t>(pixels), false);
  const auto index = [&](std::int64_t x, std::int64_t y) { return static_cast<std::size_t>(y * image.width + x); };
  for (const Place& place : bad) {
    if (place.x < 0 || place.y < 0 || place.x >= image.width || place.y >= image.height)
      throw UsageError("bad pixels: " + std::to_string(place.x) + ", " + std::to_string(place.y) +
                       " is outside an image of " + size_of(image));
    is_bad[index(place.x, place.y)] = true;
  }
  const auto mean_of = [&](std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) {
    Mean mean;
    for (std::int64_t y = std::max<std::int64_t>(y0, 0); y <= std::min(y1, image.height - 1); ++y)
      for (std::int64_t x = std::max<std::int64_t>(x0, 0); x <= std::min(x1, image.width - 1); ++x)
        if (!is_bad[index(x, y)]) mean.add(image.at(x, y));
    return mean;
  };
  if (std::ssize(bad) >= pixels && std::ranges::count(is_bad, true) == pixels)
    throw UsageError("bad pixels: all " + size_of(image) + " pixels are bad; none is left to take values from");
  std::optional<double> all;  // the mean of all good ones, where one is too far away from the nearest
  for (const Place& place : bad) {
    Mean mean;
    for (std::int64_t r = 1; r <= kReach && mean.count == 0; ++r)
      mean = mean_of(place.x - r, place.y - r, place.x + r, place.y + r);
    if (mean.count == 0 && !all) all = mean_of(0, 0, image.width - 1, image.height - 1).value();
    image.at(place.x, place.y) = static_cast<float>(mean.count > 0 ? mean.value() : *all);
  }
}

void require_reachable(const CorrectionSettings& settings, double fill, double background_e, double full_well_e) {
  const double filled = background_e / full_well_e;
  if (fill >= filled) return;
  std::string change = "shorten frame.integration_time";
  // All electrons of the background grow with the integration time.
  if (fill > 0.0) change += " to less than " + at_most(fill / filled) + " of what it is";
  change += ", or raise detector.full_well";
  if (filled < settings.high) change += " or correction.low";
  throw mtf::UsageError("[correction]: a flat frame at " + signal_of(settings, fill) +
                        " cannot be made: without any scene warm optics, stop and dark current fill " +
                        mtf::three_digits(filled) + " of it (" + mtf::three_digits(background_e) + " e-)" +
                        (filled >= 1.0 ? ", the detector is saturated" : "") + "; " + change);
}

void require_unsaturated(const CorrectionSettings& settings, double fill, const HeldPixels& held) {
  if (held.share() <= 0.1) return;
  const bool low = held.least_count > std::max(held.most_count, held.full_well);
  const bool converter = held.most_count > held.full_well;
  const bool thermal = settings.cold_k.has_value();
  throw mtf::UsageError(
      "[correction]: the flat frame at " + signal_of(settings, fill) + " is saturated: " + where_held(held) + "; " +
      (low         ? std::string("raise adc.offset or correction.") + (thermal ? "cold" : "low")
       : thermal   ? "raise adc.volts_per_count or adc.bits, or lower detector.counts_per_kelvin, adc.offset or "
                     "correction.hot"
       : converter ? "raise adc.electrons_per_count or adc.bits, or lower adc.offset or correction.high"
                   : "lower correction.high"));
}

TwoPoint measure_correction(std::int64_t width, std::int64_t height, const CorrectionSettings& settings,
                            const FlatFrame& flat) {
  require_valid("correction", settings);
  if (!(settings.low < settings.high))
    throw mtf::UsageError("correction: low = " + mtf::format_double(settings.low) + " is not below high = " +
                          mtf::format_double(settings.high) + "; the two flat frames have to differ");
  if (width < 1 || height < 1)
    throw mtf::UsageError("correction: a detector of " + size_of(width, height) + " pixels; it needs one at least");
  constexpr std::uint32_t kLast = std::numeric_limits<std::uint32_t>::max();
  const mtf::Image cold = mean_flat(width, height, settings.low, settings.frames, kLast, flat);
  const mtf::Image hot = mean_flat(width, height, settings.high, settings.frames,
                                   kLast - static_cast<std::uint32_t>(settings.frames), flat);
  return two_point_correction(cold.view(), hot.view(), settings.limit);
}

}  // namespace radiometry
