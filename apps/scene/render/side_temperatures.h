// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of both sides of all facets at one time.

#include <optional>
#include <string>
#include <vector>

#include "apps/scene/heat/run/heat_run.h"
#include "apps/scene/heat/surfaces.h"

namespace apps::scene {

struct SideTemperatures {
  std::vector<float> kelvin;  ///< radiometry::scene::index(side); NaN for the inside of solids
  double utc_s = 0.0;
};

/// Fronts of facets, and the backs of sheets where they are known.
struct FacetTemperatures {
  std::vector<float> front, back;
  double utc_s = 0.0;
};

/// Those that the heat balance has at a time of the run of the file, solved from its start until then. Throws
/// UsageError for times outside of the run, RuntimeError as run_heat.
FacetTemperatures solved_temperatures(const SceneFile& file, double utc_s, const HeatOptions& options,
                                      const HeatProgress& progress);

/// `source`: the folder that `mtf heat` wrote, or a table of facets (facet_table.h); "": what the regions of the file
/// have. Throws UsageError naming the regions without a temperature, and for a time that the table does not have.
SideTemperatures side_temperatures(const SceneFile& file, const Surfaces& surfaces, const std::string& source,
                                   std::optional<double> utc_s);
/// `source`: what messages call them.
SideTemperatures side_temperatures(const SceneFile& file, const Surfaces& surfaces, const FacetTemperatures& of,
                                   const std::string& source);

/// Whether the back of that facet is exposed and has a temperature of its own.
bool is_sheet(const SceneFile& file, const Surfaces& surfaces, std::uint32_t facet);

}  // namespace apps::scene
