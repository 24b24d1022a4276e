// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of all surfaces of a scene over a run.
//
//   scene file -> meshes, facets, regions -> weather, sun, sky over time -> rays: shadows, views, units, exchange
//   -> heat balance of every unit -> temperatures of facets at the outputs
//
// Units exchange long-wave radiation, so the balance of one needs the temperatures of the others. They are found by
// iteration over windows of a day: all units are solved with the irradiance that the last iteration's temperatures
// give, until that irradiance changes by less than a share of the tolerance. The first day is also the one that the
// start repeats (radiometry/heat/periodic.h).

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/heat/heat_batches.h"
#include "apps/scene/heat/view_spread.h"

namespace apps::scene {

/// Bounds in K: of the worst facet at any output time, given the tables.
struct HeatPromise {
  radiometry::heat::Promise solver;  ///< the worst material: steps, grid, depth
  double ground_k = 0.0;             ///< the solution of the ground
  double units_k = 0.0;              ///< facets that are solved as one unit: sun, shadows and shares of their views
  double exchange_k = 0.0;           ///< iteration of the exchange, and its straight lines between nodes
  double feedback = 1.0;             ///< exchange passes errors on: what they are multiplied by
  double total_k() const { return feedback * (solver.total_k() + ground_k + units_k + exchange_k); }
};

struct HeatReport {
  HeatPromise promised;
  std::vector<MaterialRun> materials;  ///< with units; the ground is last, where it is solved
  std::size_t facets = 0, units = 0, patches = 0, outputs = 0;
  int iterations = 0;  ///< the most of any window
  radiometry::scene::ViewError view_error;
  radiometry::scene::TableError sun_error;
  ViewSpread view_spread;  ///< facets against their units, in the first day
  std::vector<std::pair<std::string, double>> timing_ms;
  std::vector<std::string> warnings;
};

/// Temperatures at one output.
struct HeatOutput {
  double time_s = 0.0;              ///< from the start of the run
  std::span<const double> front_k;  ///< of each facet
  std::span<const double> back_k;   ///< of each facet of a sheet, NaN elsewhere; empty without sheets
};

/// Calls `output` for every output time, in order, and `progress` with the share that is done. A promise above the
/// tolerance is told by the report. Throws RuntimeError when the exchange between surfaces does not converge and when a
/// temperature is one that no surface has.
HeatReport run_heat(const HeatScene& scene, const HeatOptions& options,
                    const std::function<void(const HeatOutput&)>& output,
                    const std::function<void(const std::string& step, double share)>& progress);

}  // namespace apps::scene
