// SPDX-License-Identifier: Apache-2.0
#pragma once

// Surface temperatures of a batch of facets over time, with their error.
//
// Every facet is carried three times: on its grid in steps of h, on the same grid in steps of 2h, and on the grid of
// half as many cells in steps of 2h. Both the steps and the grid are of second order, so the differences between the
// three are 3 times the error of the steps and 3 times the error of the grid (Richardson). The promise of a run is the
// largest such difference over facets and outputs, undivided: a factor of 3 is left for steps and cells that are not
// yet small. The result is the first of the three.
//
// A state may also hold one run alone (Runs::one): that in steps of 2h on the whole grid, in a quarter of the time. It
// promises nothing. Its steps are those of the second of the three runs, whose error is 4/3 of the difference to the
// first: for facets that are like those of another batch of the same plan, which is run with all three.

#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/heat/depth/depth_grid.h"
#include "radiometry/heat/forcing.h"

namespace radiometry::heat {

/// Bounds of the error of the surface temperatures, K: the worst facet at any output time.
struct Promise {
  double steps_k = 0.0;  ///< time steps
  double grid_k = 0.0;   ///< cells
  double depth_k = 0.0;  ///< layers taken as one node, and depth that was cut off
  double start_k = 0.0;  ///< a start that repeats: how far it is from the state that does (periodic.h)
  double total_k() const { return steps_k + grid_k + depth_k + start_k; }
};

/// How a batch is solved: made by make_plan, used by advance.
struct Plan {
  Batch batch;
  Grid fine, coarse;              ///< coarse has half the cells
  GridRequest request;            ///< that made the grids
  double step_tolerance_k = 0.0;  ///< largest error of a step of 2h, by the embedded estimate
  double depth_k = 0.0;           ///< as in Promise
};

/// How often a facet is carried.
enum class Runs { three, one };

/// Temperatures of all nodes of a batch at a time, as a value: an interval can be taken again from the same state.
struct State {
  double time_s = 0.0;
  std::size_t facets = 0;
  /// [node * facets + facet], K: in steps of h, in steps of 2h, on the coarse grid in steps of 2h.
  std::vector<double> fine{}, doubled{}, coarse{};
  /// For Runs::one the first is the run in steps of 2h, and the other two are empty.
  std::vector<double> step_s;  ///< per group of facets that share their steps: the step 2h to try next

  Runs runs() const { return doubled.empty() ? Runs::one : Runs::three; }
};

/// Heat of one facet over a run, J/m2, summed with the weights of the scheme itself.
struct HeatBalance {
  double absorbed = 0.0;   ///< both sides of a sheet
  double emitted = 0.0;    ///< epsilon sigma T^4
  double convected = 0.0;  ///< to the air, latent heat too
  double inside = 0.0;     ///< from the inside boundary into the construction, and from sources in its layers
  double stored = 0.0;     ///< end minus start
  /// What is missing: rounding alone.
  double drift() const { return absorbed + inside - emitted - convected - stored; }
  /// The sum of the sizes of what was exchanged, against which the drift is judged.
  double exchanged() const;
  /// The drift as a part of that; 0 where nothing was exchanged.
  double relative_drift() const;
};

struct StepCount {
  std::int64_t taken = 0, refused = 0;  ///< steps of 2h, of groups of facets
  std::int64_t facet_steps = 0;         ///< TR-BDF2 steps of all facets on all three grids, refused ones too
};

struct Run {
  std::vector<double> outputs_s;  ///< the outputs of the timeline that lie in the run, start included; times rise
  std::vector<double> front_k;    ///< [output * facets + facet]; empty where an OutputSink gets them
  std::vector<double> back_k;     ///< of sheets; else empty
  Promise promised;               ///< infinite for Runs::one
  StepCount steps;
  std::vector<HeatBalance> balance;  ///< per facet; empty for Runs::one
  State end;
};

/// Gets the surface temperatures of facets first, first + 1, ... at an output (in Run::outputs_s). It is called from
/// several threads, for different facets; `back_k` is empty but for sheets.
using OutputSink = std::function<void(std::size_t output, std::size_t first, std::span<const double> front_k,
                                      std::span<const double> back_k)>;

/// The state in which all nodes of every facet have a temperature.
State uniform_state(const Plan& plan, double time_s, double temperature_k, Runs runs = Runs::three);
/// One temperature per facet.
State uniform_state(const Plan& plan, double time_s, std::span<const double> temperature_k, Runs runs = Runs::three);

/// Advances a batch from `start` over the timeline (start.time_s has to be timeline.start_s). Results do not depend on
/// `threads` (0: all cores). `sink`: gets the outputs, which are not kept then. Throws UsageError for a state of
/// another plan or a timeline whose times do not rise, and RuntimeError where the forcing gives a value that is not
/// finite, or no step is short enough.
Run advance(const Plan& plan, const State& start, const Forcing& forcing, const Timeline& timeline, int threads = 1);
Run advance(const Plan& plan, const State& start, const GroupForcing& forcing, const Timeline& timeline,
            int threads = 1, const OutputSink& sink = {});

}  // namespace radiometry::heat
