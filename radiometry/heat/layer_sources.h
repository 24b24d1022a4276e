// SPDX-License-Identifier: Apache-2.0
#pragma once

// Constant heat sources q(x) in the layers, W/m3, as heat at the surfaces. The temperature is the sum T = theta + S of
//   S       steady, (k S')' = -q, S = 0 at the exposed surfaces; inside it has no flow (adiabatic, flux), or gives
//           h S to a film, or is 0 at a fixed temperature
//   theta   without sources, with the heat that S brings to the surfaces added to what they absorb
// S is 0 at the surfaces, so theta is the temperature there at all times, exactly: nothing of the solver changes. Of a
// source at a depth the part R' / R comes out of the front, R' the resistance from there to where S is 0 inside, R that
// of the whole way; all of it where no heat passes inside. A source that changes with time would move S: then the
// solver has the sources of all layers at its nodes (Construction::generates, ForcingValues::source_w_m3).

#include <span>

#include "radiometry/heat/construction.h"

namespace radiometry::heat {

struct SourceHeat {
  double front_w_m2 = 0.0,
         back_w_m2 = 0.0;  ///< the back of sheets; what a film or a fixed temperature takes is in none
};

/// `source_w_m3`: of each layer.
SourceHeat source_heat(const Construction& construction, std::span<const double> source_w_m3);

}  // namespace radiometry::heat
