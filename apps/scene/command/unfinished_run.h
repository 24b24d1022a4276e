// SPDX-License-Identifier: Apache-2.0
#pragma once

// A `mtf heat` that is interrupted leaves the file unfinished.bin in its folder, and one that runs for long writes it
// every few seconds, so that one that is killed leaves it too. The outputs so far are in unfinished.npy and
// unfinished_back.npy, which hold at least those that unfinished.bin counts. The same command reads them and continues
// with the first day that is not finished. Only the program that wrote the files can read them. unfinished.bin holds
// the hashes of all inputs, by which a changed input is recognised and refused.

#include <string>
#include <utility>
#include <vector>

#include "apps/scene/command/heat_files.h"

namespace apps::scene {

/// Names and hashes of all that the numbers of a run follow from: the scene file, meshes, weather, given temperatures,
/// options, the program.
using Fingerprints = std::vector<std::pair<std::string, std::string>>;
Fingerprints fingerprints_of(const SceneFile& file, const HeatScene& scene, const HeatOptions& options);

struct UnfinishedRun {
  Fingerprints fingerprints;
  EarlierOutputs outputs;
  Checkpoint checkpoint;
};

std::string unfinished_path(const std::string& folder);
/// All files of it: the state first, as without it the tables are no run.
std::vector<std::string> unfinished_files(const std::string& folder);

/// Whether there is one. Anything may stand in the folder, which may not exist.
bool is_unfinished(const std::string& folder);

/// When a run is finished. What it leaves then is still none or all of it.
void remove_unfinished(const std::string& folder);

/// The file appears whole or not at all.
void write_unfinished(const std::string& folder, const UnfinishedRun& run);

/// Of a scene of so many regions. Throws UsageError for a file that is damaged, and where an input is not what it was.
UnfinishedRun read_unfinished(const std::string& folder, const Fingerprints& now, std::size_t regions);

}  // namespace apps::scene
