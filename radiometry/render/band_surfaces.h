// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the surfaces of a scene emit and reflect in one band, whether facets show them (band_shader.h) or the layers of
// another renderer (layers/): curves at the nodes, emission by temperature, the light around, and their sum at an angle
// (angles/angular_finishes.h). Air, range and camera are those of the tables that it makes.

#include <optional>

#include "radiometry/render/angles/angular_finishes.h"

namespace radiometry::render {

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
