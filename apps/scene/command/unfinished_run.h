// SPDX-License-Identifier: Apache-2.0
#pragma once

// An interrupted `mtf heat` leaves the file unfinished.bin in its folder. The same command reads it and continues with
// the first day that is not finished. Only the program that wrote the file can read it. The file holds the hashes of
// all inputs, by which a changed input is recognised and refused.

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

/// Throws UsageError for a file that is damaged, and where an input is not what it was.
UnfinishedRun read_unfinished(const std::string& folder, const Fingerprints& now);

}  // namespace apps::scene
