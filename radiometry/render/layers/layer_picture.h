// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures from the layers of another renderer: each pixel has the range, the finish, the temperature and, where they
// are known, the normal and the sunlight of one surface. The radiance is that of radiometry/render, by the same tables,
//   L = tau [eps B(T) + (1 - eps) (sum F_ring L_sky + F_ground L_ground + lit E_sun cos / pi)] + L_path,
// with the shares F of a plane that nothing hides (Howell, Catalog of Radiation Heat Transfer Configuration Factors,
// B-17): layers do not say what else a surface sees, so that light of other surfaces is missing. By its normal a
// surface has the emissivity of its angle, and a glossy one mirrors sky or ground (band_surfaces.h). Where no normal is
// known it is taken to face the camera, and not the sun; it is matt, with the mean of its emissivity over the
// hemisphere.

#include "radiometry/render/band_shader.h"

namespace radiometry::render {

/// All of the size of the camera's samples.
struct SurfaceLayers {
  mtf::Image range_m{};                ///< along the ray; of no account where there is no surface
  mtf::Image finish{};                 ///< its number; below 0 there is no surface
  mtf::Image temperature_k{};          ///< of no account where there is no surface
  std::vector<mtf::Image> normal{};    ///< x, y, z in axes of the scene, of any length; or none
  std::optional<mtf::Image> sunlit{};  ///< share of the surface that the sun reaches, 0 ... 1; nothing: no shadows
};

/// Depths along the optical axis to ranges along the rays: range = depth |d|, d of length 1 along the axis.
void ranges_of_depths(const Camera& camera, mtf::Image& depth);

struct LayerFrame {
  std::vector<mtf::Image> radiance{};  ///< of each band
  std::vector<double> promised{};
  std::size_t surfaces = 0;  ///< pixels that show one
  std::size_t mirrors = 0;   ///< of glossy finishes, which mirror sky or ground even where something else stood there
  std::size_t as_matt = 0;   ///< of glossy finishes and emissivities by angle that are drawn matt for want of normals
  std::size_t unlit = 0;     ///< that no sunlight falls on for want of normals, where there is a sun
  double ground_m = 0.0;     ///< height of what is seen below the horizon beyond them: of the lowest of them
};

struct LayerOptions {
  double tolerance = 5e-6;
  int rings = 9;
  int threads = 0;
};

/// `scene`: finishes, sky, ground, sun and air; its facets are not used. Throws mtf::UsageError for sizes that differ,
/// finishes that there are not, temperatures and ranges that are none (with the first pixel), layers without a surface,
/// and as require_valid_surroundings, band_nodes and AirView do.
LayerFrame render_layers(const RenderScene& scene, std::span<const RenderBand> bands, const Camera& camera,
                         const SurfaceLayers& layers, const LayerOptions& options = {});

}  // namespace radiometry::render
