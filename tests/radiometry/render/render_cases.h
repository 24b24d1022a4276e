// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small scenes and cameras for pictures.

#include <memory>

#include "../scene/scene_cases.h"
#include "radiometry/render/renderer.h"

namespace radiometry::render::test {

using scene::test::add_box, scene::test::add_face, scene::test::add_plate, scene::test::empty_mesh;

/// Facets of one mesh, all of one finish and temperature, with backs, under a black sky.
struct SmallScene {
  std::unique_ptr<scene::Rays> rays;
  RenderScene scene;
};

inline SmallScene small_scene(const scene::Mesh& mesh, double kelvin, Spectrum emissivity, double surroundings_k,
                              scene::Winding winding = scene::Winding::as_given) {
  SmallScene made{std::make_unique<scene::Rays>(scene::test::facets(mesh, winding)), {}};
  made.scene.rays = made.rays.get();
  made.scene.finish = {{"paint", std::move(emissivity)}};
  const std::size_t sides = 2 * made.rays->facets().size();
  made.scene.finish_of.assign(sides, 0);
  made.scene.temperature_k.assign(sides, static_cast<float>(kelvin));
  made.scene.sky.longwave_w_m2 = 5.670374419184429e-8 * std::pow(surroundings_k, 4);
  made.scene.ground = {0, surroundings_k};
  return made;
}

inline Spectrum grey(double emissivity) { return constant_spectrum("grey", emissivity, 1.0); }
/// Falls and rises within both bands.
inline Spectrum coloured() {
  return make_spectrum("coloured", {3.0, 3.9, 4.3, 5.0, 8.0, 9.2, 10.5, 14.0}, {.9, .7, .3, .6, .95, .6, .9, .8}, 1.0);
}

inline SpectralCamera seeing(const Interval& band, Flux flux = Flux::photons) {
  SpectralCamera camera;
  camera.band = band;
  camera.flux = flux;
  return camera;
}
/// A cooled camera, whose quantum efficiency is a curve.
inline RenderBand mwir() {
  SpectralCamera curves = seeing({3.4, 4.8});
  curves.quantum_efficiency = {make_spectrum("qe", {3.0, 3.6, 4.5, 5.2}, {.5, .8, .75, .1}, 1.0)};
  return {"mwir", curves};
}
inline RenderBand lwir() { return {"lwir", seeing({7.5, 13.5}, Flux::watts)}; }

/// width x height samples, one a pitch; `tangent` between neighbours.
inline Camera camera(const Pose& pose, std::int64_t width, std::int64_t height, double tangent) {
  return camera_of({.focal_length_mm = 10.0,
                    .pitch_x_um = 1e4 * tangent,
                    .pitch_y_um = 1e4 * tangent,
                    .columns = width,
                    .rows = height,
                    .samples_per_pitch = 1.0},
                   pose);
}

inline double blackbody(const RenderBand& band, double kelvin) {
  return scene_radiance(band.curves, {.temperature_k = kelvin}, {});
}

}  // namespace radiometry::render::test
