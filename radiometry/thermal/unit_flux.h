// SPDX-License-Identifier: Apache-2.0
#pragma once

// What units absorb, W/m2 of surface, as functions of time:
//   a [E max(0, n . s) V + F_sky D + F_ground rho_g G + H_solar] + eps [F_sky L_sky + F_ground B_ground + H_longwave]
// and the heat that the layers generate.
// a solar absorptance, eps emissivity, E direct normal, D diffuse and G global irradiance, s the direction to the sun,
// V the table of shadows (linear in time between its directions), F shares of the view. H is what arrives from other
// surfaces of the scene (patch_light.h). All but the beam is known at the nodes of the surroundings and in the middle
// between them, and is a parabola through these three in each interval.

#include "radiometry/heat/forcing.h"
#include "radiometry/thermal/patch_light.h"

namespace radiometry::thermal {

/// The direct light of an instant: direction, irradiance, and the entry of the table of shadows.
struct Beam {
  scene::Vector to_sun{};
  double irradiance_w_m2 = 0.0;  ///< 0 while the sun is down
  std::size_t entry = 0;
  double share = 0.0;
};

/// At a share of the interval after a node.
Beam beam_at(const Surroundings& surroundings, std::size_t node, double share);

/// Moments between the directions of the table of shadows, to check it at.
std::vector<scene::SunCheck> sun_checks(const Surroundings& surroundings);

/// What a side gets of the beam, W/m2.
double direct_w_m2(const UnitSide& side, const scene::SunVisibility& sun, const Beam& beam);

/// Which units a batch holds, and for which nodes their absorbed flux is tabulated.
struct ForcedUnits {
  std::vector<const Unit*> unit;
  std::size_t first = 0, last = 0;  ///< nodes
};

/// The forcing of the batch within its nodes. Where they go beyond the window of the light of patches, as when plans
/// are tried, the exchange is that of the end of the window. All references have to live as long as the forcing.
heat::GroupForcing forcing_of(ForcedUnits batch, const Units& units, const Surroundings& surroundings,
                              const GroundLight& ground, const PatchLight& light, const Material& surface,
                              double start_s);

}  // namespace radiometry::thermal
