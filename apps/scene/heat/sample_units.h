// SPDX-License-Identifier: Apache-2.0
#pragma once

// The units that stand for all: some of every patch, evenly through the order of the units, and of every material those
// whose direct light changes most from one direction of the sun to the next. All, where that is not many fewer.

#include "apps/scene/heat/units.h"

namespace apps::scene {

/// Of each unit.
std::vector<bool> sampled_units(const Units& units, const Surroundings& surroundings);

}  // namespace apps::scene
