// SPDX-License-Identifier: Apache-2.0
#pragma once

// What units absorb, W/m2 of surface, as functions of time:
//   a [E max(0, n . s) V + F_sky D + F_ground rho_g G + H_solar] + eps [F_sky L_sky + F_ground B_ground + H_longwave]
// and the heat that the layers generate.
// a solar absorptance, eps emissivity, E direct normal, D diffuse and G global irradiance, s the direction to the sun,
// V the table of shadows (linear in time between its directions), F shares of the view. H is what arrives from other
// surfaces of the scene: the radiosity of patches that reflect solar light and that emit and reflect long waves, with
// any number of reflections. H is computed at the nodes of the surroundings and is a straight line between them.

#include <span>
#include <vector>

#include "apps/scene/heat/units.h"
#include "radiometry/heat/forcing.h"

namespace apps::scene {

/// What the ground beyond the scene gives off at the nodes, W/m2: long-wave radiation emitted and reflected, and solar
/// light reflected.
struct GroundLight {
  std::vector<double> longwave_w_m2, solar_w_m2;
};

/// A table over the nodes of a window and receivers (Units::views), W/m2.
struct ReceiverTable {
  std::size_t first = 0;  ///< node of the first row
  std::size_t receivers = 0;
  std::vector<float> value;  ///< [(node - first) * receivers + receiver]

  std::size_t nodes() const { return receivers == 0 ? 0 : value.size() / receivers; }
  std::span<float> row(std::size_t node) { return std::span(value).subspan((node - first) * receivers, receivers); }
  std::span<const float> row(std::size_t node) const {
    return std::span(value).subspan((node - first) * receivers, receivers);
  }
};
ReceiverTable make_receiver_table(std::size_t first, std::size_t last, std::size_t receivers);

/// Solar irradiance by other surfaces, at the nodes of the table.
void fill_solar_exchange(const Units& units, const Surroundings& surroundings, const GroundLight& ground, int threads,
                         ReceiverTable& irradiance);

/// Long-wave irradiance of receivers by other surfaces at one node, from the temperatures of units, front and back as
/// receivers have them.
void longwave_exchange(const Units& units, const Surroundings& surroundings, const GroundLight& ground,
                       std::size_t node, std::span<const double> receiver_k, std::span<float> irradiance);

/// The absorbed flux of units first, first + 1, ... of a batch, and what drives them otherwise, within the window that
/// the tables hold. All references have to live as long as the forcing.
radiometry::heat::Forcing forcing_of(std::span<const Unit> batch, const Units& units, const Surroundings& surroundings,
                                     const GroundLight& ground, const ReceiverTable& solar,
                                     const ReceiverTable& longwave, const radiometry::heat::Schedule& inside,
                                     double start_s);

}  // namespace apps::scene
