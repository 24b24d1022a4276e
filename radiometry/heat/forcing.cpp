// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/forcing.h"

#include <cmath>
#include <string>

#include "mtf/error.h"
#include "mtf/units.h"

namespace radiometry::heat {

GroupForcing for_all_groups(const Forcing& forcing) {
  return [&forcing](std::size_t, std::size_t) -> Forcing { return Forcing(std::cref(forcing)); };
}

void require_valid(const Batch& batch) {
  require_valid(batch.construction, "construction");
  if (batch.facets == 0) throw mtf::UsageError("heat: a batch without facets");
  if (!batch.up.empty() && batch.up.size() != batch.facets)
    throw mtf::UsageError("heat: " + std::to_string(batch.up.size()) + " values of `up` for " +
                          std::to_string(batch.facets) + " facets: give one for each, or none");
  for (const double up : batch.up)
    if (!(std::abs(up) <= 1.0))
      throw mtf::UsageError("heat: a value of `up` is " + mtf::format_double(up) +
                            ", has to be between -1 and 1: the vertical component of a unit normal");
}

}  // namespace radiometry::heat
