// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the surfaces of a scene emit and reflect in one band, whether facets show them (band_shader.h) or the layers of
// another renderer (layers/): curves at the nodes, emission by temperature, the light around, and their sum at an
// angle. Air, range and camera are those of the tables that it makes.
//
// Where the emissivity depends on the angle, or a surface is glossy: with eps that along the normal, g the factor at
// this angle, s the gloss, L the diffuse light of the side and L' what a mirror shows,
//   (1 - eps g) = g (1 - eps) + (1 - g)
//   radiance = g [eps B + (1 - s)(1 - eps) L + s (1 - eps) L'] + (1 - g) [(1 - s) L + s L'],
// sums of the tables of the finish and of a white one (eps = 0) at every wavelength: in an isothermal scene all is B,
// whatever g and s. The sun is part of L (a point, which no mirror ray meets). A mirror shows a side j as
//   L' = J of its patch + eps_h (B(T_j) - B(T_patch)) + (1 - eps_h) E_sun cos V / pi,   eps_h its mean by hemisphere,
// so that tables of the products (1 - eps) eps_h and (1 - eps)(1 - eps_h) are made for each glossy finish with each
// other, and for white; and sky and ground as they are seen from the ground, without the air between.

#include <optional>
#include <span>

#include "radiometry/render/band_tables.h"
#include "radiometry/render/render_scene.h"

namespace radiometry::render {

/// Finishes that are made for angles, beside those of the scene: nothing where no finish depends on the angle or is
/// glossy; white alone unless mirrors show sides.
struct AngularFinishes {
  std::vector<MadeFinish> made{};     ///< white; then, of glossy finishes and last of white, one for each finish
  std::vector<std::uint32_t> like{};  ///< of each: the finish whose temperatures it has; kNone for white
  std::vector<std::size_t> row{};     ///< of each finish: which of the glossy ones, made.size() for others
  std::size_t finishes = 0;

  std::size_t white() const { return finishes; }
  /// The table of `seen` in a mirror of `finish`, or a white one.
  std::size_t mirrored(std::size_t finish, std::size_t seen) const {
    return finishes + 1 + row[finish] * finishes + seen;
  }
  std::size_t mirrored_in_white(std::size_t seen) const { return finishes + (made.size() - finishes) + seen; }
};

/// What a mirror shows: a side of the scene, or sky or ground.
struct InMirror {
  double rise = 0.0;                    ///< sine of the elevation of the mirrored ray
  std::uint32_t finish = scene::kNone;  ///< of the side; kNone: sky or ground, and nothing below counts
  std::uint32_t patch = 0;
  double temperature_k = 0.0;
  double sun = 0.0;  ///< share of the side in the sun, times its cosine
};

/// How a surface is seen whose radiance depends on the angle.
struct SeenAt {
  double relative = 1.0;  ///< emissivity there over that along the normal
  double gloss = 0.0;
  double sun = 0.0;  ///< share of it in the sun, times its cosine
  InMirror mirror{};
};

/// What it has at any angle, at the six nodes of a cell; `white`: the diffuse light of a white surface in its place.
struct SurfaceLight {
  SixValues emitted{}, diffuse{}, white{};
};

struct BandSurfaces {
  /// `views`: of patches; without rows there are no patches, and mirrors show sky and ground alone. `range`: of
  /// temperatures, by finish. `ground_m`: the height that the sky is seen from. Throws mtf::UsageError as band_nodes
  /// and AirView do.
  BandSurfaces(const SpectralCamera& camera, const RenderScene& scene, const Patches& patches,
               const scene::Views& views, std::vector<KelvinRange> range, double ground_m);

  /// Emission for other temperatures.
  void cover(std::vector<KelvinRange> range);
  /// `view`: null without air.
  BandTables tables(const PathGrid& grid, const AirView* view) const;

  /// `of`: sources and their shares.
  template <class Light>
  SurfaceLight light(const BandTables& tables, std::size_t node, std::size_t finish, double temperature_k,
                     const Light& of) const {
    SurfaceLight out{.emitted = tables.emitted(finish, temperature_k, node)};
    tables.add_light(finish, of, node, out.diffuse);
    tables.add_light(angular.white(), of, node, out.white);
    return out;
  }
  /// The radiance of a finish with has_angles, and of the air before it.
  SixValues seen(const BandTables& tables, std::size_t node, std::size_t finish, const SurfaceLight& light,
                 const SeenAt& at) const;

  std::vector<Spectrum> curves{};  ///< emissivities
  BandNodes nodes{};
  std::vector<std::vector<double>> emissivity{};  ///< at the nodes
  AngularFinishes angular{};
  std::vector<std::vector<double>> emits{};  ///< emissivity, and that of what was made of it for angles
  std::vector<KelvinRange> range{};
  std::optional<EmissionFolds> folds{};
  std::vector<double> patch_k{};
  LightSources sources{};
};

}  // namespace radiometry::render
