// SPDX-License-Identifier: Apache-2.0
#pragma once

// The object of `mtf scene demo`: a tracked vehicle of our own design on gentle terrain. It has the size of the object
// in the paper that the toolkit grew from, 178,190 vertices, and the same four regions as groups of faces:
//
//   firing_part    turret, gun, hatches
//   driving_part   tracks, road wheels, return rollers, sprockets, idlers
//   power_top      top of the power compartment: engine deck with its louvres
//   others         hull, fenders, stowage, lamps, exhaust, tools
//
// The vehicle faces east (+x) and stands on z = 0, its middle above the origin: 7.3 m long with its gun, 3.2 m wide,
// 2.7 m high without its aerials. It is made of closed shells that overlap or touch, as parts of a vehicle do. Every
// face is a quad with at least two edges along the same axis, whose ends share their other coordinates digit by digit:
// it stays plane to the last bit when the coordinates are rounded to float32. Coordinates are whole micrometres, so
// that every machine writes the same file.

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// Materials: `armour`, `steel` (tracks, running gear, gun) and `rubber` (tyres).
radiometry::scene::Mesh make_vehicle();

/// A square of 80 m with the group and the material `terrain`: 8,100 plane quads, 0.3 m wide at the vehicle and growing
/// outwards. It is horizontal under the vehicle, 5 mm below its tracks, and rises and falls by less than 1 m elsewhere.
radiometry::scene::Mesh make_terrain();

}  // namespace apps::scene
