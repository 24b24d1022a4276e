// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a picture is made of: facets with a finish and a temperature on each side, and what surrounds them.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "radiometry/atmosphere/air.h"
#include "radiometry/light/angular_emissivity.h"
#include "radiometry/light/spectrum.h"
#include "radiometry/scene/rays.h"

namespace radiometry::render {

/// An opaque surface that reflects what it does not emit: diffusely, but for the share `gloss` of it, which is what a
/// mirror in its place shows.
struct Finish {
  std::string name{};
  Spectrum emissivity{};         ///< held beyond its ends; along the normal where it depends on the angle
  AngularEmissivity by_angle{};  ///< relative to that
  double gloss = 0.0;            ///< 0 ... 1
};

/// The sky. Where the scene has layered air it is the clear sky of that air, (1 - cloud_cover) of it, and clouds that
/// radiate as a blackbody; otherwise a blackbody that gives a level surface this irradiance at all wavelengths.
struct Sky {
  double longwave_w_m2 = 0.0;
  double cloud_cover = 0.0, cloud_k = 0.0;
};

/// What is seen below the horizon, beyond the facets: level, and as low as the lowest of them (Facets::lowest_m).
struct GroundSurface {
  std::uint32_t finish = 0;
  double temperature_k = 300.0;
};

struct Sun {
  scene::Vector to_sun{};    ///< z above 0
  double direct_w_m2 = 0.0;  ///< on a plane that faces it, all wavelengths
};
inline constexpr double kSun_k = 5772.0;  ///< IAU 2015 Resolution B3

/// Whether both are missing or stand in the same direction: then they reach the same sides.
inline bool same_direction(const std::optional<Sun>& a, const std::optional<Sun>& b) {
  return a ? b && a->to_sun == b->to_sun : !b;
}

struct RenderScene {
  const scene::Rays* rays = nullptr;  ///< outlives what is made of it
  std::vector<Finish> finish{};
  std::vector<std::uint32_t> finish_of{};  ///< of each side: scene::index(side)
  std::vector<float> temperature_k{};      ///< of each side; NaN for the inside of solids
  Sky sky{};
  GroundSurface ground{};
  std::optional<Sun> sun{};
  std::optional<atmosphere::Air<double>> air{};  ///< nothing: pictures are of surfaces, and the path is in none of them
  double altitude_m = 0.0;                       ///< of height 0, above the sea

  const scene::Facets& facets() const { return rays->facets(); }
};

/// Throws mtf::UsageError for sizes that do not fit each other, and for temperatures, emissivities and fluxes that are
/// none: with the number of sides and the first of them.
void require_valid(const RenderScene& scene);
/// The same of all but the facets: finishes, ground, sky and sun.
void require_valid_surroundings(const RenderScene& scene);

/// Throws mtf::UsageError for a camera in a solid, whose inside has no temperature: with the mesh and the facet.
void require_outside(const RenderScene& scene, const scene::Point& camera);

}  // namespace radiometry::render
