// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/range_weights.h"

#include <algorithm>
#include <cmath>

#include "apps/sensor/otf_curves.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"

namespace apps {
namespace {

constexpr double kSeen = 1e-4;  // of an MTF: below that nobody sees the difference

using Values = std::vector<mtf::Complex<double>>;

/// Along both axes, at half of the Nyquist frequency and at it.
Values otf_values(mtf::System<double> system, std::shared_ptr<const mtf::ElectronRate> rate) {
  system.band->rate = std::move(rate);
  Values all;
  for (const double angle_deg : {0.0, 90.0}) {
    const Values along = otf_curves(system, {0.25, 0.5}, make_direction(system.frame, "cy/px", angle_deg)).system.otf;
    all.insert(all.end(), along.begin(), along.end());
  }
  return all;
}

double largest_difference(const Values& a, const Values& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(std::hypot(a[i].re, a[i].im) - std::hypot(b[i].re, b[i].im)));
  return most;
}

std::string kilometres(double m) { return significant(1e-3 * m, 3) + " km"; }

}  // namespace

RangeWeights range_weights(const mtf::System<double>& system, const LoadedSensor& loaded, const PixelRanges& ranges) {
  // Pixels are float32, and the last may be rounded beyond the table.
  const auto rate_at = [&](double range_m) {
    return electron_rate(system, loaded, ranges.paths->at(std::min(range_m, ranges.paths->range_m().back())));
  };
  RangeWeights weights;
  try {
    weights.rate = rate_at(ranges.middle_m);
  } catch (const mtf::UsageError&) {
    weights.warning = "scene.depth_channel: no light gets through " + kilometres(ranges.middle_m) +
                      " of air, the middle of the ranges: the OTF of the band is that without air";
    return weights;
  }
  if (!weights.rate || ranges.nearest_m == ranges.longest_m) return weights;
  const Values middle = otf_values(system, weights.rate);
  double most = 0.0;
  for (const double end_m : {ranges.nearest_m, ranges.longest_m}) try {
      most = std::max(most, largest_difference(otf_values(system, rate_at(end_m)), middle));
    } catch (const mtf::UsageError&) {  // opaque: there is no image at that range
    }
  if (most > kSeen)
    weights.warning = "scene.depth_channel: all pixels are filtered by the OTF of the band behind " +
                      kilometres(ranges.middle_m) + " of air, the middle of the ranges; at " +
                      kilometres(ranges.nearest_m) + " and " + kilometres(ranges.longest_m) +
                      " the MTF differs from it by up to " + significant(most, 2) +
                      ", which is not in the promised error";
  return weights;
}

}  // namespace apps
