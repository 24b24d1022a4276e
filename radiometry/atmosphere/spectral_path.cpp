// SPDX-License-Identifier: Apache-2.0
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

std::vector<std::string> limits_of(const Air<double>& air, const Interval& band) {
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
  return limits;
}

template SpectralPath<double> spectral_path(const Air<double>&, const Sight<double>&, const SpectralOptions&);

}  // namespace radiometry::atmosphere
