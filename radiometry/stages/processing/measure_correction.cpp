// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/processing/measure_correction.h"

#include <limits>

namespace radiometry {
namespace {

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
    throw mtf::UsageError("correction: a detector of " + std::to_string(width) + " x " + std::to_string(height) +
                          " pixels; it needs one at least");
  constexpr std::uint32_t kLast = std::numeric_limits<std::uint32_t>::max();
  const mtf::Image cold = mean_flat(width, height, settings.low, settings.frames, kLast, flat);
  const mtf::Image hot = mean_flat(width, height, settings.high, settings.frames,
                                   kLast - static_cast<std::uint32_t>(settings.frames), flat);
  return two_point_correction(cold.view(), hot.view(), settings.limit);
}

}  // namespace radiometry
