// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bodies of haze.h for any scalar.

#include "radiometry/atmosphere/air_impl.h"
#include "radiometry/atmosphere/band_model.h"

namespace radiometry::atmosphere {

void require_haze(double visibility_m, double rain_mm_h);

template <class S>
void require_valid(const Air<S>& air) {
  require_valid(air.profile);
  require_haze(value_of(air.haze.visibility_m), value_of(air.rain_mm_h));
}

/// Of values at 50, 23, 10, 5, 2 km (or the first of these): a straight line of 1 / V between neighbours; above 50 km
/// in proportion to 1 / V or constant; below the last the line of the last two goes on, or the value stays.
template <class S, std::size_t N>
S by_visibility(const S& visibility_m, const std::array<double, N>& values, bool beyond) {
  constexpr std::array<double, 5> kVisibility_m{50e3, 23e3, 10e3, 5e3, 2e3};
  if (value_of(visibility_m) >= kVisibility_m[0])
    return beyond ? S(values[0] * kVisibility_m[0] / visibility_m) : S(values[0]);
  if (!beyond && value_of(visibility_m) <= kVisibility_m[N - 1]) return S(values[N - 1]);
  std::size_t i = 1;
  while (i + 1 < N && value_of(visibility_m) < kVisibility_m[i]) ++i;
  const double a = 1.0 / kVisibility_m[i - 1], b = 1.0 / kVisibility_m[i];
  return values[i - 1] + (1.0 / visibility_m - a) / (b - a) * (values[i] - values[i - 1]);
}

/// Of values at rising altitudes in km; 0 outside of them.
template <class S, std::size_t N>
S by_altitude(double km, const std::array<double, N>& altitude_km, const std::array<S, N>& values) {
  if (km < altitude_km.front() || km > altitude_km.back()) return S(0.0);
  const auto above = std::upper_bound(altitude_km.begin() + 1, altitude_km.end() - 1, km);
  const auto i = static_cast<std::size_t>(above - altitude_km.begin());
  return exponential_between(values[i - 1], values[i], S((km - above[-1]) / (above[0] - above[-1])));
}

template <class S>
std::array<S, kAerosolRegions> aerosol_per_km(const Haze<S>& haze, double altitude_m) {
  std::array<S, kAerosolRegions> out{S(0.0), S(0.0), S(0.0), S(0.0)};
  if (haze.kind == HazeKind::none) return out;
  const double km = std::clamp(1e-3 * altitude_m, 0.0, 100.0);
  if (km < 3.0) {
    std::array<S, 4> ground;
    for (std::size_t z = 0; z < 3; ++z) {
      std::array<double, 5> values;
      for (std::size_t v = 0; v < 5; ++v) values[v] = boundary_aerosol(v, z);
      ground[z] = by_visibility(haze.visibility_m, values, true);
    }
    ground[3] = S(0.0);
    out[0] = by_altitude(km, {0.0, 1.0, 2.0, 3.0}, ground);
  }
  if (km > 2.0 && km < 11.0) {
    std::array<double, 10> altitude;
    std::array<S, 10> values;
    for (std::size_t z = 0; z < 10; ++z) {
      altitude[z] = 2.0 + static_cast<double>(z);
      values[z] = z == 0 || z == 9 ? S(0.0)
                                   : by_visibility(haze.visibility_m,
                                                   std::array{tropospheric_aerosol(haze.season, 0, z - 1),
                                                              tropospheric_aerosol(haze.season, 1, z - 1)},
                                                   false);
    }
    out[1] = by_altitude(km, altitude, values);
  }
  if (km > 10.0 && km < 35.0) {
    std::array<double, 18> altitude;
    std::array<S, 18> values;
    for (std::size_t z = 0; z < 16; ++z) {
      altitude[z] = 10.0 + static_cast<double>(z);
      values[z] = z == 0 ? S(0.0) : S(stratospheric_aerosol(haze.season, z - 1));
    }
    altitude[16] = 30.0, values[16] = S(stratospheric_aerosol(haze.season, 15));
    altitude[17] = 35.0, values[17] = S(0.0);
    out[2] = by_altitude(km, altitude, values);
  }
  if (km > 30.0) {
    std::array<S, 7> values;
    for (std::size_t z = 0; z < 7; ++z) values[z] = z == 0 ? S(0.0) : S(upper_aerosol(z - 1));
    out[3] = by_altitude(km, {30.0, 35.0, 40.0, 45.0, 50.0, 70.0, 100.0}, values);
  }
  return out;
}

/// The spectrum of the boundary region for a relative humidity.
template <class S>
std::array<S, kAerosolNodes> boundary_spectrum(HazeKind kind, AerosolLoss loss, const S& relative_humidity_percent) {
  using std::exp, std::log;
  std::array<S, kAerosolNodes> out;
  if (kind == HazeKind::advection_fog || kind == HazeKind::radiation_fog) {
    std::ranges::transform(fog_spectrum(kind, loss), out.begin(), [](double v) { return S(v); });
    return out;
  }
  S humidity = haze_humidity_share() * relative_humidity_percent;
  if (value_of(humidity) > kHazeHumidities.back()) humidity = S(kHazeHumidities.back());
  std::size_t i = 1;
  while (i + 1 < kHazeHumidities.size() && value_of(humidity) > kHazeHumidities[i]) ++i;
  const double dry = std::log(100.0 - kHazeHumidities[i - 1]), humid = std::log(100.0 - kHazeHumidities[i]);
  const S share = (log(100.0 - humidity) - dry) / (humid - dry);
  const auto a = haze_spectrum(kind, loss, i - 1), b = haze_spectrum(kind, loss, i);
  for (std::size_t k = 0; k < kAerosolNodes; ++k) out[k] = a[k] * exp(share * std::log(b[k] / a[k]));
  return out;
}

template <class S>
S rain_per_km(const S& rain_mm_h) {
  constexpr double kPower = 0.63, kFactor = mtf::kPi * 8000.0 / (4.1 * 4.1 * 4.1) * 1e-3, kSlopeFrom = 0.01;
  const double rate = value_of(rain_mm_h);
  return lift({kFactor * std::pow(rate, kPower), kFactor * kPower * std::pow(std::max(rate, kSlopeFrom), kPower - 1.0)},
              rain_mm_h);
}

}  // namespace radiometry::atmosphere
