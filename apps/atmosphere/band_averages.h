// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a sensor has of a path in its band, all through the curves of the camera R together:
//   transmission            integral of tau R L(T) / integral of R L(T), for a blackbody of temperature T
//   contrast_transmission   the same with dL/dT: what is left of small differences of temperature
//   radiance                integral of R L_path: what the air adds, W m^-2 sr^-1 or photons s^-1 m^-2 sr^-1
// A product of band averages would be another number: bands of the air rise and fall within the response.

#include <array>

#include "radiometry/atmosphere/spectral_path.h"
#include "radiometry/light/spectral_signal.h"

namespace apps {

struct BandAverage {
  radiometry::Interval band;
  double transmission = 0.0, contrast_transmission = 0.0;
  double radiance = 0.0;
  bool has_radiance = true;  ///< false where a part of the band has no emission in the model (below 2.857 um)
  std::array<double, radiometry::atmosphere::kComponents> component{};  ///< transmission by each alone
};

/// Of a path computed with its components, for a camera whose curves count in its own band. Throws UsageError where a
/// blackbody of `source_k` gives nothing there.
BandAverage band_average(const radiometry::atmosphere::SpectralPath<double>& path,
                         const radiometry::SpectralCamera& camera, double source_k);

}  // namespace apps
