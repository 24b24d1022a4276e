// SPDX-License-Identifier: Apache-2.0
#pragma once

// Band radiances of the camera equation where curves of the wavelength are given.

#include <vector>

#include "radiometry/light/blackbody.h"
#include "radiometry/light/path.h"
#include "radiometry/light/signal.h"

namespace radiometry {

/// Curves in the band; what is a plain number may stay in Camera and Pixel instead. No curve: 1.
struct SpectralCamera {
  Interval band;
  std::vector<Spectrum> optics;              ///< transmission of the warm optics
  std::vector<Spectrum> cold_filter;         ///< of what lies between cold stop and detector
  std::vector<Spectrum> quantum_efficiency;  ///< of the detector, or its absorptance
  /// What the detector answers to: photons, or the power of a thermal detector. All radiances are of this kind.
  Flux flux = Flux::photons;
};

/// A surface: emissivity x Planck(temperature) + (1 - emissivity) x Planck(surroundings).
struct Surface {
  double temperature_k = 300.0;
  Spectrum emissivity = constant_spectrum("blackbody", 1.0);  ///< up to 1
  double surroundings_k = 0.0;
};

/// Where the emission of the stop counts. No filter stands between stop and detector, so that a quantum efficiency
/// beyond the band gives electrons there.
enum class StopBand {
  band,     ///< in the band alone, as all other light: the same for a curve and for a number
  response  ///< over the whole of the quantum-efficiency curve
};
inline constexpr std::array<std::string_view, 2> kStopBandNames{"band", "response"};
constexpr std::span<const std::string_view> words(StopBand) { return kStopBandNames; }

/// What the camera itself emits: temperatures in K, at 0 nothing.
struct CameraEmission {
  double optics_k = 0.0;
  double stop_k = 0.0;
  StopBand stop_band = StopBand::band;
  double shutter_k = 0.0;  ///< of the shutter from which a thermal camera takes its offsets
  ShutterPlace shutter_place = ShutterPlace::detector;
};

/// The wavelengths over which the stop counts. Throws UsageError for `response` without a curve that says where the
/// response ends.
Interval stop_range(const SpectralCamera& camera, StopBand stop_band);

/// The scene through the path and the camera's curves; path, optics and stop likewise, each through what lies between
/// it and the detector. Throws UsageError as BandResponse and stop_range do, and for a temperature below 0 or
/// beyond what Planck's law is worked out for (exponent.h).
BandRadiances<double> band_radiances(const SpectralCamera& camera, const Surface& surface, const Path& path,
                                     const CameraEmission& emission);

/// BandRadiances::scene alone: temperatures are 0 or above.
double scene_radiance(const SpectralCamera& camera, const Surface& surface, const Path& path);

/// The same of the camera alone, without scene and path.
BandRadiances<double> own_radiances(const SpectralCamera& camera, const CameraEmission& emission);

/// Mean of the quantum-efficiency curves over the photons of the scene (not of the path) that arrive at the detector,
/// or over their power: what a plain number stands for. 1 without curves, NaN where the scene sends no photon.
double mean_quantum_efficiency(const SpectralCamera& camera, const Surface& surface, const Path& path);

/// The growth of the scene's part when the surface gets warmer by `warmer_k`, to a relative 1e-12.
double scene_difference(const SpectralCamera& camera, const Surface& surface, const Path& path, double warmer_k);

/// Derivative of the scene's part by the temperature of the surface, per K.
double scene_derivative(const SpectralCamera& camera, const Surface& surface, const Path& path);

/// Photons per joule as a curve: exactly linear in the wavelength. A factor that turns watts into photons.
Spectrum photons_per_joule(const Interval& band);

}  // namespace radiometry
