// SPDX-License-Identifier: Apache-2.0
#include "radiometry/spectral_signal.h"

#include <algorithm>
#include <cmath>

#include "radiometry/band_response.h"
#include "radiometry/constants.h"

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

double thermal(const Interval& band, Curves curves, const Spectrum& emissivity, double temperature_k) {
  if (temperature_k == 0.0) return 0.0;
  curves.push_back(emissivity);
  return BandResponse(band, curves).radiance(Flux::photons, temperature_k);
}

void require_temperature(const char* what, double temperature_k) {
  if (!(temperature_k >= 0.0) || !std::isfinite(temperature_k))
    throw mtf::UsageError(std::string(what) + " of " + mtf::format_double(temperature_k) +
                          " K; a temperature is 0 or above, in kelvin");
}

/// All wavelengths that the detector answers to, where curves say so, else the band.
Interval detector_band(const SpectralCamera& camera) {
  Interval own;
  for (const Spectrum& curve : camera.quantum_efficiency) {
    const Interval range = range_of(curve);
    own = {std::max(own.lo_um, range.lo_um), std::min(own.hi_um, range.hi_um)};
  }
  return own.lo_um > 0.0 && own.hi_um > own.lo_um ? own : camera.band;
}

}  // namespace

Spectrum photons_per_joule(const Interval& band) {
  return make_spectrum("photons per joule", {band.lo_um, band.hi_um},
                       {band.lo_um / kPhotonEnergy_j_um, band.hi_um / kPhotonEnergy_j_um});
}

BandRadiances<double> band_radiances(const SpectralCamera& camera, const Surface& surface, const Path& path,
                                     const CameraTemperatures& temperatures) {
  require_temperature("a surface", surface.temperature_k);
  require_temperature("surroundings", surface.surroundings_k);
  require_temperature("air", path.air_temperature_k);
  require_temperature("optics", temperatures.optics_k);
  require_temperature("a stop", temperatures.stop_k);
  BandRadiances<double> radiances;
  const Spectrum black = constant_spectrum("blackbody", 1.0);

  Curves curves = behind_aperture(camera);
  radiances.path = thermal(camera.band, curves, path.emissivity, path.air_temperature_k);
  curves.push_back(path.radiance);
  curves.push_back(photons_per_joule(camera.band));
  radiances.path += BandResponse(camera.band, curves).integral();

  curves = behind_aperture(camera);
  curves.push_back(path.transmission);
  radiances.scene = thermal(camera.band, curves, surface.emissivity, surface.temperature_k) +
                    thermal(camera.band, curves, complement(surface.emissivity), surface.surroundings_k);

  radiances.optics =
      thermal(camera.band, joined({&camera.cold_filter, &camera.quantum_efficiency}), black, temperatures.optics_k);
  radiances.stop = thermal(detector_band(camera), camera.quantum_efficiency, black, temperatures.stop_k);
  return radiances;
}

double scene_derivative(const SpectralCamera& camera, const Surface& surface, const Path& path) {
  require_temperature("a surface", surface.temperature_k);
  Curves curves = behind_aperture(camera);
  curves.push_back(path.transmission);
  curves.push_back(surface.emissivity);
  return BandResponse(camera.band, curves).derivative(Flux::photons, surface.temperature_k);
}

}  // namespace radiometry
