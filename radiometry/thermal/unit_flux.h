// SPDX-License-Identifier: Apache-2.0
#pragma once

// What units absorb, W/m2 of surface, as functions of time:
//   a [E max(0, n . s) V + F_sky D + F_ground rho_g G + H_solar] + eps [F_sky L_sky + F_ground B_ground + H_longwave]
// and the heat that the layers generate.
// a solar absorptance, eps emissivity, E direct normal, D diffuse and G global irradiance, s the direction to the sun,
// V the table of shadows (linear in time between its directions), F shares of the view. H is what arrives from other
// surfaces of the scene (PatchLight). All but the beam is known at the nodes of the surroundings and in the middle
// between them, and is a parabola through these three in each interval.

#include <span>
#include <vector>

#include "radiometry/heat/forcing.h"
#include "radiometry/thermal/facet_units.h"

namespace radiometry::thermal {

// What surfaces get from other surfaces of the scene: the radiosity of patches that reflect solar light, and that emit
// and reflect long waves, with any number of reflections (radiometry/scene/exchange.h). It is known at moments: the
// nodes of the surroundings and the middle between each two of them.

/// What the ground beyond the scene gives off at the nodes, W/m2: long-wave radiation emitted and reflected, and solar
/// light reflected.
struct GroundLight {
  std::vector<double> longwave_w_m2, solar_w_m2;
};

/// Radiosity of patches at moments, in single precision as differences from a reference that all patches share.
struct PatchTable {
  std::size_t moments = 0;
  std::vector<double> reference_w_m2;  ///< of each moment
  std::vector<float> radiosity;        ///< [patch * moments + moment]
  std::vector<float> shift;            ///< the same: what a receiver of the patch gets besides, so that no heat is lost

  /// What a receiver gets at all moments, W/m2, without its share of the reference.
  void irradiance(const Units& units, std::size_t receiver, std::vector<float>& all) const;
  /// The share of the view of a receiver that is patches.
  static double share(const Units& units, std::size_t receiver);
};

/// Over the nodes [first, last].
struct PatchLight {
  std::size_t first = 0, last = 0;
  PatchTable solar, longwave;

  std::size_t moments() const { return 2 * (last - first) + 1; }
  /// The place in the tables of a moment that counts from the first node of all, or of the end that is nearest.
  std::size_t moment_of(std::size_t moment) const;
};
/// All dark, with room for as many patches as the units have.
PatchLight make_patch_light(const Units& units, std::size_t first, std::size_t last);

/// Means over the receivers of each patch, by area.
struct PatchMeans {
  std::vector<double> sky, ground;  ///< shares of the view
  std::vector<double> solar_reflectance, long_reflectance;
  scene::SparseRows seen;  ///< of patches, as sampled
};
PatchMeans patch_means(const Units& units);

/// What all functions below look at.
struct PatchScene {
  const Units* units;
  const PatchMeans* means;
  const Surroundings* surroundings;
  const GroundLight* ground;
  int threads;
};

void fill_solar(const PatchScene& scene, PatchLight& light);

/// From what patches emit, W/m2, [moment * patches + patch].
void fill_longwave(const PatchScene& scene, std::span<const double> emitted, PatchLight& light);

/// Of some receivers, the largest difference of what each gets between two tables, W/m2, at the place of the receiver
/// in a list of all; 0 for others.
std::vector<double> changes(const PatchScene& scene, const PatchTable& before, const PatchTable& after,
                            std::span<const std::uint32_t> receivers);

/// The largest of these.
double largest_change(const PatchScene& scene, const PatchTable& before, const PatchTable& after,
                      std::span<const std::uint32_t> receivers);

/// What parabolas through the moments of each interval are off by: from the change of the second derivative from
/// interval to interval, the smaller one at both ends, since a bend at a node is no error. A cubic with the third
/// derivative f''' is off by at most f''' h^3 / (72 sqrt(3)). Jumps of the light, which last a second, are left out.
/// The largest of some receivers, for both tables.
double parabola_error(const PatchScene& scene, const PatchLight& light, std::span<const std::uint32_t> receivers);

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
