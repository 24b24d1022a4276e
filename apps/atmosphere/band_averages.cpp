// SPDX-License-Identifier: Apache-2.0
#include "apps/atmosphere/band_averages.h"

#include "mtf/error.h"

namespace apps {

namespace air = radiometry::atmosphere;
using radiometry::Path;
using radiometry::Surface;

namespace {

/// The curve of one component over the wavelength.
Path only(const air::SpectralPath<double>& path, std::size_t component) {
  std::vector<double> wavelength_um, value(path.component[component].rbegin(), path.component[component].rend());
  for (auto nu = path.wavenumber_cm.rbegin(); nu != path.wavenumber_cm.rend(); ++nu) wavelength_um.push_back(1e4 / *nu);
  Path result;
  result.transmission = radiometry::make_spectrum(std::string(air::kComponentNames[component]),
                                                  std::move(wavelength_um), std::move(value), 1.0);
  return result;
}

}  // namespace

BandAverage band_average(const air::SpectralPath<double>& path, const radiometry::SpectralCamera& camera,
                         double source_k) {
  const Surface surface{.temperature_k = source_k};
  const Path whole = path_of(path, "the air");
  const double clear = scene_radiance(camera, surface, {}), clear_slope = scene_derivative(camera, surface, {});
  if (!(clear > 0.0 && clear_slope > 0.0))
    throw mtf::UsageError("a blackbody of " + mtf::format_double(source_k) + " K gives nothing from " +
                          describe(camera.band) + " to weigh the air by; give a hotter --source-temperature");
  BandAverage average{.band = camera.band};
  average.transmission = scene_radiance(camera, surface, whole) / clear;
  average.contrast_transmission = scene_derivative(camera, surface, whole) / clear_slope;
  average.has_radiance = camera.band.lo_um >= air::kShortestEmission_um;
  average.radiance = band_radiances(camera, surface, whole, {}).path;
  for (std::size_t c = 0; c < air::kComponents; ++c)
    average.component[c] = scene_radiance(camera, surface, only(path, c)) / clear;
  return average;
}

}  // namespace apps
