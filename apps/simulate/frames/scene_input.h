// SPDX-License-Identifier: Apache-2.0
#pragma once

// The scene of a frame: read, its bad pixels filled, in the unit that the sensor's plan filters.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/simulate/run_watch.h"
#include "apps/simulate/scene_source.h"
#include "apps/simulate/sensor_run.h"
#include "mtf/plan/plan.h"

namespace apps {

struct SceneInput {
  mtf::io::Scene scene;
  std::vector<mtf::Image> masks;  ///< of bad pixels, per channel
  std::string bad_pixels;         ///< what happened to them, "" = none
  std::optional<mtf::SceneSummary> summary;
  double border_value = 0.0;  ///< in the unit of the planes
  /// Of the band's OTF, where the scene says how far away its pixels are; else that of the sensor holds.
  std::shared_ptr<const mtf::ElectronRate> rate{};
  std::vector<std::string> warnings{};  ///< of the light and of its contrast; `scene` has those of reading it
};

/// Takes the scene out of `source`; `watch` hears of the steps "read" and "light" of a run of one image. Throws as
/// take_scene, treat_bad_pixels and SensorRun::light.
SceneInput load_input(SceneSource source, const SensorRun& sensor, NanPolicy nan, int threads,
                      RunWatch* watch = nullptr);

/// What filters that scene: the system of the sensor, with the `rate` of the scene.
mtf::System<double> system_for(const SensorRun& sensor, const SceneInput& input);

/// True when [scene] of both gives samples the same spacing.
bool same_spacing(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b);

/// True when [scene] of both gives samples the same values, spacing and border. The aperture is left out: the plan
/// alone depends on it.
bool same_values(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b);

/// One scene for every frame. It is loaded again only where the sensor asks for other values of it: [scene] may have
/// changed, samples may be angles, whose size follows the focal length, and the light that a sensor with [detector]
/// takes depends on the band and on all that is before the pixels. A file whose scene is loaded again stays in memory.
class StillScene {
 public:
  StillScene(SceneSource source, NanPolicy nan, int threads)
      : source_(std::move(source)), nan_(nan), threads_(threads) {
    complete_name(source_);
  }

  /// Errors as load_input.
  std::shared_ptr<const SceneInput> of(const SensorRun& sensor);
  const SceneSource& source() const { return source_; }

 private:
  SceneSource source_;
  NanPolicy nan_;
  int threads_;
  SensorRun sensor_;  ///< that `input_` serves
  std::shared_ptr<const SceneInput> input_;
};

}  // namespace apps
