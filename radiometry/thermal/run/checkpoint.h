// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a run needs that goes on after the last day that was finished: the state of all units at the end of that day
// with the plans they are solved by, what the exchange of the next day begins with, and what the report has gathered.
// Facets, weather, rays and units are made anew: they follow from the inputs, bit by bit. So a run that was interrupted
// and continued has the numbers of one that was not.

#include <vector>

#include "radiometry/thermal/heat_batches.h"
#include "radiometry/thermal/seen/left_out.h"
#include "radiometry/thermal/view_spread.h"

namespace radiometry::thermal {

/// Units of one material at the end of a window.
struct SavedBatch {
  double wanted_k = 0.0;
  MaterialRun run;
  heat::Grid fine, coarse;
  heat::GridRequest request;
  double step_tolerance_k = 0.0, depth_k = 0.0;
  heat::State all, sample, promise;
};

struct SavedBatches {
  Window window;
  std::vector<double> emitted, beyond_sample;
  std::vector<SavedBatch> batch;
};

struct Checkpoint {
  std::size_t windows = 0, outputs = 0;  ///< that are finished
  double exchange_k = 0.0;
  LeftOut left_out;  ///< empty where all is asked for
  double warmest_k = 0.0;
  int iterations = 0;
  ViewSpread view_spread;
  SavedBatches batches;
};

/// Throws RuntimeError.
[[noreturn]] void damaged_checkpoint();

}  // namespace radiometry::thermal
