// SPDX-License-Identifier: Apache-2.0
#pragma once

// The units that stand for all: some of every patch, evenly through the order of the units, and of every material those
// whose direct light changes most from one direction of the sun to the next. All that are asked for, where that is not
// many fewer.

#include "radiometry/thermal/facet_units.h"

namespace radiometry::thermal {

/// Of each unit.
std::vector<bool> sampled_units(const Units& units, const HeatScene& scene);

/// Those whose temperatures are asked for (HeatScene::seen), the sample, and more of the patches that no one asks for,
/// evenly, since these are known by them alone. All but units of given temperature, where all are asked for.
std::vector<bool> solved_units(const Units& units, const HeatScene& scene);

}  // namespace radiometry::thermal
