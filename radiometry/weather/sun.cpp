// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/sun.h"

#include <erfa.h>
#include <erfam.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/performance/implicit_root.h"
#include "radiometry/weather/instant.h"

namespace radiometry::heat {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kUnixEpoch_jd = 2440587.5;
constexpr double kTtMinusTai_s = 32.184;
constexpr double kFirstLeapSeconds_s = 10.0;             // TAI - UTC when leap seconds began, 1972-01-01
constexpr double kEarthRotation_rad_s = 7.292115146e-5;  // of the sidereal day
constexpr double kSolarConstant_w_m2 = 1361.0;

double tai_minus_utc(double utc_s) {
  const CalendarDate date = date_of(utc_s);
  if (date.year < 1972) return kFirstLeapSeconds_s;
  double leap_s = 0.0;
  eraDat(date.year, date.month, date.day, 0.0, &leap_s);  // "dubious" beyond its last year: the last value holds
  return leap_s;
}

/// Vector from the observer to the sun as its light arrives, in local axes; the distance in au.
struct ToSun {
  std::array<double, 3> direction{};
  double distance_au = 1.0;
};

ToSun to_sun(double utc_s, const Place& place) {
  const double day = utc_s / kDay_s;
  const double tt_day = day + (tai_minus_utc(utc_s) + kTtMinusTai_s) / kDay_s;

  double from_sun[2][3], earth[2][3];  // of the earth, au and au/day
  eraEpv00(kUnixEpoch_jd, tt_day, from_sun, earth);
  double to_earth_axes[3][3];  // celestial to terrestrial
  eraC2t00b(kUnixEpoch_jd, tt_day, kUnixEpoch_jd, day, 0.0, 0.0, to_earth_axes);

  double ground[3];  // observer, m, terrestrial
  eraGd2gc(ERFA_WGS84, place.longitude_rad, place.latitude_rad, place.altitude_m, ground);
  double turning[3] = {-kEarthRotation_rad_s * ground[1], kEarthRotation_rad_s * ground[0], 0.0};  // m/s
  double observer[3], speed[3];
  eraTrxp(to_earth_axes, ground, observer);
  eraTrxp(to_earth_axes, turning, speed);

  double sun[3], velocity[3];  // of the light's source from the observer, au; of the observer in units of c
  double speed2 = 0.0;
  for (int i = 0; i < 3; ++i) {
    sun[i] = -from_sun[0][i] - observer[i] / ERFA_DAU;
    velocity[i] = earth[1][i] * ERFA_DAU / ERFA_DAYSEC / ERFA_CMPS + speed[i] / ERFA_CMPS;
    speed2 += velocity[i] * velocity[i];
  }
  double distance = 0.0, natural[3], proper[3], terrestrial[3];
  eraPn(sun, &distance, natural);
  eraAb(natural, velocity, distance, std::sqrt(1.0 - speed2), proper);
  eraRxp(to_earth_axes, proper, terrestrial);

  const double sp = std::sin(place.latitude_rad), cp = std::cos(place.latitude_rad);
  const double sl = std::sin(place.longitude_rad), cl = std::cos(place.longitude_rad);
  const double along = cl * terrestrial[0] + sl * terrestrial[1];
  return {
      {-sl * terrestrial[0] + cl * terrestrial[1], cp * terrestrial[2] - sp * along, sp * terrestrial[2] + cp * along},
      distance};
}

SunPosition position_of(const std::array<double, 3>& direction, double distance_au) {
  const auto [east, north, up] = direction;
  const double azimuth = std::atan2(east, north);
  return {direction, std::atan2(std::hypot(east, north), up), azimuth < 0.0 ? azimuth + 2.0 * kPi : azimuth,
          distance_au};
}

/// Refraction A tan z + B tan^3 z with one Newton step, as ERFA's atioq applies it: the direction before the air to the
/// one that is seen.
std::array<double, 3> refracted(const std::array<double, 3>& direction, const RefractingAir& air) {
  constexpr double kWavelength_um = 0.55, kLeastUp = 0.05;  // sine of the lowest elevation that the formula serves
  double a = 0.0, b = 0.0;
  eraRefco(air.pressure_pa / 100.0, air.temperature_k - mtf::kZeroCelsius_k, air.relative_humidity, kWavelength_um, &a,
           &b);
  const auto [east, north, up] = direction;
  const double across = std::max(std::hypot(east, north), 1e-6), high = std::max(up, kLeastUp);
  const double tangent = across / high, w = b * tangent * tangent;
  const double bend = (a + w) * tangent / (1.0 + (a + 3.0 * w) / (high * high));
  const double cosine = 1.0 - bend * bend / 2.0, shrink = cosine - bend * high / across;
  const std::array<double, 3> seen{east * shrink, north * shrink, cosine * up + bend * across};
  const double length = std::hypot(seen[0], seen[1], seen[2]);
  return {seen[0] / length, seen[1] / length, seen[2] / length};
}

void require_place_and_time(double utc_s, const Place& place) {
  if (!(std::abs(place.latitude_rad) <= kPi / 2 && std::abs(place.longitude_rad) <= 2.0 * kPi &&
        place.altitude_m >= -1000.0 && place.altitude_m <= 100e3))
    throw mtf::UsageError(
        "sun_position: the place is not on the earth; latitudes are from -pi/2 to pi/2 rad, longitudes from -2 pi to "
        "2 pi rad, altitudes from -1000 to 100000 m");
  if (!(utc_s >= instant_of({1800, 1, 1}) && utc_s <= instant_of({2200, 1, 1})))
    throw mtf::UsageError(
        "sun_position: the time is outside of the years 1800 to 2200; it counts seconds since 1970-01-01T00:00:00Z");
}

}  // namespace

