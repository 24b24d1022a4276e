// SPDX-License-Identifier: Apache-2.0
#pragma once

// One frame on its way through the sensor, of a sequence or of a live view.

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/simulate/frames/scene_input.h"
#include "apps/simulate/frames/sequence_plan.h"
#include "apps/simulate/simulate.h"

namespace apps {

struct Frame {
  std::int64_t number = 0;
  std::shared_ptr<const mtf::io::SensorConfig> sensor;  ///< as it is at this frame
  std::string settings;                                 ///< what the schedule has changed so far
  std::shared_ptr<const RadiometricChain> radiometric;  ///< of a sensor with a chain
  std::shared_ptr<const SceneInput> input;
  mtf::KeptScene* kept = nullptr;  ///< of a scene that comes again: the planes of `input`
  std::int64_t noise_rows = 1;     ///< of a kept scene: see radiometry::Chain::run
  std::shared_ptr<const mtf::SensorPlan> plan;
  std::shared_ptr<const radiometry::Chain> chain;
  std::optional<radiometry::ShutterClosing> closing;  ///< the last one, of a shutter that closes now and then
  radiometry::ChainFrame counted;                     ///< what the chain says of it, without its image
  std::vector<std::string> warnings;
  SimulatedImage image;  ///< without planes once a file or the sink has them
  double read_ms = 0.0, plan_ms = 0.0, run_ms = 0.0, write_ms = 0.0;
  std::exception_ptr error;
};

/// The planes of a frame that has its input, its plan and, with [detector], its chain. `state`: of the sequence, for a
/// sensor whose frames leave something to the next, else null.
std::vector<mtf::Image> run_planes(Frame& frame, radiometry::ChainState* state, int threads);

/// What is stored with the image of a frame.
mtf::io::Metadata metadata_of(const Frame& frame);

}  // namespace apps
