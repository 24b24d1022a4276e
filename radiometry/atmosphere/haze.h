// SPDX-License-Identifier: Apache-2.0
#pragma once

// What floats in the air: haze or fog by its kind and the meteorological visibility, and rain.
//   visibility V   the distance at which a black object keeps 2 % contrast: extinction at 0.55 um, that of the air
//                  included, is 3.912 / V
//   0 ... 2 km     extinction of the aerosol at 0.55 um at 0, 1 and 2 km for V = 50, 23, 10, 5, 2 km, a straight line
//                  of 1 / V between and beyond 2 km of visibility (3.9 / V - 0.01 per km at the ground), in proportion
//                  to 1 / V above 50 km; exponential between the altitudes, falling to nothing at 3 km
//   2 ... 10 km    tropospheric aerosol at 70 % humidity, by season and, up to 4 km, visibility
//   10 ... 30, 30 ... 100 km   background of the stratosphere, meteoric dust: years without eruptions
// The spectrum of the boundary region depends on the kind and, fogs apart, on the relative humidity (its logarithm is a
// straight line of ln(100 - RH) between 0, 70, 80 and 99 %). Kinds: Shettle and Fenn, AFGL-TR-79-0214 (1979);
// altitudes: Kneizys et al., AFGL-TR-88-0177 (1988). Haze `none` leaves out the aerosol of all altitudes.
//   rain           drops as of Marshall and Palmer (J. Meteorol. 5, 165 (1948)), N0 exp(-Lambda D) with N0 = 8000 m^-3
//                  mm^-1 and Lambda = 4.1 R^-0.21 mm^-1 for R mm/h, take twice their area at all wavelengths:
//                  pi N0 / Lambda^3 = 0.3647 R^0.63 per km, from the ground to 6 km. There the air is saturated, and
//                  the aerosol has the spectrum of 99 % humidity.

#include <array>
#include <span>
#include <string_view>

#include "radiometry/atmosphere/air.h"

namespace radiometry::atmosphere {

enum class HazeKind { none, rural, urban, maritime, tropospheric, advection_fog, radiation_fog };
inline constexpr std::array<std::string_view, 7> kHazeNames{"none",         "rural",         "urban",        "maritime",
                                                            "tropospheric", "advection_fog", "radiation_fog"};
constexpr std::span<const std::string_view> words(HazeKind) { return kHazeNames; }

enum class Season { spring_summer, autumn_winter };
inline constexpr std::array<std::string_view, 2> kSeasonNames{"spring_summer", "autumn_winter"};
constexpr std::span<const std::string_view> words(Season) { return kSeasonNames; }
/// Autumn and winter for the two winter models, spring and summer for all others.
Season season_of(ModelAtmosphere model);

/// The visibility that goes with a kind when none is given: 23 km, 5 km for urban, 50 km for tropospheric haze, 200 m
/// for advection, 500 m for radiation fog.
double usual_visibility_m(HazeKind kind);

/// What of the aerosol counts as lost on a path. Scattered light that stays in the image as a veil over the scene is a
/// matter of the OTF (component `aerosol` of mtf); then the path loses what is absorbed alone.
enum class AerosolLoss { extinction, absorption };

template <class S>
struct Haze {
  HazeKind kind = HazeKind::none;
  S visibility_m = S(23000.0);
  Season season = Season::spring_summer;
  AerosolLoss loss = AerosolLoss::extinction;
};

/// All that a path goes through.
template <class S>
struct Air {
  Profile<S> profile;
  Haze<S> haze{};
  S rain_mm_h = S(0.0);
};

/// Throws UsageError for a profile that is not valid, visibility outside 10 m ... 1000 km, rain outside 0 ... 300 mm/h.
template <class S>
void require_valid(const Air<S>& air);

/// Extinction of the aerosol at 0.55 um per km, of the four regions of altitude (their spectra differ).
enum class AerosolRegion { boundary, troposphere, stratosphere, upper };
inline constexpr std::size_t kAerosolRegions = 4;
template <class S>
std::array<S, kAerosolRegions> aerosol_per_km(const Haze<S>& haze, double altitude_m);

/// Extinction of rain per km, the same at all wavelengths of the model; the slope at 0 mm/h, which is infinite, as that
/// at 0.01 mm/h.
template <class S>
S rain_per_km(const S& rain_mm_h);

}  // namespace radiometry::atmosphere
