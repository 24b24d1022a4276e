// SPDX-License-Identifier: Apache-2.0
#pragma once

// The air of `mtf atmosphere` as people and programs read it.

#include <string>
#include <vector>

#include "apps/atmosphere/band_averages.h"
#include "apps/figures/plot.h"
#include "radiometry/atmosphere/atmosphere_settings.h"
#include "radiometry/atmosphere/sky_radiance.h"

namespace apps {

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
