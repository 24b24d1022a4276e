// SPDX-License-Identifier: Apache-2.0
#pragma once

// The units of a scene solved over a run, window by window, with what the solution promises.

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "radiometry/scene/table_error.h"
#include "radiometry/thermal/heat_batches.h"

namespace radiometry::thermal {

// What solving units in place of facets leaves open, measured in the first day: neither is bounded, nor part of the
// promise.
//
// View spread: how far facets are from the unit that is solved for them, by what they see: the long-wave irradiance of
// a facet from its own view of sky, ground and patches, against that of its unit, on facets spread evenly over the
// list. Two facets that see equal shares of other surfaces may see warmer and colder ones; and the view that decides
// about units is sampled. Both are in this number, and so is the sampling error of the views that are compared.
//
// Left out: what is not solved where only facets that the camera sees are asked for (HeatOptions::seen): units that it
// does not see, but for some of each patch (facet_units.h). What such a patch emits is the mean of those,
//   M = sum_i w_i e_i,   w_i the share of the area that they have,   e_i = eps sigma T_i^4,
// with the variance V = n / (n - 1) sum_i w_i^2 (e_i - M)^2 (1 - n / N) of a ratio of means (Cochran, Sampling
// Techniques, 1977, section 6.3) for n of N units. A surface gets F_p of it from patch p, so that its absorbed flux has
// the standard error eps sqrt(sum_p F_p^2 V_p), patches being independent of each other. Units are taken evenly along
// the order of their shadows, which makes the true error smaller than that of units taken at random.

/// In K: the largest difference of absorbed long-wave flux over the nodes of the window solved last, over the loss.
struct ViewSpread {
  scene::TableError error_k;
  double largest_k = 0.0;
};

ViewSpread view_spread(const HeatScene& scene, const Units& units, const GroundLight& ground,
                       const HeatBatches& batches, const Window& window, const HeatOptions& options,
                       double loss_w_m2_k);

/// How much is left out, and by how much that changes the temperatures of units that are seen: the standard error in K
/// at the hour where it is largest.
struct LeftOut {
  std::size_t facets = 0;  ///< not seen
  std::size_t units = 0;   ///< not solved
  scene::TableError error_k;
  double largest_k = 0.0;
};

/// Over the nodes of the window solved last, an hour apart.
LeftOut left_out(const HeatScene& scene, const Units& units, const HeatBatches& batches, const Window& window,
                 double loss_w_m2_k, int threads);

/// What a run needs that goes on after the last day that was finished: the state of all units at the end of that day
/// with the plans they are solved by, what the exchange of the next day begins with, and what the report has gathered.
/// Facets, weather, rays and units are made anew: they follow from the inputs, bit by bit. So a run that was
/// interrupted and continued has the numbers of one that was not.
struct Checkpoint {
  std::size_t windows = 0, outputs = 0;  ///< that are finished
  double exchange_k = 0.0;
  LeftOut left_out;  ///< empty where all is asked for
  double warmest_k = 0.0;
  int iterations = 0;
  ViewSpread view_spread;
  SavedBatches batches;
};

/// Bounds in K: of the worst facet at any output time, given the tables.
struct HeatPromise {
  heat::Promise solver;     ///< the worst material: steps, grid, depth
  double ground_k = 0.0;    ///< the solution of the ground
  double units_k = 0.0;     ///< facets that are solved as one unit: sun, shadows and shares of their views
  double exchange_k = 0.0;  ///< iteration of the exchange, and its parabolas between nodes
  double feedback = 1.0;    ///< exchange passes errors on: what they are multiplied by
  double total_k() const { return feedback * (solver.total_k() + ground_k + units_k + exchange_k); }
};

/// Temperatures at one output.
struct HeatOutput {
  double time_s = 0.0;              ///< from the start of the run
  std::span<const double> front_k;  ///< of each facet; NaN where it is not asked for
  std::span<const double> back_k;   ///< of each facet of a sheet, NaN elsewhere; empty without sheets
};
using HeatOutputs = std::function<void(const HeatOutput&)>;
using HeatProgress = std::function<void(const std::string& step, double share)>;

struct UnitsRun {
  HeatPromise promised;
  std::vector<MaterialRun> materials;    ///< with units; the ground is last, where it is solved
  std::size_t outputs = 0;               ///< fewer than the scene has after an interrupt
  int iterations = 0;                    ///< the most of any window
  ViewSpread view_spread;                ///< facets against their units, in the first day
  std::optional<LeftOut> left_out;       ///< where only what the camera sees is asked for, in the first day
  double ms = 0.0;                       ///< of the solution
  std::optional<Checkpoint> checkpoint;  ///< after an interrupt: what HeatOptions::from continues
};

/// What a surface that is solved gives off for each kelvin, at least, W/m2/K: a difference of its absorbed flux is no
/// larger difference of its temperature than by this.
double least_loss_w_m2_k(const HeatScene& scene);

/// The largest difference of absorbed flux within a unit, W/m2, that a tolerance has room for.
double units_tolerance_w_m2(const HeatScene& scene, double tolerance_k);

/// Calls `output` for every output time, in order, of a run that is continued for those that are not finished. Throws
/// as run_heat.
UnitsRun solve_units(const HeatScene& scene, const Units& units, const HeatOptions& options, const HeatOutputs& output,
                     const HeatProgress& progress);

}  // namespace radiometry::thermal
