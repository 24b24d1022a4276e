// SPDX-License-Identifier: Apache-2.0
#include <numeric>

#include "mtf/error.h"
#include "radiometry/atmosphere/spectral_impl.h"
#include "radiometry/light/constants.h"

namespace radiometry::atmosphere {

using mtf::UsageError;

Slice slice_of(const Interval& band) {
  const double from = 1e4 / band.hi_um, to = 1e4 / band.lo_um;
  std::size_t first = 0, last = kWavenumbers - 1;
  while (first + 1 < kWavenumbers && wavenumber_cm(first + 1) <= from * (1.0 + 1e-12)) ++first;
  while (last > first && wavenumber_cm(last - 1) >= to * (1.0 - 1e-12)) --last;
  return {first, last - first + 1};
}

void require_options(const SpectralOptions& options) {
  const auto [lo, hi] = options.band;
  if (!(lo < hi)) throw UsageError("atmosphere: a band of " + describe(options.band) + "; it has to rise");
  if (!(lo >= kShortest_um * (1.0 - 1e-12) && hi <= kLongest_um * (1.0 + 1e-12)))
    throw UsageError("atmosphere: a band of " + describe(options.band) +
                     "; the model goes from 0.4 um to 15.38 um (650 cm^-1): give a band within, or a table of the path "
                     "made elsewhere");
  if (!(options.tolerance >= 0.0 && options.tolerance < 1.0))
    throw UsageError("atmosphere: a tolerance of " + mtf::format_double(options.tolerance) +
                     "; it has to be from 0 to below 1");
}

mtf::ValueSlope planck_per_cm(double wavenumber_cm, double temperature_k) {
  constexpr double c1 = 2e8 * kPlanck_j_s * kLightSpeed_m_s * kLightSpeed_m_s;  // W m^-2 sr^-1 cm^4
  constexpr double c2 = 1e-4 * kSecondRadiation_um_k;                           // cm K
  const double x = c2 * wavenumber_cm / temperature_k, e = std::expm1(x);
  const double value = c1 * wavenumber_cm * wavenumber_cm * wavenumber_cm / e;
  return {value, value * x / temperature_k * (1.0 + 1.0 / e)};
}

WavelengthCurves curves_of(const SpectralPath<double>& path) {
  WavelengthCurves curves;
  for (std::size_t i = path.wavenumber_cm.size(); i-- > 0;) {
    const double nu = path.wavenumber_cm[i];
    curves.wavelength_um.push_back(1e4 / nu);
    curves.transmission.push_back(path.transmission[i]);
    curves.radiance.push_back(i < path.radiance.size() ? path.radiance[i] * nu * nu * 1e-4 : 0.0);
  }
  return curves;
}

Path path_of(const SpectralPath<double>& path, const std::string& source) {
  WavelengthCurves curves = curves_of(path);
  Path out;
  out.transmission =
      make_spectrum(source + ": transmission", curves.wavelength_um, std::move(curves.transmission), 1.0);
  out.radiance = make_spectrum(source + ": radiance", std::move(curves.wavelength_um), std::move(curves.radiance));
  return out;
}

namespace {

/// Where the air is outside of what the coefficients were fitted to.
std::vector<std::string> fit_limits_of(const Air<double>& air) {
  constexpr double kColdest_k = 220.0, kWarmest_k = 310.0, kMostVapour_per_cm3 = 1.5e18, kMostHumid_percent = 99.0;
  constexpr double kHeight_m = 6000.0;  // above, air is colder in every model, and has little of what absorbs
  const Level<double>*coldest = nullptr, *warmest = nullptr, *humid = nullptr, *misty = nullptr;
  const auto vapour = [](const Level<double>& z) {
    return 1e-6 * z[Gas::water] * air_per_cm3(z.pressure_pa, z.temperature_k);
  };
  for (const Level<double>& level : air.profile.levels) {
    if (level.altitude_m > kHeight_m) break;
    if (level.temperature_k < (coldest != nullptr ? coldest->temperature_k : kColdest_k)) coldest = &level;
    if (level.temperature_k > (warmest != nullptr ? warmest->temperature_k : kWarmest_k)) warmest = &level;
    if (vapour(level) > (humid != nullptr ? vapour(*humid) : kMostVapour_per_cm3)) humid = &level;
    if (misty == nullptr && level.altitude_m < 2000.0 && relative_humidity_percent(level) > kMostHumid_percent)
      misty = &level;
  }
  const auto at = [](const Level<double>& level) {
    return mtf::format_double(std::round(10.0 * level.temperature_k) / 10.0) + " K at " +
           mtf::format_double(level.altitude_m) + " m";
  };
  std::vector<std::string> limits;
  if (coldest != nullptr)
    limits.push_back("the coefficients were fitted to air of 220 to 310 K; " + at(*coldest) + " is colder");
  if (warmest != nullptr)
    limits.push_back("the coefficients were fitted to air of 220 to 310 K; " + at(*warmest) + " is warmer");
  if (humid != nullptr)
    limits.push_back("the coefficients were fitted to at most 45 g/m3 of vapour; the air of " + at(*humid) + " has " +
                     mtf::format_double(std::round(vapour(*humid) * 18.015 / 6.02214076e17)) + " g/m3");
  const HazeKind kind = air.haze.kind;
  if (misty != nullptr && air.rain_mm_h == 0.0 && kind != HazeKind::none && kind != HazeKind::advection_fog &&
      kind != HazeKind::radiation_fog)
    limits.push_back("above 99 % humidity haze has the spectrum of 99 %; the air has more at " +
                     mtf::format_double(misty->altitude_m) + " m");
  return limits;
}

/// Straight lines, which refraction bends as if the earth were larger by a sixth, end at the horizon of both ends.
std::string limit_of_level(const Horizontal<double>& sight) {
  constexpr double kUsual_m = 100e3, kBent = 7.0 / 6.0;
  const double seen_m = 2.0 * std::sqrt(2.0 * kBent * kEarthRadius_m * std::max(0.0, sight.altitude_m));
  const double range_m = sight.range_m;
  if (range_m <= std::max(kUsual_m, seen_m)) return {};
  return "a line of one altitude follows the curve of the earth; at " + mtf::format_double(sight.altitude_m) +
         " m one sees no farther than " + mtf::format_double(std::round(1e-3 * seen_m)) + " km, and this one is " +
         mtf::format_double(std::round(1e-3 * range_m)) + " km long";
}

std::string limit_of_fog(const Haze<double>& haze) {
  constexpr double kFarthest_m = 2000.0;
  const bool fog = haze.kind == HazeKind::advection_fog || haze.kind == HazeKind::radiation_fog;
  if (!fog || haze.visibility_m <= kFarthest_m) return {};
  return "in fog one sees less than 1 km, through large drops that the spectrum is made for; a visibility of " +
         mtf::format_double(1e-3 * haze.visibility_m) + " km is that of haze";
}

/// Haze thins with the altitude, whatever the visibility; at the lowest end of the line.
std::string limit_of_haze(const Air<double>& air, const std::optional<Sight<double>>& sight) {
  constexpr double kThin = 0.5;
  double lowest_m = air.profile.levels.front().altitude_m;
  if (sight)
    std::visit(
        [&](const auto& line) {
          if constexpr (requires { line.altitude_m; })
            lowest_m = line.altitude_m;
          else if constexpr (requires { line.object_altitude_m; })
            lowest_m = std::min(line.sensor_altitude_m, line.object_altitude_m);
          else if (line.zenith_rad <= 0.5 * mtf::kPi)
            lowest_m = line.sensor_altitude_m;
        },
        *sight);
  const auto sum_at = [&](double altitude_m) {
    const auto regions = aerosol_per_km(air.haze, altitude_m);
    return std::accumulate(regions.begin(), regions.end(), 0.0);
  };
  const double here = sum_at(lowest_m), ground = sum_at(0.0);
  if (air.haze.kind == HazeKind::none || here >= kThin * ground) return {};
  return "the visibility is that at the altitude of the sea, and haze thins above 1 km; at " +
         mtf::format_double(std::round(lowest_m)) + " m it takes " +
         mtf::format_double(std::round(100.0 * here / ground)) + " % as much";
}

}  // namespace

double scattering_depth(Air<double> air, const Sight<double>& sight, const Interval& band) {
  require_options({.band = band});
  if (air.haze.kind == HazeKind::none) return 0.0;
  std::array<double, kAerosolNodes> nodes{};
  for (const auto& [loss, sign] : {std::pair{AerosolLoss::extinction, 1.0}, std::pair{AerosolLoss::absorption, -1.0}}) {
    air.haze.loss = loss;
    for (const PathLayer<double>& layer : path_layers(air, sight))
      for (std::size_t k = 0; k < kAerosolNodes; ++k) nodes[k] += sign * layer.amounts.aerosol[k];
  }
  const BandModel& model = band_model();
  const Slice slice = slice_of(band);
  const auto depth = [&](std::size_t i) {
    const auto k = static_cast<std::size_t>(model.aerosol_node[i]);
    const double share = model.aerosol_share[i];
    return std::max(0.0, nodes[k] + share * (nodes[k + 1] - nodes[k]));
  };
  double sum = 0.0, width = 0.0;
  for (std::size_t i = slice.first; i + 1 < slice.first + slice.count; ++i) {
    const double step = 1e4 / wavenumber_cm(i) - 1e4 / wavenumber_cm(i + 1);
    sum += 0.5 * step * (depth(i) + depth(i + 1));
    width += step;
  }
  return sum / width;
}

std::vector<std::string> limits_of(const Air<double>& air, const Interval& band,
                                   const std::optional<Sight<double>>& sight) {
  std::vector<std::string> limits;
  if (band.lo_um < kShortestEmission_um)
    limits.push_back(
        "below 2.857 um the air has a transmission alone: neither scattered sunlight nor emission is modelled there");
  if (band.hi_um > kShortestEmission_um && band.lo_um < 5.0)
    limits.push_back("scattered sunlight is not modelled; below 5 um it matters by day");
  if (1e4 / band.lo_um - 1e4 / band.hi_um < 20.0)
    limits.push_back(
        "the band is narrower than the 20 cm^-1 that the model resolves: lines and lasers within it see another "
        "transmission");
  if (air.haze.kind == HazeKind::advection_fog || air.haze.kind == HazeKind::radiation_fog || air.rain_mm_h > 0.0)
    limits.push_back(
        "fog and rain emit as if they absorbed all that they take: scattering of thermal radiation is not modelled");
  if (air.rain_mm_h > 0.0) limits.push_back("where it rains (below 6 km) the air is taken as saturated with vapour");
  if (std::string text = limit_of_fog(air.haze); !text.empty()) limits.push_back(std::move(text));
  if (std::string text = limit_of_haze(air, sight); !text.empty()) limits.push_back(std::move(text));
  const auto* level = sight ? std::get_if<Horizontal<double>>(&*sight) : nullptr;
  if (level != nullptr)
    if (std::string text = limit_of_level(*level); !text.empty()) limits.push_back(std::move(text));
  for (std::string& text : fit_limits_of(air)) limits.push_back(std::move(text));
  return limits;
}

template SpectralPath<double> spectral_path(const Air<double>&, const Sight<double>&, const SpectralOptions&);

}  // namespace radiometry::atmosphere
