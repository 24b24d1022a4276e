// SPDX-License-Identifier: Apache-2.0
#pragma once

// The place of the sun in the sky. The direction from the observer to the centre of the sun is
//   s = R(t) [aberration of (sun - earth - observer)]
// with the heliocentric earth of ERFA's epv00 (VSOP2000 fitted to DE405), bias, precession, nutation (IAU 2000B) and
// earth rotation in R, the observer on the WGS 84 ellipsoid (so parallax is in it), and annual and diurnal aberration;
// local axes are x east, y north, z along the normal of the ellipsoid. UT1 is taken for UTC and polar motion for 0:
// UT1 - UTC is below 0.9 s, in which the direction turns by 0.0038 deg. TT - UTC are the leap seconds that ERFA knows;
// before 1972 it is held at 42.184 s, which costs at most 0.0006 deg from 1900 on, and leap seconds of the future,
// which nobody knows, cost 0.0007 deg a minute. Angles in rad, azimuth from north clockwise (over east), times in
// seconds of UTC (instant.h).

#include <array>
#include <vector>

namespace radiometry::heat {

/// A point of the earth, geodetic coordinates of WGS 84.
struct Place {
  double latitude_rad = 0.0;   ///< north positive, -pi/2 to pi/2
  double longitude_rad = 0.0;  ///< east positive
  double altitude_m = 0.0;
};

struct SunPosition {
  std::array<double, 3> direction{0.0, 0.0, 1.0};  ///< unit vector to the sun; x east, y north, z up
  double zenith_rad = 0.0;                         ///< angle from the vertical; above pi/2 the sun is down
  double azimuth_rad = 0.0;                        ///< [0, 2 pi)
  double distance_au = 1.0;                        ///< from the observer
};

/// Air at the observer, which bends the light.
struct RefractingAir {
  double pressure_pa = 101325.0;
  double temperature_k = 288.15;
  double relative_humidity = 0.0;  ///< 0 to 1
};

/// Geometric position: the light of a sun without air. This is the one of the heat balance. Throws UsageError for a
/// place that is not on the earth or a time outside of the years 1800 to 2200.
SunPosition sun_position(double utc_s, const Place& place);

/// The position as it is seen through air: A tan z + B tan^3 z of ERFA's refco at 0.55 um, held at its value of an
/// elevation of 3 deg for a lower sun.
SunPosition sun_position(double utc_s, const Place& place, const RefractingAir& air);

/// Apparent solar time of a longitude, h from 0 to 24: 12 when the sun is in the meridian. To a second: the sun is seen
/// from the equator.
double solar_time_h(double utc_s, double longitude_rad);

/// A direction in the axes of a scene whose +y has the azimuth `north_rad`.
std::array<double, 3> in_scene_axes(const std::array<double, 3>& direction, double north_rad);

/// Irradiance of a plane that faces the sun outside of the atmosphere, W/m2: 1361 / distance^2 (Kopp and Lean, Geophys.
/// Res. Lett. 38, L01706 (2011)).
double extraterrestrial_normal_w_m2(const SunPosition& sun);

/// The sun passes a zenith angle.
struct SunCrossing {
  double utc_s = 0.0;
  bool rises = false;  ///< otherwise it sets
};

/// The times between `begin_s` and `end_s`, in order, at which the zenith angle of the geometric sun passes
/// `zenith_rad`, to 0.01 s; none where the sun stays up or down. The search goes in steps of 10 min, so that daylight
/// (or night) of less than that at the edge of the polar night may be missed. 90.833 deg is the sunrise of almanacs.
std::vector<SunCrossing> sun_crossings(const Place& place, double begin_s, double end_s,
                                       double zenith_rad = 1.5707963267948966);

/// The sun at a time.
struct SunAt {
  double utc_s = 0.0;
  SunPosition sun;
};

}  // namespace radiometry::heat
