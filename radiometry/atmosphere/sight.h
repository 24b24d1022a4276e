// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lines of sight from a sensor. Altitudes are above the sea in m, the ground is at altitude 0; ranges in m along the
// line; zenith angles in rad at the sensor, 0 up and pi down, of the light as it arrives (refracted).
//   Horizontal   constant altitude: the air is the same all along
//   Between      sensor and object by their altitudes and the range between them
//   AtAngle      an angle at the sensor and a range
//   ToAltitude   an angle at the sensor, up or down to an altitude: the first time that the line gets there
//   ToSpace      an angle at the sensor, to the highest level of the profile
// All but Horizontal go through a spherical earth of 6371.23 km with refraction (Snell's law in shells,
// n r sin theta = const; refractivity of Edlen's formula at 2000 cm^-1 (5 um) as given by Kneizys et al.,
// AFGL-TR-88-0177, which is within 1 % of it at 10 um): Horizontal is a straight line in a flat earth.

#include <variant>

#include "radiometry/atmosphere/air.h"

namespace radiometry::atmosphere {

inline constexpr double kEarthRadius_m = 6371230.0;

template <class S>
struct Horizontal {
  double altitude_m = 0.0;
  S range_m{};
};
template <class S>
struct Between {
  double sensor_altitude_m = 0.0, object_altitude_m = 0.0;
  S range_m{};
};
template <class S>
struct AtAngle {
  double sensor_altitude_m = 0.0;
  S zenith_rad{}, range_m{};
};
template <class S>
struct ToAltitude {
  double sensor_altitude_m = 0.0;
  S zenith_rad{};
  double object_altitude_m = 0.0;
};
template <class S>
struct ToSpace {
  double sensor_altitude_m = 0.0;
  S zenith_rad{};
};
template <class S>
using Sight = std::variant<Horizontal<S>, Between<S>, AtAngle<S>, ToAltitude<S>, ToSpace<S>>;

/// Range, angles and altitudes of a line of sight, whatever it was given by.
template <class S>
struct SightNumbers {
  S range_m{};
  S zenith_rad{};         ///< at the sensor
  S object_altitude_m{};  ///< of the far end
  S lowest_altitude_m{};  ///< of either end, or the tangent height between them
};

/// Throws UsageError (with the numbers that would do) for a sensor below the ground or, unless Horizontal, above the
/// highest level, ranges below 0 or not finite, objects nearer in altitude than the range allows, lines that meet the
/// ground before their end (beyond the horizon), altitudes that a line of that angle never gets to, and profiles of one
/// level for lines that are not Horizontal.
template <class S>
SightNumbers<S> sight_numbers(const Air<S>& air, const Sight<S>& sight);

/// The longest range from one altitude to another past the ground, in m: the distance of the horizon.
double horizon_range_m(const Air<double>& air, double sensor_altitude_m, double object_altitude_m);

}  // namespace radiometry::atmosphere
