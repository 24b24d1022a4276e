// SPDX-License-Identifier: Apache-2.0
#pragma once

// The budget of a sensor file in two steps: integrals over the band as plain numbers, then the camera equation and the
// noise in any scalar, so that studies differentiate through it.

#include "radiometry/chain.h"
#include "radiometry/sensor_numbers.h"

namespace radiometry {

/// Integrals over the band that a budget takes, all through the camera's curves.
template <class S>
struct SpectralNumbers {
  BandRadiances<S> radiances{};
  S per_k{};                ///< derivative of the scene's radiance by its temperature
  S contrast{};             ///< scene_difference of a target
  S quantum_efficiency{1};  ///< mean_quantum_efficiency

  std::array<S*, 7> all() {
    return {&radiances.scene, &radiances.path, &radiances.optics,  &radiances.stop,
            &per_k,           &contrast,       &quantum_efficiency};
  }
};

/// For a surface of that temperature and a target `warmer_k` above it, with numbers of [path], [scene] and [optics]
/// overridden; overrides that have no part in the integrals are ignored. Throws UsageError as band_radiances.
SpectralNumbers<double> spectral_numbers(const Sensor& sensor, double temperature_k, double warmer_k = 0.0,
                                         const Overrides<double>& numbers = {});

/// True for a number that only spectral_numbers reads.
bool is_spectral(std::string_view path);

/// The budget, and in it the electrons of the target. Throws UsageError as cone_sr.
template <class S>
Budget<S> sensor_budget(const mtf::System<S>& system, const SensorSettings& settings,
                        const SpectralNumbers<S>& spectral, double flicker_e, const Overrides<S>& numbers = {}) {
  const Camera<S> camera = camera_numbers(system, settings, numbers);
  Pixel<S> pixel = pixel_numbers(system, settings, numbers);
  const S gain = electrons_per_radiance(camera, pixel);
  Signal<S> electrons = signal(camera, pixel, spectral.radiances);
  if (settings.narcissus) {
    const S depth = numbers("narcissus.depth", settings.narcissus->depth);
    electrons.optics_e = electrons.optics_e * (S(1) - depth);
    electrons.stop_e = electrons.stop_e * (S(1) - depth);
  }
  const NoiseTerms<S> noise = noise_numbers(settings, pixel, flicker_e, numbers);
  pixel.quantum_efficiency = pixel.quantum_efficiency * spectral.quantum_efficiency;
  Budget<S> budget = make_budget(pixel, electrons, noise, S(gain * spectral.per_k));
  budget.contrast_e = gain * spectral.contrast;
  return budget;
}

}  // namespace radiometry
