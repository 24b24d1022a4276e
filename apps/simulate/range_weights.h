// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OTF of a band where each pixel has a range of its own. A wavelength counts in the OTF by the light that gets
// through the air, so that the OTF of a band changes along the path; an image is filtered by one OTF. It is that of the
// middle range, the geometric mean of all pixels, and how much the OTFs of the nearest and the longest range differ
// from it can be said.

#include <memory>
#include <string>

#include "apps/sensor/sensor_chain.h"

namespace apps {

struct RangeWeights {
  std::shared_ptr<const mtf::ElectronRate> rate;  ///< of Band::rate, behind the path of the middle range
  std::string warning;  ///< by how much the MTF differs at the ends of the ranges; "" below 1e-4
};

/// Ranges of the pixels of an image, in m, and the paths that long.
struct PixelRanges {
  double nearest_m = 0.0, middle_m = 0.0, longest_m = 0.0;
  std::shared_ptr<const radiometry::PathTable> paths;
};

/// No rate where the band needs no weights, and none, with a warning, where no light gets through its middle range.
RangeWeights range_weights(const mtf::System<double>& system, const LoadedSensor& loaded, const PixelRanges& ranges);

}  // namespace apps
