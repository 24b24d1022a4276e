// SPDX-License-Identifier: Apache-2.0
#pragma once

// What surfaces reflect, by wavelength: the radiance of the rings of the sky, of the ground beyond the scene, of
// patches, and the sun. A diffuse side of emissivity eps with the shares F of its view (scene/views.h) reflects
//   (1 - eps) [sum over rings F L_sky + F_ground L_ground + sum over patches F_j J_j + E_sun max(0, n . s) V / pi]
//   J_j = eps_j B(T_j) + (1 - eps_j) [the same bracket of patch j, without the sun]
// The J follow by iteration from B(T_j), at each node of the band; shares sum to 1, so that in an isothermal scene they
// are B from the start. The ground sees the whole sky. The sunlight that patches pass on is left out.
//
// Sun: Planck's law at 5772 K, scaled to the irradiance that the weather has at all wavelengths; with layered air it
// has that air's transmission to space, and the scale is that of its mean over 0.4 to 15.4 um.

#include "radiometry/render/band_nodes.h"
#include "radiometry/render/path_grid.h"
#include "radiometry/render/render_scene.h"
#include "radiometry/scene/views.h"

namespace radiometry::render {

/// Sets of sides of one mesh, fronts or backs, of one finish and nearly one temperature. What a side reflects of other
/// surfaces is known by patch: each has one radiance, the mean of its sides. Steps of temperature are 1 K, or as much
/// more as makes patches few.
struct Patches {
  std::vector<std::uint32_t> patch_of{};  ///< of each side; kNone for the inside of solids
  scene::Receivers sides{};               ///< of each patch
  std::vector<std::uint32_t> finish{};    ///< of each patch
  double step_k = 0.0;

  std::size_t size() const { return finish.size(); }
};

/// At most `most` patches, or one for each finish where these are more. Sides without a temperature belong to none.
Patches patches_by_temperature(const RenderScene& scene, std::size_t most = 300);

/// Whether patches made of other temperatures still do: sides are within `step_k`, or 2 K, of the mean of their patch,
/// nearly all of them.
bool still_alike(const RenderScene& scene, const Patches& patches);

/// The mean temperature of each patch, by area.
std::vector<double> patch_temperatures_k(const RenderScene& scene, const Patches& patches);

/// Radiances at the nodes of a band: rings of the sky, from the zenith on, then the ground, then patches.
struct LightSources {
  int rings = 0;
  std::vector<std::vector<double>> radiance{};
  std::size_t first_elevation = 0;       ///< of the sky by elevation, for mirrors; 0: not wanted
  std::vector<double> sun_irradiance{};  ///< at the nodes, on a plane that faces it; empty without a sun
  double change = 0.0;                   ///< of the last iteration, relative

  std::size_t ground() const { return static_cast<std::size_t>(rings); }
  std::size_t patch(std::size_t p) const { return static_cast<std::size_t>(rings) + 1 + p; }
};

/// `emissivity`: of each finish at the nodes. `views`: a row for each patch, with its shares of patches; without rows
/// there are no patches, for scenes that reflect nothing. `sky`: the air above the scene, from the ground; null without
/// layered air.
LightSources light_sources(const RenderScene& scene, const BandNodes& nodes,
                           std::span<const std::vector<double>> emissivity, const Patches& patches,
                           std::span<const double> patch_k, const scene::Views& views, const AirView* sky);

/// The share of the sunlight from 0.4 to 15.4 um that comes through layered air to that altitude.
double sunlight_passed(const atmosphere::Air<double>& air, double altitude_m, double zenith_rad);

/// The radiance of the sky at the nodes, at a zenith angle below a right angle.
std::vector<double> sky_at(const Sky& sky, const BandNodes& nodes, const AirView* air, double zenith_rad);

}  // namespace radiometry::render
