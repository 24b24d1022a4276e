// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/spectral_signal.h"

#include <algorithm>
#include <cmath>

#include "mtf/math/quadrature.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/constants.h"
#include "radiometry/light/exponent.h"

namespace radiometry {
namespace {

using Curves = std::vector<Spectrum>;

Curves joined(std::initializer_list<const Curves*> lists) {
  Curves all;
  for (const Curves* list : lists) all.insert(all.end(), list->begin(), list->end());
  return all;
}

Curves behind_aperture(const SpectralCamera& camera) {
  return joined({&camera.optics, &camera.cold_filter, &camera.quantum_efficiency});
}

double thermal(Flux flux, const Interval& band, Curves curves, const Spectrum& emissivity, double temperature_k) {
  if (temperature_k == 0.0) return 0.0;
  curves.push_back(emissivity);
  return BandResponse(band, curves).radiance(flux, temperature_k);
}

void require_temperature(const char* what, double temperature_k) {
  if (!(temperature_k >= 0.0 && temperature_k <= kHottest_k))
    throw mtf::UsageError(std::string(what) + " of " + mtf::format_double(temperature_k) +
                          " K; a temperature is from 0 K to " + mtf::format_double(kHottest_k) + " K");
}

Curves scene_curves(const SpectralCamera& camera, const Path& path) {
  Curves curves = behind_aperture(camera);
  curves.push_back(path.transmission);
  return curves;
}

}  // namespace

Spectrum photons_per_joule(const Interval& band) {
  return make_spectrum("photons per joule", {band.lo_um, band.hi_um},
                       {band.lo_um / kPhotonEnergy_j_um, band.hi_um / kPhotonEnergy_j_um});
}

Interval stop_range(const SpectralCamera& camera, StopBand stop_band) {
  if (stop_band == StopBand::band) return camera.band;
  Interval own{0.0, mtf::kInfinity};
  for (const Spectrum& curve : camera.quantum_efficiency) {
    const Interval range = range_of(curve);
    own = {std::max(own.lo_um, range.lo_um), std::min(own.hi_um, range.hi_um)};
  }
  if (!(own.lo_um > 0.0 && std::isfinite(own.hi_um)))
    throw mtf::UsageError("optics.stop_band = \"response\": needs detector." +
                          std::string(camera.flux == Flux::watts ? "absorptance" : "quantum_efficiency") +
                          " as a CSV file; a number does not say where the response ends");
  return own;
}

double scene_radiance(const SpectralCamera& camera, const Surface& surface, const Path& path) {
  const Curves curves = scene_curves(camera, path);
  return thermal(camera.flux, camera.band, curves, surface.emissivity, surface.temperature_k) +
         thermal(camera.flux, camera.band, curves, complement(surface.emissivity), surface.surroundings_k);
}

BandRadiances<double> band_radiances(const SpectralCamera& camera, const Surface& surface, const Path& path,
                                     const CameraEmission& emission) {
  require_temperature("a surface", surface.temperature_k);
  require_temperature("surroundings", surface.surroundings_k);
  require_temperature("air", path.air_temperature_k);
  BandRadiances<double> radiances = own_radiances(camera, emission);
  Curves curves = behind_aperture(camera);
  radiances.path = thermal(camera.flux, camera.band, curves, path.emissivity, path.air_temperature_k);
  curves.push_back(path.radiance);
  if (camera.flux == Flux::photons) curves.push_back(photons_per_joule(camera.band));
  radiances.path += BandResponse(camera.band, curves).integral();

  radiances.scene = scene_radiance(camera, surface, path);
  return radiances;
}

BandRadiances<double> own_radiances(const SpectralCamera& camera, const CameraEmission& emission) {
  require_temperature("optics", emission.optics_k);
  require_temperature("a stop", emission.stop_k);
  require_temperature("a shutter", emission.shutter_k);
  BandRadiances<double> radiances;
  const Spectrum black = constant_spectrum("blackbody", 1.0);
  const Curves behind_optics = joined({&camera.cold_filter, &camera.quantum_efficiency});
  radiances.optics = thermal(camera.flux, camera.band, behind_optics, black, emission.optics_k);
  const bool before_optics = emission.shutter_place == ShutterPlace::optics;
  radiances.shutter = thermal(camera.flux, camera.band, before_optics ? behind_aperture(camera) : behind_optics, black,
                              emission.shutter_k);
  const auto around = [&](double temperature_k) {
    return thermal(camera.flux, stop_range(camera, emission.stop_band), camera.quantum_efficiency, black,
                   temperature_k);
  };
  radiances.stop = around(emission.stop_k);
  radiances.shutter_around = around(emission.shutter_k);
  return radiances;
}

double mean_quantum_efficiency(const SpectralCamera& camera, const Surface& surface, const Path& path) {
  if (camera.quantum_efficiency.empty()) return 1.0;
  SpectralCamera counting = camera;  // all light
  counting.quantum_efficiency.clear();
  return scene_radiance(camera, surface, path) / scene_radiance(counting, surface, path);
}

double scene_difference(const SpectralCamera& camera, const Surface& surface, const Path& path, double warmer_k) {
  const double from_k = surface.temperature_k, to_k = from_k + warmer_k;
  require_temperature("a surface", from_k);
  require_temperature("a warmer surface", to_k);
  Curves curves = scene_curves(camera, path);
  curves.push_back(surface.emissivity);
  const BandResponse response(camera.band, curves);
  const double from = response.radiance(camera.flux, from_k), to = response.radiance(camera.flux, to_k);
  if (!(std::abs(to - from) < 1e-3 * from)) return to - from;
  // The warming is so small that a difference would lose digits. It is the mean slope instead, which three nodes give
  // to all digits.
  const mtf::GaussRule rule = mtf::mean_rule(from_k, to_k, 3);
  double slope = 0.0;
  for (std::size_t i = 0; i < rule.node.size(); ++i)
    slope += rule.weight[i] * response.derivative(camera.flux, rule.node[i]);
  return warmer_k * slope;
}

double scene_derivative(const SpectralCamera& camera, const Surface& surface, const Path& path) {
  require_temperature("a surface", surface.temperature_k);
  Curves curves = scene_curves(camera, path);
  curves.push_back(surface.emissivity);
  return BandResponse(camera.band, curves).derivative(camera.flux, surface.temperature_k);
}

}  // namespace radiometry
