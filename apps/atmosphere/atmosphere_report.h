// SPDX-License-Identifier: Apache-2.0
#pragma once

// The air of `mtf atmosphere` as people and programs read it.

#include <array>
#include <string>
#include <vector>

#include "apps/figures/plot.h"
#include "radiometry/atmosphere/atmosphere_settings.h"
#include "radiometry/atmosphere/sky_radiance.h"
#include "radiometry/atmosphere/spectral_path.h"
#include "radiometry/light/spectral_signal.h"

namespace apps {

/// What a sensor has of a path in its band, all through the curves of the camera R together:
///   transmission            integral of tau R L(T) / integral of R L(T), for a blackbody of temperature T
///   contrast_transmission   the same with dL/dT: what is left of small differences of temperature
///   radiance                integral of R L_path: what the air adds, W m^-2 sr^-1 or photons s^-1 m^-2 sr^-1
/// A product of band averages would be another number: bands of the air rise and fall within the response.
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

struct AtmosphereReport {
  std::string air, line;  ///< in words
  radiometry::atmosphere::SpectralPath<double> path;
  std::vector<BandAverage> bands;
  radiometry::Flux flux = radiometry::Flux::watts;  ///< of the averages
  bool response = false;                            ///< a sensor's curves weigh them
  double source_k = 300.0;
  std::vector<std::string> limits;
};

/// What is in the table, in words: "mid_latitude_summer, rural haze, visibility 23 km".
std::string air_words(const radiometry::AtmosphereSettings& settings,
                      const radiometry::atmosphere::Air<double>& through);
std::string sight_words(const radiometry::atmosphere::SightNumbers<double>& sight, double sensor_altitude_m);

std::string as_table(const AtmosphereReport& report);
std::string as_json(const AtmosphereReport& report);
/// Transmission of all and of each component that takes more than a twentieth anywhere; radiance beside it.
std::vector<Figure> atmosphere_figures(const AtmosphereReport& report);

/// The sky over zenith angles: radiance in each band and over all wavelengths.
struct SkyReport {
  std::string air;
  double altitude_m = 0.0;
  std::vector<double> zenith_deg;
  std::vector<radiometry::Interval> bands;
  std::vector<std::vector<double>> band_radiance;  ///< [angle][band], W m^-2 sr^-1
  std::vector<double> radiance;                    ///< of all wavelengths
  radiometry::atmosphere::SkyFlux flux;
  radiometry::atmosphere::Clouds clouds{};
};
std::string as_table(const SkyReport& report);
std::string as_csv(const SkyReport& report);
std::string as_json(const SkyReport& report);

}  // namespace apps