SunPosition sun_position(double utc_s, const Place& place) {
  require_place_and_time(utc_s, place);
  const ToSun sun = to_sun(utc_s, place);
  return position_of(sun.direction, sun.distance_au);
}

SunPosition sun_position(double utc_s, const Place& place, const RefractingAir& air) {
  if (!(air.pressure_pa >= 0.0 && air.pressure_pa <= 120e3 && air.temperature_k >= 150.0 &&
        air.temperature_k <= 400.0 && air.relative_humidity >= 0.0 && air.relative_humidity <= 1.0))
    throw mtf::UsageError(
        "sun_position: no such air; pressures are from 0 to 120000 Pa, temperatures from 150 to 400 K, relative "
        "humidities from 0 to 1");
  const SunPosition sun = sun_position(utc_s, place);
  return position_of(refracted(sun.direction, air), sun.distance_au);
}

double solar_time_h(double utc_s, double longitude_rad) {
  const auto [east, north, up] = sun_position(utc_s, {.longitude_rad = longitude_rad}).direction;
  const double time_h = 12.0 * (1.0 + std::atan2(-east, up) / kPi);
  return time_h < 24.0 ? time_h : 0.0;
}

std::array<double, 3> in_scene_axes(const std::array<double, 3>& direction, double north_rad) {
  const double c = std::cos(north_rad), s = std::sin(north_rad);
  const auto [east, north, up] = direction;
  return {c * east - s * north, s * east + c * north, up};
}

double extraterrestrial_normal_w_m2(const SunPosition& sun) {
  return kSolarConstant_w_m2 / (sun.distance_au * sun.distance_au);
}

std::vector<SunCrossing> sun_crossings(const Place& place, double begin_s, double end_s, double zenith_rad) {
  constexpr double kStep_s = 600.0;
  if (!(begin_s <= end_s)) throw mtf::UsageError("sun_crossings: the end is before the beginning");
  const auto above = [&](double t) { return zenith_rad - sun_position(t, place).zenith_rad; };
  std::vector<SunCrossing> crossings;
  double a = begin_s, above_a = above(a);
  while (a < end_s) {
    const double b = std::min(a + kStep_s, end_s), above_b = above(b);
    if ((above_a > 0.0) != (above_b > 0.0))
      crossings.push_back({find_root(above, a, b, above_a, above_b), above_b > 0.0});
    a = b;
    above_a = above_b;
  }
  return crossings;
}

}  // namespace radiometry::heat
