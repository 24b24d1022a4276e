// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a run needs that goes on after the last day that was finished: the state of all units at the end of that day
// with the plans they are solved by, what the exchange of the next day begins with, and what the report has gathered.
// Facets, weather, rays and units are made anew: they follow from the inputs, bit by bit. So a run that was interrupted
// and continued has the numbers of one that was not.

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/scene/heat/heat_batches.h"
#include "apps/scene/heat/seen/left_out.h"
#include "apps/scene/heat/view_spread.h"

namespace apps::scene {

/// Units of one material at the end of a window.
struct SavedBatch {
  double wanted_k = 0.0;
  MaterialRun run;
  radiometry::heat::Grid fine, coarse;
  radiometry::heat::GridRequest request;
  double step_tolerance_k = 0.0, depth_k = 0.0;
  radiometry::heat::State all, sample, promise;
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

/// As bytes of this machine, and back. Throws RuntimeError for bytes that are none. Who stores them adds a checksum.
std::string bytes_of(const Checkpoint& checkpoint);
Checkpoint checkpoint_of(std::string_view bytes);

/// Names and hashes of all that the numbers of a run follow from: the scene file, meshes, weather, given temperatures,
/// options, the program.
using Fingerprints = std::vector<std::pair<std::string, std::string>>;
Fingerprints fingerprints_of(const HeatScene& scene, const HeatOptions& options);

}  // namespace apps::scene
