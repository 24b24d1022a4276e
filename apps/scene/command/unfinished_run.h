// SPDX-License-Identifier: Apache-2.0
#pragma once

// unfinished.bin in the folder of an interrupted `mtf heat`: with it the same command goes on where it ended. It is
// meant for the program that wrote it; it holds the hashes of all inputs, so that none of them has changed.

#include <string>

#include "apps/scene/command/heat_files.h"

namespace apps::scene {

struct UnfinishedRun {
  Fingerprints fingerprints;
  EarlierOutputs outputs;
  Checkpoint checkpoint;
};

std::string unfinished_path(const std::string& folder);

/// The file appears whole or not at all.
void write_unfinished(const std::string& folder, const UnfinishedRun& run);

/// Throws RuntimeError for a file that is damaged, UsageError where an input is not what it was.
UnfinishedRun read_unfinished(const std::string& folder, const Fingerprints& now);

}  // namespace apps::scene
