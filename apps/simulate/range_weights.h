// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OTF of a band where each pixel has a range of its own. A wavelength counts in the OTF by the light that gets
// through the air, so that the OTF of a band changes along the path; an image is filtered by one OTF. It is that of the
// middle range, the geometric mean of the nearest and the longest, and how much the OTFs of these two differ from it
// can be said.

#include <memory>
#include <string>

#include "apps/sensor/sensor_chain.h"

namespace apps {

struct RangeWeights {
  std::shared_ptr<const mtf::ElectronRate> rate;  ///< of Band::rate, behind the path of the middle range
  std::string warning;  ///< by how much the MTF differs at the ends of the ranges; "" below 1e-4
};

/// For a sensor with `paths`. Nothing where the band needs no weights. Throws UsageError as LoadedSensor::paths and
/// electron_rate.
RangeWeights range_weights(const mtf::System<double>& system, const LoadedSensor& loaded, double nearest_m,
                           double longest_m);

}  // namespace apps
