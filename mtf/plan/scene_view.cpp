// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/scene_view.h"

#include <string>
#include <utility>

#include "mtf/plan/sensor_plan.h"

namespace mtf {

SampleGrid grid_of(const SceneView& scene, const Frame<double>& frame) {
  if (!scene.step.given()) throw UsageError("the scene has no sample step; give one, such as 3.75_um or 0.25_px");
  return {scene.samples.width, scene.samples.height, scene.step.x_um(frame), scene.step.y_um(frame)};
}

Plan compile(const System<double>& system, const SceneView& scene, PlanOptions options) {
  const SampleGrid grid = grid_of(scene, system.frame);
  const SampleGrid detector = detector_grid(system, grid);
  options.scene = summarise(scene.samples, options.border, scene.border_value);
  return compile(system, grid, detector, options);
}

SensorPlan compile_sensor(const System<double>& system, const SceneView& scene, PlanOptions options,
                          int samples_a_pitch) {
  const SampleGrid grid = grid_of(scene, system.frame);
  sensor_grid(system, grid, samples_a_pitch);  // a grid that no sensor can have is refused before the samples are read
  options.scene = summarise(scene.samples, options.border, scene.border_value);
  return compile_sensor(system, grid, options, samples_a_pitch);
}

Image SensorPlan::run(const SceneView& scene, int threads) const {
  const SampleGrid grid = grid_of(scene, system.frame);
  if (grid != in())
    throw UsageError("the scene is " + std::to_string(grid.width) + "x" + std::to_string(grid.height) + " samples of " +
                     format_double(grid.step_x_um) + " um by " + format_double(grid.step_y_um) +
                     " um, the plan was made for " + std::to_string(in().width) + "x" + std::to_string(in().height) +
                     " of " + format_double(in().step_x_um) + " um by " + format_double(in().step_y_um) +
                     " um; compile a plan for this scene");
  std::vector<Image> image = run(std::span(&scene.samples, 1), scene.border_value, threads);
  return std::move(image.front());
}

}  // namespace mtf
