// SPDX-License-Identifier: Apache-2.0
#pragma once

// Band radiances of the camera equation where curves of the wavelength are given.

#include <vector>

#include "radiometry/path.h"
#include "radiometry/signal.h"

namespace radiometry {

/// Curves in the band; what is a plain number may stay in Camera and Pixel instead. No curve: 1.
struct SpectralCamera {
  Interval band;
  std::vector<Spectrum> optics;              ///< transmission of the warm optics
  std::vector<Spectrum> cold_filter;         ///< of what lies behind the cold stop
  std::vector<Spectrum> quantum_efficiency;  ///< of the detector
};

/// A surface: emissivity x Planck(temperature) + (1 - emissivity) x Planck(surroundings).
struct Surface {
  double temperature_k = 300.0;
  Spectrum emissivity = constant_spectrum("blackbody", 1.0);  ///< up to 1
  double surroundings_k = 0.0;
};

/// Temperatures of the camera, in K; at 0 nothing is emitted.
struct CameraTemperatures {
  double optics_k = 0.0;
  double stop_k = 0.0;
};

/// The scene through the path and the camera's curves; path, optics and stop likewise, each through what lies between
/// it and the detector. The stop is seen through no filter, so it counts over all wavelengths of the quantum
/// efficiency. Throws UsageError as BandResponse does, and for a negative or infinite temperature.
BandRadiances<double> band_radiances(const SpectralCamera& camera, const Surface& surface, const Path& path,
                                     const CameraTemperatures& temperatures);

/// Derivative of the scene's part by the temperature of the surface, per K.
double scene_derivative(const SpectralCamera& camera, const Surface& surface, const Path& path);

/// Photons per joule as a curve: exactly linear in the wavelength. A factor that turns watts into photons.
Spectrum photons_per_joule(const Interval& band);

}  // namespace radiometry
