// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbered frames, or one scene for all of them, with parameters that may change from frame to frame.

#include <memory>

#include "apps/simulate/simulate.h"
#include "apps/simulate/simulate_options.h"
#include "apps/simulate/simulate_parts.h"
#include "mtf/plan/sensor_plan.h"

namespace apps {

/// True when scene or output hold a frame number, or frames or a schedule are given.
bool is_sequence(const SceneSource& scene, const SimulateOptions& options);

/// simulate() of a sequence. Frames are read, run and handed over on all cores, several at a time, as many as memory
/// allows. A frame that fails ends the run; those before it are finished and whole. Errors name the frame.
SimulateResult simulate_sequence(const mtf::io::SensorConfig& sensor, SceneSource& scene,
                                 const SimulateOptions& options);

// The plan of each frame of a sequence, and its chain. The promise is made frame by frame, relative to that frame's own
// contrast: a plan is compiled for the first frame, with some room for others, and serves as long as a frame's summary
// lies within what it was compiled for; a frame beyond that gets a plan compiled for it, and for all that were before.
// So does a frame that wants another border, scene aperture or split of the filters, or a tighter tolerance. The
// default tolerance of a sensor with [adc] is a share of a count, so it falls as the contrast rises: a plan that is
// compiled again for that reason is compiled for the tolerance that twice this contrast would need, so that a slow rise
// needs few plans. A change of parameters remakes the lists that changed and shares the rest (SensorPlan::with).

/// What of a scene makes a promise hard to keep, relative to its std.
struct SceneDifficulty {
  double storage = 0.0;  ///< rounding of its largest value
  double canvas = 0.0;   ///< norm of its canvas
};

class SequencePlanner {
 public:
  /// Without a tolerance asked for, or with one that may give way, it is loosened where a frame cannot keep it, with a
  /// warning, until the sensor changes or a frame is easier by a factor of 2.
  SequencePlanner(const SimulateOptions& options, int threads);

  /// Gives a frame its plan; frames come in order. Its warnings get what should be said. Throws as compile_sensor.
  void plan(Frame& frame);

  /// And its chain, the one of the frame before where nothing of it has changed. `keep_shading`, errors: as chain_of().
  void chain(Frame& frame, bool keep_shading = false);

  /// The next chain measures its correction itself, instead of taking that of the first one.
  void forget_correction() { chain_.reset(), chain_plan_.reset(); }

  int compiled() const { return compiled_; }
  int updated() const { return updated_; }

 private:
  std::shared_ptr<const mtf::SensorPlan> compile(const mtf::System<double>& system, Frame& frame,
                                                 mtf::PlanOptions options);
  /// The tolerance of a plan with room for frames of more contrast, where the present plan kept the tolerance of the
  /// contrast before and does not keep that of this frame; else the tolerance of the frame.
  double roomy_tolerance(const Frame& frame, double tolerance) const;

  SimulateOptions asked_;  ///< tolerance, loosen, measure, device and threads
  double loosened_ = 0.0;  ///< least tolerance that the sensor of plan_ keeps, where that is not its default; else 0
  mtf::io::SceneDefaults scene_;  ///< [scene] of that sensor
  SceneDifficulty loosened_for_;  ///< the frame that needed it
  SceneDifficulty met_;           ///< the hardest of all frames so far that kept their tolerance
  std::shared_ptr<const mtf::SensorPlan> plan_;
  std::shared_ptr<const radiometry::Chain> chain_;
  SensorRun chain_sensor_;                             ///< that chain_ was made of,
  std::shared_ptr<const mtf::SensorPlan> chain_plan_;  ///< and this
  bool chain_keeps_shading_ = false;
  int compiled_ = 0, updated_ = 0;
};

}  // namespace apps
