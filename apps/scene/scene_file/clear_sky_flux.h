// SPDX-License-Identifier: Apache-2.0
#pragma once

// Long wave of the clear sky by the band model of the air (radiometry/atmosphere/sky_radiance.h), for the temperature
// and humidity that the weather has at the ground. The air above is that of [atmosphere], from the altitude of [place]
// on; its lowest 2 km follow the weather. The flux is computed at temperatures 5 K apart and at 21 humidities, where
// the weather needs them, and goes as straight lines between, which is within 0.5 W/m2 of the model. The model itself
// takes the sky for black below 650 cm^-1.

#include <map>
#include <optional>
#include <utility>

#include "radiometry/atmosphere/atmosphere_settings.h"

namespace apps::scene {

/// The air of a scene, from the altitude of its place on. Throws UsageError "atmosphere.KEY: ..." as read_air does, for
/// keys that weather and camera give, and for an altitude that the air does not have.
radiometry::atmosphere::Air<double> air_above(const radiometry::AtmosphereSettings& settings, double altitude_m);

class ClearSkyFlux {
 public:
  /// Throws UsageError as air_above.
  ClearSkyFlux(const radiometry::AtmosphereSettings& settings, double altitude_m);

  /// W/m2 on a horizontal plane; vapour above saturation, as hygrometers and interpolated weather have it, counts as
  /// saturated. Throws UsageError for half as much again, for air outside 180 ... 340 K and for vapour pressures below
  /// 0.
  double at(double air_k, double vapour_pressure_pa);

  /// The air with that weather at the ground; without a vapour pressure its relative humidity stays. Throws as at.
  radiometry::atmosphere::Air<double> air_at(double air_k, std::optional<double> vapour_pressure_pa) const;

 private:
  double node(int temperature, int humidity);

  radiometry::atmosphere::Air<double> air_;
  std::map<std::pair<int, int>, double> nodes_;  ///< by multiples of the steps
};

}  // namespace apps::scene
