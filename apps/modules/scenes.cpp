// SPDX-License-Identifier: Apache-2.0

// The module of 3-D scenes.

#include "apps/modules/modules.h"
#include "apps/scene/command/picture_options.h"
#include "apps/scene/scene_file/clear_sky_flux.h"
#include "apps/scene/scene_file/demo_scene_text.h"
#include "apps/scene/scene_file/scene_file.h"
#include "apps/schema/schemas.h"
#include "apps/terminal/output.h"
#include "mtf/error.h"
#include "mtf/version.h"

namespace apps {
namespace {

/// The air of a scene, seen from its camera or, without one, from its place.
SceneAir scene_air(const std::string& file, const Global& global) {
  std::vector<mtf::io::Diagnostic> warnings;
  const scene::SceneFile scene = scene::load_scene(file, &warnings);
  for (const mtf::io::Diagnostic& warning : warnings) note(global, one_line(mtf::io::format_diagnostic(warning, file)));
  if (!scene.atmosphere)
    throw mtf::UsageError(file + ": has no [atmosphere]; add one (mtf config kinds atmosphere), or say all by options");
  SceneAir air{.settings = *scene.atmosphere, .place_m = scene.place.altitude_m, .files = files_of(scene)};
  air.settings.sensor_altitude_m = scene.place.altitude_m + (scene.camera ? scene.camera->position_m[2] : 0.0);
  return air;
}

}  // namespace

extern "C" const void* mtfkit_scenes_table() {
  static constexpr ScenesModule table{.build = {mtf::version, mtf::git_commit},
                                      .scene = run_scene,
                                      .heat = run_heat,
#ifdef MTFKIT_HAVE_CALIB
                                      .heat_fit = run_heat_fit,
#else
                                      .heat_fit = nullptr,
#endif
                                      .render = run_render,
                                      .fly = run_fly,
                                      .bench_heat = run_bench_heat,
                                      .bench_render = run_bench_render,
                                      .schema = scene_file_schema,
                                      .starter = scene::demo_scene_text,
                                      .air = scene_air,
                                      .air_above = scene::air_above};
  return &table;
}

}  // namespace apps
