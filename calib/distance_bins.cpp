// SPDX-License-Identifier: Apache-2.0
#include "calib/distance_bins.h"

namespace calib {

DistanceBins::DistanceBins() {
  std::vector<double> side{0.0};
  for (const DistanceZone& zone : kDistanceZones)
    while (side.back() < zone.end_px) side.push_back(side.back() + zone.step_px);
  for (auto i = side.size(); i-- > 1;) knot_.push_back(-side[i]);
  knot_.insert(knot_.end(), side.begin(), side.end());
  std::int16_t bin = 0;
  for (int i = 0; i < static_cast<int>(kReach_px) * kFinest; ++i) {
    while (side[static_cast<std::size_t>(bin) + 1] * kFinest <= i) ++bin;
    side_.push_back(bin);
  }
}

const DistanceBins& DistanceBins::get() {
  static const DistanceBins bins;
  return bins;
}

}  // namespace calib
