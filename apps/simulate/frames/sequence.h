// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbered frames, or one scene for all of them, with parameters that may change from frame to frame.

#include "apps/simulate/simulate.h"

namespace apps {

/// True when scene or output hold a frame number, or frames or a schedule are given.
bool is_sequence(const SceneSource& scene, const SimulateOptions& options);

/// simulate() of a sequence. Frames are read, run and handed over on all cores, several at a time, as many as memory
/// allows. A frame that fails ends the run; those before it are finished and whole. Errors name the frame.
SimulateResult simulate_sequence(const mtf::io::SensorConfig& sensor, SceneSource& scene,
                                 const SimulateOptions& options);

}  // namespace apps
