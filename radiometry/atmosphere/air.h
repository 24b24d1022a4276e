// SPDX-License-Identifier: Apache-2.0
#pragma once

// Air by altitude: pressure, temperature and the mixing ratios of the gases that absorb, on levels. Between two levels
// the temperature goes as a straight line of the altitude, pressure and mixing ratios exponentially (as a straight line
// where one end is 0). The number of molecules follows from pressure and temperature,
//   n_air = n0 (P / P0) (T0 / T),   n0 = 2.6868e19 cm^-3, P0 = 1013.25 hPa, T0 = 273.15 K.
//
// Vapour that saturates air of temperature T over water (McClatchey et al., AFCRL-71-0279 (1971), the formula of the
// band models of that laboratory):
//   n_sat = (N_A / 18.015) A exp(18.9766 - 14.9595 A - 2.43882 A^2) 1e-6 cm^-3,   A = T0 / T, N_A = 6.02214076e23.
//
// S is double or a number with derivatives (ceres::Jet<double, N>): those of humidity, temperature, pressure, CO2.

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace radiometry::atmosphere {

enum class Gas {
  water,
  carbon_dioxide,
  ozone,
  nitrous_oxide,
  carbon_monoxide,
  methane,
  oxygen,
  nitric_oxide,
  sulphur_dioxide,
  nitrogen_dioxide,
  ammonia,
  nitric_acid
};
inline constexpr std::size_t kGases = 12;

template <class S>
struct Level {
  double altitude_m = 0.0;  ///< above the sea, the ground of the models
  S pressure_pa{};
  S temperature_k{};
  std::array<S, kGases> ppm{};  ///< by volume, of the whole air: molecules of the gas per 1e6

  const S& operator[](Gas gas) const { return ppm[static_cast<std::size_t>(gas)]; }
  S& operator[](Gas gas) { return ppm[static_cast<std::size_t>(gas)]; }
};

/// Levels in order of rising altitude. A profile of one level holds the air of horizontal lines; every other line of
/// sight needs a profile of at least two levels.
template <class S>
struct Profile {
  std::string source;  ///< for messages
  std::vector<Level<S>> levels;
};

/// The model atmospheres of AFGL-TR-86-0110 (Anderson et al., 1986): 46 levels from 0 to 100 km.
enum class ModelAtmosphere {
  tropical,
  mid_latitude_summer,
  mid_latitude_winter,
  subarctic_summer,
  subarctic_winter,
  us_standard_1976
};
inline constexpr std::array<std::string_view, 6> kModelAtmosphereNames{
    "tropical",         "mid_latitude_summer", "mid_latitude_winter",
    "subarctic_summer", "subarctic_winter",    "us_standard_1976"};
constexpr std::span<const std::string_view> words(ModelAtmosphere) { return kModelAtmosphereNames; }

inline constexpr double kCarbonDioxide_ppm = 420.0;       ///< near the ground in the 2020s
inline constexpr double kModelCarbonDioxide_ppm = 330.0;  ///< of the model atmospheres as published

Profile<double> model_profile(ModelAtmosphere model, double carbon_dioxide_ppm = kCarbonDioxide_ppm);

/// The same air with another scalar.
template <class S>
Profile<S> with_scalar(const Profile<double>& profile);

/// CO2 of all levels in proportion, so that the lowest one has `ppm`. Throws UsageError below 0 and above 1e5.
template <class S>
Profile<S> with_carbon_dioxide(Profile<S> profile, const S& ppm);

/// Another temperature and relative humidity (percent) at the lowest level. The change fades to nothing at 2000 m above
/// it, the top of the haze's boundary layer: T(z) changes by (1 - z / 2000 m) times the change at the ground, the
/// relative humidity by the power (1 - z / 2000 m) of the quotient at the ground, at most 100 %. The other gases and
/// the pressure stay. Throws UsageError as surface_air does.
template <class S>
Profile<S> with_surface(Profile<S> profile, const S& temperature_k, const S& relative_humidity_percent);

/// A profile of one level, at altitude 0, from what a weather station measures; it is for horizontal lines. CO2 is as
/// given, and the other gases but water are those of US standard 1976 at the ground. Throws UsageError for a humidity
/// outside 0 ... 100 %, a temperature outside 150 ... 350 K (degrees Celsius given for kelvin are named), a pressure
/// outside 0.01 ... 120000 Pa (hectopascals given for pascals are named where the temperature is that of the lower
/// air), and vapour that would be more than half of the air.
template <class S>
Profile<S> surface_air(const S& pressure_pa, const S& temperature_k, const S& relative_humidity_percent,
                       double carbon_dioxide_ppm = kCarbonDioxide_ppm);

/// Throws UsageError (with the profile's source and the level) for no levels, altitudes that do not rise or are outside
/// -500 m ... 120 km, pressures that do not fall, are not above 0 or look like hectopascals, temperatures outside 150
/// ... 350 K (below 60 km; 100 ... 1000 K above), mixing ratios that are negative, not finite or sum to more than all
/// of the air, and vapour above saturation by more than half (supersaturation over ice, as in the models, passes).
template <class S>
void require_valid(const Profile<S>& profile);

/// Molecules of saturated vapour per cm^3.
template <class S>
S saturation_per_cm3(const S& temperature_k);
/// Molecules of air per cm^3.
template <class S>
S air_per_cm3(const S& pressure_pa, const S& temperature_k);
/// The mixing ratio of vapour for a relative humidity, and back. Percent.
template <class S>
S water_ppm(const S& pressure_pa, const S& temperature_k, const S& relative_humidity_percent);
template <class S>
S relative_humidity_percent(const Level<S>& level);

/// The air at an altitude between the lowest and the highest level. Throws UsageError outside; for a profile of one
/// level its air is everywhere.
template <class S>
Level<S> level_at(const Profile<S>& profile, double altitude_m);

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
