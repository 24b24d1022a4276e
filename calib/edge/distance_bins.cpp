// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/distance_bins.h"

namespace calib {

constexpr DistanceBins::DistanceBins() {
  constexpr auto kMiddle = static_cast<std::size_t>(kRange_px) * kFinest;
  std::size_t bin = 0;
  double from = 0.0;
  for (const DistanceZone& zone : kDistanceZones)
    for (; from < zone.end_px; from += zone.step_px, ++bin) {
      const double end = from + zone.step_px;
      knot_[kSideBins + bin] = from;
      knot_[kSideBins + bin + 1] = end;
      knot_[kSideBins - bin - 1] = -end;
      centre_[kSideBins + bin] = 0.5 * (from + end);
      centre_[kSideBins - bin - 1] = -0.5 * (from + end);
      for (auto i = static_cast<std::size_t>(from * kFinest); i < static_cast<std::size_t>(end * kFinest); ++i) {
        at_step_[kMiddle + i] = static_cast<std::int16_t>(kSideBins + bin);
        at_step_[kMiddle - 1 - i] = static_cast<std::int16_t>(kSideBins - 1 - bin);
      }
    }
}

const DistanceBins& DistanceBins::get() {
  static constexpr DistanceBins bins;
  return bins;
}

}  // namespace calib
