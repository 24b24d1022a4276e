// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of all surfaces of a scene over a run.
//
//   scene -> weather, sun, sky over time -> rays: shadows, views, units, exchange
//   -> heat balance of every unit -> temperatures of facets at the outputs
//
// Units exchange long-wave radiation, so the balance of one needs the temperatures of the others. They are found by
// iteration over windows of a day: all units are solved with the irradiance that the last iteration's temperatures
// give, until that irradiance changes by less than a share of the tolerance. The first day is also the one that the
// start repeats (radiometry/heat/periodic.h).

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "radiometry/thermal/run/verify_heat.h"

namespace radiometry::thermal {

struct HeatReport : UnitsRun {
  std::size_t facets = 0, units = 0, patches = 0;
  std::vector<std::uint32_t> covered{};  ///< facets that lie inside other solids and see nothing else
  scene::ViewError view_error{};
  scene::SunError sun_error{};
  std::optional<Verification> verified{};  ///< where the options ask for it and the run went to its end
  std::vector<std::pair<std::string, double>> timing_ms{};
  std::vector<std::string> warnings{};
};

/// Calls `output` for every output time, in order, and `progress` with the share that is done. A promise above the
/// tolerance is told by the report. Throws RuntimeError when the exchange between surfaces does not converge and when a
/// temperature is one that no surface has.
HeatReport run_heat(
    const HeatScene& scene, const HeatOptions& options, const HeatOutputs& output,
    const HeatProgress& progress = [](const std::string&, double) {});

}  // namespace radiometry::thermal
