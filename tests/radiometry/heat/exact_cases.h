// SPDX-License-Identifier: Apache-2.0
#pragma once

// Facets whose temperature is known in closed form.

#include <string>
#include <vector>

#include "radiometry/heat/solve.h"

namespace radiometry::heat::test {

/// What a facet is exposed to when nothing but a sinusoidal flux changes with time.
struct SteadyForcing {
  double absorbed_w_m2 = 0.0, air_k = 300.0, inside = 300.0;
  double amplitude_w_m2 = 0.0, period_s = 86400.0;  ///< + amplitude cos(2 pi t / period)
  double back_w_m2 = 0.0;

  void operator()(Instant at, std::size_t first, ForcingValues& values) const;
};

struct ExactCase {
  std::string name;
  Construction construction;
  SteadyForcing forcing;
  Start start;
  std::vector<double> outputs_s;
  std::vector<double> front_k;  ///< at the outputs
  std::vector<double> back_k;   ///< of sheets, or empty
  double scale_k = 0.0;         ///< errors are relative to this difference of temperatures
  double form_k = 0.0;          ///< what the closed form leaves out
};

/// A slab with a film on one side, adiabatic on the other, cooling from a uniform temperature.
std::vector<ExactCase> slabs();
/// A sinusoidal flux above layers with linear films.
std::vector<ExactCase> periodic_layers();
/// Flux and film on a half-space from a uniform temperature.
std::vector<ExactCase> half_spaces();
/// Radiation alone on a foil.
std::vector<ExactCase> foils();
/// What a surface tends to.
std::vector<ExactCase> equilibria();

}  // namespace radiometry::heat::test
