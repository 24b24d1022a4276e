// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an interrupted run goes on from (run/checkpoint.h) as bytes, and hashes of its inputs.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"

namespace apps::scene {

/// As bytes of this machine, and back. Throws RuntimeError for bytes that are none. Who stores them adds a checksum.
std::string bytes_of(const Checkpoint& checkpoint);
Checkpoint checkpoint_of(std::string_view bytes);

/// Names and hashes of all that the numbers of a run follow from: the scene file, meshes, weather, given temperatures,
/// options, the program.
using Fingerprints = std::vector<std::pair<std::string, std::string>>;
Fingerprints fingerprints_of(const SceneFile& file, const HeatScene& scene, const HeatOptions& options);

}  // namespace apps::scene
