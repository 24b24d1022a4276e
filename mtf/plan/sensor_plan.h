// SPDX-License-Identifier: Apache-2.0
#pragma once

// The linear chain of a sensor without noise: presample OTF and sampling, then readout and postsample filters on the
// detector grid, one tolerance for all.

#include <optional>
#include <span>
#include <vector>

#include "mtf/plan/plan.h"

namespace mtf {

struct SensorPlan {
  Plan presample;
  std::optional<Plan> readout;  ///< with PlanOptions::separate_readout; else it is in `post`
  std::optional<Plan> post;     ///< none when readout and postsample change nothing
  double predicted_error = 0.0;
  System<double> system;    ///< for which the plan was made
  PlanOptions options;      ///< with which it was made
  int samples_a_pitch = 1;  ///< per axis; more than 1 where positions between the pixels are sampled too (microscan)
  bool updated = false;     ///< made by with() from another plan whose FFT plans it shares

  const SampleGrid& in() const { return presample.in(); }
  const SampleGrid& out() const { return presample.out(); }
  /// The sensor's image of a scene; it has to lie as the one the plan was made for (UsageError).
  Image run(const SceneView& scene, int threads = 0) const;
  /// Output planes of the given scene planes; arguments and errors as Plan::run.
  std::vector<Image> run(std::span<const ImageView<const float>> scene, double border_value = 0.0,
                         int threads = 0) const;
  /// The same of a scene that comes again (mtf/engines/kept_scene.h).
  std::vector<Image> run(KeptScene& scene, double border_value = 0.0, int threads = 0) const;
  /// The same in the memory of the scene planes, which are overwritten: for large images.
  std::vector<Image> run(std::vector<Image>&& scene, double border_value = 0.0, int threads = 0) const;

  /// The plan of another system on the same scene grid and options. A list that has not changed keeps its plan, one
  /// that has is remade for its old share of the tolerance. Everything is compiled anew where that cannot be: another
  /// detector grid, filters that come or go, or shares that no longer fit. Errors as compile_sensor.
  SensorPlan with(const System<double>& other) const;

  /// The filters after the sampling alone; `border_value` is the scene's.
  std::vector<Image> run_filters(std::vector<Image> sampled, double border_value = 0.0, int threads = 0) const;
};

/// Filtered planes in the memory of the given ones where they fit there. Throws UsageError for a plane of another size
/// than plan.in().
std::vector<Image> run_in_place(const Plan& plan, std::vector<Image> images, double border_value = 0.0,
                                int threads = 0);

/// The worst input that the filters after the sampling may get: all contrast of the scene's canvas may lie in the part
/// that the detector sees, aliases may add, and the correction of the scene's own blur amplifies.
SceneSummary after_sampling(SceneSummary scene, const PlanOptions& options, const SampleGrid& in,
                            const SampleGrid& out);

/// Splits the tolerance into equal shares; the error of a step passes through the filters that follow it, so its share
/// is divided by their largest gain. With `samples_a_pitch` the image is sampled that much finer than the pixels of the
/// system, whose presample OTF stays theirs; filters after the sampling act on the finer image. Errors as compile().
SensorPlan compile_sensor(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                          int samples_a_pitch = 1);

/// The same for a scene in memory: options.scene is its summary, whatever it was before.
SensorPlan compile_sensor(const System<double>& system, const SceneView& scene, PlanOptions options,
                          int samples_a_pitch = 1);

/// The grid that compile_sensor samples on.
SampleGrid sensor_grid(const System<double>& system, const SampleGrid& scene, int samples_a_pitch);

}  // namespace mtf
