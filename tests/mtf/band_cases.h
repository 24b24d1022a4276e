// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pupils of which a band takes long to plan: the cases of test_band_plan.cpp and bench_band.

#include <array>

#include "mtf/plan/plan.h"
#include "tests/mtf/builders.h"

namespace mtf::test {

struct BandCase {
  const char* name;
  std::array<double, 3> seidel;  ///< w040, w131, w222 in waves at every wavelength
  double obscuration;
  double reference_um;  ///< 0, or the wavelength at which the waves hold: then they go with 1/wavelength
};

inline constexpr std::array<BandCase, 5> kBandCases{{{"asymmetric, obscuration 0.3", {0.25, 0.3, 0.2}, 0.3, 0.0},
                                                     {"radial, obscuration 0.3", {0.5, 0.0, 0.0}, 0.3, 0.0},
                                                     {"asymmetric, clear", {0.25, 0.3, 0.2}, 0.0, 0.0},
                                                     {"asymmetric, 0.3, waves at 10 um", {0.25, 0.3, 0.2}, 0.3, 10.0},
                                                     {"radial, 0.3, waves at 10 um", {0.5, 0.0, 0.0}, 0.3, 10.0}}};

/// f/2 with a wavefront, 12 um footprint and pitch, at 10 um or over 8 to 12 um.
inline System<double> band_case(const BandCase& c, bool band) {
  System<double> system;
  system.frame = {100.0, 12.0, 12.0, 0.01, 0, 0};
  system.optics.f_number = 2.0;
  auto wavefront = Component<double>::make("wavefront");
  const std::array names{"w040", "w131", "w222"};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (c.seidel[i] != 0.0) set(wavefront, names[i], c.seidel[i]);
  set(wavefront, "obscuration", c.obscuration);
  if (c.reference_um > 0.0) set(wavefront, "wavelength_reference", c.reference_um);
  if (c.seidel[1] != 0.0) set(wavefront, "orientation", 20.0);
  if (band)
    system.band = Band{8.0, 12.0};
  else
    system.optics.wavelength_um = 10.0;
  system.add(Stage::presample, wavefront);
  system.add(Stage::presample, footprint(12.0));
  return system;
}

/// 1024 x 1024 samples of 6 um, two a pitch.
inline Plan compile_band_case(const System<double>& system, OtfProgress progress = {}) {
  const SampleGrid scene{1024, 1024, 6.0, 6.0};
  PlanOptions options;
  options.tolerance = 1e-4;
  options.scene = SceneSummary{};
  options.threads = 1;
  options.progress = std::move(progress);
  return compile(system, scene, detector_grid(system, scene), options);
}

}  // namespace mtf::test
