// SPDX-License-Identifier: Apache-2.0
#include "radiometry/measure_correction.h"

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

}  // namespace

TwoPoint measure_correction(std::int64_t width, std::int64_t height, const CorrectionSettings& settings,
                            const FlatFrame& flat) {
  require_valid("correction", settings);
  if (!(settings.low < settings.high))
    throw mtf::UsageError("correction: low = " + mtf::format_double(settings.low) +
                          " is not below high = " + mtf::format_double(settings.high) + "; two levels are needed");
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
