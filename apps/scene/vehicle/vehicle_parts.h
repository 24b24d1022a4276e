// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of the vehicle, each with its groups and materials. Forward is +x, left is +y, the ground is z = 0.

#include "apps/scene/vehicle/solids.h"

namespace apps::scene {

void add_hull(SolidBuilder& solids);          // others
void add_running_gear(SolidBuilder& solids);  // driving_part
void add_engine_deck(SolidBuilder& solids);   // power_top
void add_turret(SolidBuilder& solids);        // firing_part

}  // namespace apps::scene
