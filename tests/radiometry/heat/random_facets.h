// SPDX-License-Identifier: Apache-2.0
#pragma once

// Facets of random construction under random weather: conductivities of 1e-3 to 400 W/m/K, layers of 50 um to 1 m,
// vacuum to 30 m/s of wind, emissivities of 0.02 to 1, 0 to 1361 W/m2 of sun that shadows switch on and off.

#include "radiometry/heat/solve.h"

namespace radiometry::heat::test {

struct RandomFacet {
  Batch batch;
  Forcing forcing;
  Timeline timeline;
  double start_k;
};

RandomFacet random_facet(std::uint32_t seed);
/// The same, wet to a fraction of 0.05 to 1 on both sides, in air of 100 to 2000 Pa of vapour that swings by half of
/// it.
RandomFacet random_wet_facet(std::uint32_t seed);
/// The same as random_facet, with layers that generate -100 to 400 W/m2, switched on and off where the inside jumps.
RandomFacet random_heated_facet(std::uint32_t seed);
/// The same as random_facet, in the sun and with tarp, under a wind that goes as straight lines between half hours, of
/// which every second one is calm.
RandomFacet random_calm_facet(std::uint32_t seed);

}  // namespace radiometry::heat::test
