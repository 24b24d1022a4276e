// SPDX-License-Identifier: Apache-2.0
#pragma once

// `mtf simulate` over numbered frames, with parameters that may change from frame to frame.

#include "apps/options.h"

namespace apps {

/// True when scene or output hold a frame number, or frames or a schedule are given.
bool is_sequence(const SimulateOptions& options);

/// Frames are read, run and written on all cores, several at a time, as many as memory allows; each has the same bits
/// for any number of threads. A frame that fails ends the run; those before it are finished and whole. Returns the
/// exit code. Errors as run_simulate, naming the frame.
int run_sequence(const SimulateOptions& options, const Global& global);

}  // namespace apps
