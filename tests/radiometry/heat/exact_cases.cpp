// SPDX-License-Identifier: Apache-2.0
#include "tests/radiometry/heat/exact_cases.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "radiometry/light/constants.h"

namespace radiometry::heat::test {
namespace {

constexpr double kDay_s = 86400.0;

Layer layer(double conductivity, double density, double heat, double thickness) {
  return {conductivity, density, heat, thickness};
}

/// 30-digit values of the eigenfunction series (Carslaw & Jaeger, 3.11).
ExactCase slab(double biot, double fourier, double surface) {
  // k = 1, rho c = 1e6, L = 0.1: h = 10 Bi, t = 1e4 Fo.
  return {.name = "slab of Bi " + std::to_string(biot) + " at Fo " + std::to_string(fourier),
          .construction = {.layers = {layer(1.0, 1000.0, 1000.0, 0.1)},
                           .emissivity = 0.0,
                           .convection = LinearConvection{10.0 * biot, 0.0},
                           .inside = Adiabatic{}},
          .forcing = {.air_k = 300.0},
          .start = UniformStart{400.0},
          .outputs_s = {1e4 * fourier},
          .front_k = {300.0 + 100.0 * surface},
          .back_k = {},
          .scale_k = 100.0};
}

struct Periodic {
  const char* name;
  std::vector<Layer> layers;
  double outer_film, inner_film, period_s, amplitude_k, lag_deg;
};

ExactCase periodic(const Periodic& of) {
  ExactCase made{.name = of.name,
                 .construction = {.layers = of.layers,
                                  .emissivity = 0.0,
                                  .convection = LinearConvection{of.outer_film, 0.0},
                                  .inside = Adiabatic{}},
                 .forcing = {.amplitude_w_m2 = 300.0, .period_s = of.period_s},
                 .start = RepeatingStart{of.period_s},
                 .outputs_s = {},
                 .front_k = {},
                 .back_k = {},
                 .scale_k = of.amplitude_k};
  if (of.inner_film > 0.0) made.construction.inside = InnerFilm{of.inner_film};
  for (int i = 0; i <= 24; ++i) {
    made.outputs_s.push_back(of.period_s * i / 24.0);
    made.front_k.push_back(
        300.0 + of.amplitude_k * std::cos(2.0 * std::numbers::pi * i / 24.0 - of.lag_deg * std::numbers::pi / 180.0));
  }
  return made;
}

/// Thick enough that the other side is not felt: 9 sqrt(alpha t).
ExactCase half_space(std::string name, Layer material, double flux, double film, double air_k, double start_k,
                     double time_s, double front_k) {
  material.thickness_m = 9.0 * std::sqrt(material.diffusivity() * time_s);
  return {.name = std::move(name),
          .construction = {.layers = {material},
                           .emissivity = 0.0,
                           .convection = LinearConvection{film, 0.0},
                           .inside = Adiabatic{}},
          .forcing = {.absorbed_w_m2 = flux, .air_k = air_k},
          .start = UniformStart{start_k},
          .outputs_s = {time_s},
          .front_k = {front_k},
          .back_k = {},
          .scale_k = std::abs(front_k - start_k)};
}

ExactCase foil(const char* name, Layer metal, double emissivity, double sink_k, double start_k, double end_k,
               double time_s) {
  return {.name = name,
          .construction = {.layers = {metal},
                           .emissivity = emissivity,
                           .convection = NoConvection{},
                           .inside = Adiabatic{}},
          .forcing = {.absorbed_w_m2 = emissivity * kStefanBoltzmann_w_m2_k4 * std::pow(sink_k, 4)},
          .start = UniformStart{start_k},
          .outputs_s = {time_s},
          .front_k = {end_k},
          .back_k = {},
          .scale_k = std::abs(start_k - end_k),
          // The closed form has one temperature through the depth; the surface is colder than the mean by q L / (3 k).
          .form_k = emissivity * kStefanBoltzmann_w_m2_k4 * std::abs(std::pow(end_k, 4) - std::pow(sink_k, 4)) *
                    metal.thickness_m / (3.0 * metal.conductivity_w_m_k)};
}

ExactCase equilibrium(double absorptance, double sun, double emissivity, double sky, double film, double air_k,
                      double end_k) {
  return {.name = "equilibrium at " + std::to_string(end_k) + " K",
          .construction = {.layers = {layer(45.0, 7800.0, 480.0, 1e-3)},
                           .emissivity = emissivity,
                           .convection = LinearConvection{film, 0.0},
                           .inside = Adiabatic{}},
          .forcing = {.absorbed_w_m2 = absorptance * sun + emissivity * sky, .air_k = air_k},
          .start = UniformStart{300.0},
          .outputs_s = {kDay_s},
          .front_k = {end_k},
          .back_k = {},
          .scale_k = end_k};
}

}  // namespace

void SteadyForcing::operator()(Instant at, std::size_t, ForcingValues& values) const {
  const double flux = absorbed_w_m2 + amplitude_w_m2 * std::cos(2.0 * std::numbers::pi * at.time_s / period_s);
  std::fill(values.front.absorbed_w_m2.begin(), values.front.absorbed_w_m2.end(), flux);
  std::fill(values.back.absorbed_w_m2.begin(), values.back.absorbed_w_m2.end(), back_w_m2);
  values.front.air_k = values.back.air_k = air_k;
  values.inside = inside;
}

std::vector<ExactCase> slabs() {
  return {slab(0.01, 10.0, 0.9021271853), slab(1.0, 0.2, 0.6433907845), slab(1.0, 1.0, 0.3481768517),
          slab(100.0, 0.05, 0.02520616914)};
}

std::vector<ExactCase> periodic_layers() {
  const Layer steel = layer(45.0, 7800.0, 480.0, 1e-3), air = layer(0.025, 1.2, 1005.0, 0.01);
  const Layer concrete = layer(1.5, 2300.0, 880.0, 0.2);
  const Periodic cases[] = {{"concrete", {concrete}, 15, 8, kDay_s, 10.87350807, 24.31227072},
                            {"plaster, foam, concrete",
                             {layer(0.7, 1800.0, 840.0, 0.015), layer(0.035, 30.0, 1400.0, 0.1), concrete},
                             20,
                             8,
                             kDay_s,
                             14.67177678,
                             4.891043888},
                            {"steel, air, steel", {steel, air, steel}, 20, 8, kDay_s, 13.69431675, 0.7534277198},
                            {"foil on foam",
                             {layer(200.0, 2700.0, 900.0, 1e-4), layer(0.03, 40.0, 1400.0, 0.05)},
                             20,
                             8,
                             kDay_s,
                             14.59126904,
                             0.2523116445},
                            {"rock", {layer(2.5, 2600.0, 800.0, 1.0)}, 20, 0, kDay_s, 8.231717012, 22.16586856},
                            {"regolith", {layer(1e-3, 1300.0, 600.0, 0.3)}, 4, 0, kDay_s, 71.91123951, 2.313564139},
                            {"steel, 10 min", {steel}, 20, 2, 600.0, 6.672344566, 60.68856288}};
  std::vector<ExactCase> made;
  for (const Periodic& one : cases) made.push_back(periodic(one));
  return made;
}

std::vector<ExactCase> half_spaces() {
  const Layer concrete = layer(1.5, 2300.0, 880.0, 0.0);
  const double alpha = concrete.diffusivity(), hour = 3600.0;
  const double x = 15.0 * std::sqrt(alpha * hour) / 1.5;
  return {half_space("half-space of k 1e-3", layer(1e-3, 1300.0, 600.0, 0.0), 500, 4, 300, 300, 3600, 416.847725612),
          half_space("half-space of k 400", layer(400, 8960, 385, 0), 500, 20, 300, 300, 3600, 300.885831900921),
          half_space("half-space of k 2.5", layer(2.5, 2600, 800, 0), 500, 20, 300, 300, 600, 305.06944180798),
          half_space("half-space without film", concrete, 500, 0, 300, 300, hour,
                     300.0 + 2.0 * 500.0 * std::sqrt(alpha * hour / std::numbers::pi) / 1.5),
          half_space("half-space in warm air", concrete, 0, 15, 320, 300, hour,
                     300.0 + 20.0 * (1.0 - std::exp(x * x) * std::erfc(x)))};
}

std::vector<ExactCase> foils() {
  return {foil("foil of aluminium, 600 to 350 K", layer(237.0, 2700.0, 900.0, 1e-4), 0.1, 300, 600, 350, 387.426695026),
          foil("aluminium, 300 to 200 K", layer(237.0, 2700.0, 900.0, 1e-3), 0.8, 0, 300, 200, 1570.66347685)};
}

std::vector<ExactCase> equilibria() {
  return {equilibrium(.7, 900, .9, 300, 10, 293.15, 325.712777538),
          equilibrium(.2, 1000, .1, 300, 5, 293.15, 326.294710366), equilibrium(.9, 1361, .9, 0, 0, 0, 393.605897671),
          equilibrium(0, 0, .9, 250, 0, 0, 257.680804676), equilibrium(0, 0, .95, 230, 5, 273.15, 264.287782050)};
}

}  // namespace radiometry::heat::test
