// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sky as an observer sees it: thermal radiance by zenith angle, and the flux on a horizontal plane.
//   650 ... 3500 cm^-1   radiance of the line to space (spectral_path.h)
//   0 ... 650 cm^-1      black at the lowest layer's mean temperature: water vapour closes the sky there. 42 to 55 % of
//                        the emission of 300 ... 250 K lies below 650 cm^-1
//   flux                 integral over the hemisphere of L cos(zenith) = 2 pi integral of L mu dmu, by Gauss's nodes in
//                        mu
//   clouds               black, of one temperature, over a share N of the sky: (1 - N) clear + N B(T_cloud). What the
//                        air between them and the ground adds stands in T_cloud, an effective temperature

#include <vector>

#include "radiometry/atmosphere/spectral_path.h"

namespace radiometry::atmosphere {

struct SkyRadiance {
  std::vector<double> wavenumber_cm;  ///< 650 to 3500
  std::vector<double> radiance;       ///< W m^-2 sr^-1 per cm^-1
  double below_650 = 0.0;             ///< W m^-2 sr^-1, of the wavenumbers below 650 cm^-1
  double whole = 0.0;                 ///< W m^-2 sr^-1, of all wavenumbers up to 3500 cm^-1
  double lowest_layer_k = 0.0;        ///< the temperature that below_650 has
};

/// Zenith angles from 0 to pi / 2, and beyond where the observer is above the ground and the line passes it. Layers and
/// absorbers below the tolerance of transmission are left out.
SkyRadiance sky_radiance(const Air<double>& air, double altitude_m, double zenith_rad, double tolerance = 0.0);

struct SkyFlux {
  double total_w_m2 = 0.0;
  double below_650_w_m2 = 0.0;         ///< share of the total that is assumed black
  double quadrature_error_w_m2 = 0.0;  ///< difference to half the nodes
};
/// Long-wave irradiance of a horizontal plane under a clear sky.
SkyFlux sky_flux(const Air<double>& air, double altitude_m, int nodes = 8);

/// The cloud cover N with which clear (1 - N) + sigma T_cloud^4 N is the measured flux; 0 where the sky is colder than
/// clear, 1 where warmer than covered. Throws UsageError for a cloud outside 150 ... 350 K and fluxes below 0.
double cloud_cover(double measured_w_m2, double clear_w_m2, double cloud_k);

/// Clouds over a share of the sky.
struct Clouds {
  double cover = 0.0;          ///< 0 to 1
  double temperature_k = 0.0;  ///< 150 to 350 K
};
/// The sky under clouds: radiance, and flux. Throws UsageError for a cover outside 0 ... 1 and as cloud_cover.
SkyRadiance under_clouds(SkyRadiance clear, const Clouds& clouds);
SkyFlux under_clouds(SkyFlux clear, const Clouds& clouds);

}  // namespace radiometry::atmosphere
