// SPDX-License-Identifier: Apache-2.0
#pragma once

// The plan of each frame of a sequence. The promise is made frame by frame, relative to that frame's own contrast: a
// plan is compiled for the first frame, with some room for others, and serves as long as a frame's summary lies within
// what it was compiled for; a frame beyond that gets a plan compiled for it, and for all that were before. A change of
// parameters remakes the lists that changed and shares the rest (SensorPlan::with).

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/options.h"
#include "apps/simulate/radiometric_chain.h"
#include "mtf/io/scene.h"
#include "mtf/plan/sensor_plan.h"

namespace apps {

/// A scene that is read, its bad pixels filled.
struct SceneInput {
  mtf::io::Scene scene;
  std::vector<mtf::Image> masks;  ///< of bad pixels, per channel
  std::string bad_pixels;         ///< what happened to them, "" = none
  std::optional<mtf::SceneSummary> summary;
  double border_value = 0.0;  ///< in the unit of the planes
};

/// What of a scene makes a promise hard to keep, relative to its std.
struct SceneDifficulty {
  double storage = 0.0;  ///< rounding of its largest value
  double canvas = 0.0;   ///< norm of its canvas
};

class SequencePlanner {
 public:
  /// Without a tolerance asked for, the default is loosened where a frame cannot keep it, with a warning.
  SequencePlanner(const SimulateOptions& options, int threads);

  /// The plan of a frame; frames come in order. `radiometric`: of a sensor with a chain, else null. `warnings` gets
  /// what should be said. Throws as compile_sensor.
  std::shared_ptr<const mtf::SensorPlan> plan_for(const mtf::io::SensorConfig& sensor,
                                                  const RadiometricChain* radiometric, const SceneInput& input,
                                                  std::vector<std::string>& warnings);

  int compiled() const { return compiled_; }
  int updated() const { return updated_; }

 private:
  std::shared_ptr<const mtf::SensorPlan> compile(const mtf::io::SensorConfig& sensor,
                                                 const RadiometricChain* radiometric, const SceneInput& input,
                                                 std::vector<std::string>& warnings);

  mtf::PlanOptions options_;
  bool asked_ = false;
  SceneDifficulty met_;  ///< the hardest of all frames so far
  std::shared_ptr<const mtf::SensorPlan> plan_;
  int compiled_ = 0, updated_ = 0;
};

}  // namespace apps
