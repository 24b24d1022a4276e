// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/heat/depth/short_chain.h"
#include "radiometry/heat/lanes.h"
#include "radiometry/heat/survey.h"

namespace radiometry::heat {
namespace {

constexpr double kStepsShare = 0.45, kGridShare = 0.4, kDepthShare = 0.08, kChainShare = 0.02, kStartShare = 0.05;
constexpr double kAim = 0.7;  ///< of a share: what the next guess aims at
constexpr int kMostTrials = 12, kMostEconomies = 3;
constexpr double kFirstStepShare = 0.5;  ///< of the tolerance: the first guess of that of a step
constexpr double kFinestDensity = 3000.0;
constexpr int kMostPeriods = 20;

/// What a plan depends on and trials change.
struct Guess {
  double density = 0.5;
  double step_tolerance_k = 0.0;
};

/// What the survey decides once: the layers that are left, or one node for them.
struct Layers {
  Construction construction;
  bool one_node = false;
  double error_k = 0.0;
  double short_time_s = 0.0;                                      ///< of the grid
  double flux_w_m2 = 0.0, duration_s = 0.0, chain_error_k = 0.0;  ///< see short_chain.h
};

/// The shortest time at which the surface has to be right: the shortest lag from a break to an output, but not less
/// than the time in which the largest flux q warms a half-space of the outermost layer by the tolerance:
/// dT = 2 q sqrt(t / pi) / e, e = sqrt(k rho c).
double short_time(const Layer& outermost, const Survey& survey, const Timeline& timeline, double tolerance_k) {
  const double effusivity = outermost.conductivity_w_m_k / std::sqrt(outermost.diffusivity());
  const double root = tolerance_k * effusivity / (2.0 * survey.flux_w_m2);
  const double visible_s = std::max(survey.shortest_lag_s, std::numbers::pi * root * root);
  return std::min(visible_s, timeline.end_s - timeline.start_s);
}

Layers layers_of(const Batch& batch, const Survey& survey, const Timeline& timeline, double tolerance_k) {
  const double allowed_k = kDepthShare * tolerance_k;
  const double short_s = short_time(batch.construction.layers.front(), survey, timeline, tolerance_k);
  const double one = one_node_error(batch.construction, survey.flux_w_m2);
  const double duration_s = timeline.end_s - timeline.start_s;
  if (one <= allowed_k) return {batch.construction, true, one, short_s};
  Cut cut = cut_depth(batch.construction, survey.hottest_k - survey.coldest_k, duration_s, allowed_k);
  return {std::move(cut.construction), false, cut.error_k, short_s, survey.flux_w_m2, duration_s,
          kChainShare * tolerance_k};
}

Plan plan_of(const Batch& batch, const Layers& layers, const Guess& guess) {
  const GridRequest request{.short_time_s = layers.short_time_s, .density = guess.density};
  Plan plan{batch, {}, {}, request, guess.step_tolerance_k, layers.error_k};
  Grids grids = layers.one_node ? make_one_node(layers.construction) : make_grids(layers.construction, request);
  if (std::holds_alternative<Adiabatic>(batch.construction.inside) && !batch.construction.generates) {
    ShortChain fine = shortened(grids.fine, layers.flux_w_m2, layers.duration_s, layers.chain_error_k);
    grids.fine = std::move(fine.grid);
    grids.coarse = shortened(grids.coarse, layers.flux_w_m2, layers.duration_s, layers.chain_error_k).grid;
    plan.depth_k += fine.error_k;
  }
  plan.fine = std::move(grids.fine);
  plan.coarse = std::move(grids.coarse);
  return plan;
}

/// Neighbouring facets of a batch as a batch of their own.
struct Trial {
  Batch batch;
  GroupForcing forcing;
};

Trial trial_of(const Batch& batch, const GroupForcing& forcing, std::size_t begin) {
  const std::size_t count = std::min(kLanes, batch.facets - begin);
  Trial trial{.batch = {batch.construction, count, {}}, .forcing = {}};
  for (std::size_t i = 0; i < count && !batch.up.empty(); ++i) trial.batch.up.push_back(batch.up[begin + i]);
  trial.forcing = [&forcing, begin](std::size_t first, std::size_t facets) -> Forcing {
    return [own = forcing(begin + first, facets), begin](Instant instant, std::size_t at, ForcingValues& values) {
      own(instant, begin + at, values);
    };
  };
  return trial;
}

Run run_plan(const Plan& plan, const GroupForcing& forcing, const Timeline& timeline, const Start& start,
             double tolerance_k, int threads) {
  if (const auto* uniform = std::get_if<UniformStart>(&start))
    return advance(plan, uniform_state(plan, timeline.start_s, uniform->temperature_k), forcing, timeline, threads);
  Timeline period = timeline;
  period.end_s = timeline.start_s + std::get<RepeatingStart>(start).period_s;
  const double allowed_k = kStartShare * tolerance_k;
  const PeriodicStart repeating = periodic_start(plan, forcing, period, allowed_k, kMostPeriods, threads);
  if (!(repeating.error_k <= allowed_k))
    throw mtf::RuntimeError("heat: the state that repeats is known to " + mtf::format_double(repeating.error_k) +
                            " K after " + std::to_string(kMostPeriods) + " periods, where " +
                            mtf::format_double(allowed_k) + " K are wanted; ask for a larger tolerance");
  Run run = advance(plan, repeating.state, forcing, timeline, threads);
  run.promised.start_k = repeating.error_k;
  return run;
}

/// The next guess: errors fall with the square of the cells, and with the power 2/3 of the tolerance of a step. What is
/// within its share is made coarser only when all is kept, so that guesses do not alternate.
Guess next_guess(const Guess& guess, const Promise& promised, double tolerance_k, bool kept) {
  Guess next = guess;
  const double grid = promised.grid_k / (kAim * kGridShare * tolerance_k);
  const double steps = promised.steps_k / (kAim * kStepsShare * tolerance_k);
  next.density *= std::clamp(std::sqrt(grid), kept ? 0.5 : 1.0, 3.0);
  next.step_tolerance_k /= std::clamp(std::pow(steps, 1.5), kept ? 0.1 : 1.0, 30.0);
  next.step_tolerance_k = std::min(next.step_tolerance_k, tolerance_k);
  return next;
}

bool keeps(const Promise& promised, double tolerance_k) {
  return promised.grid_k <= kGridShare * tolerance_k && promised.steps_k <= kStepsShare * tolerance_k;
}

/// Whether a coarser guess saves so much that its trial pays.
bool pays(const Guess& next, const Guess& guess, bool one_node) {
  return next.step_tolerance_k > 5.0 * guess.step_tolerance_k || (!one_node && next.density < 0.6 * guess.density);
}

[[noreturn]] void give_up(const Promise& promised, double tolerance_k) {
  throw mtf::RuntimeError("heat: a tolerance of " + mtf::format_double(tolerance_k) +
                          " K is not kept: the time steps leave " + mtf::format_double(promised.steps_k) +
                          " K, the grid " + mtf::format_double(promised.grid_k) + " K; ask for a larger tolerance");
}

/// A batch of facets with all that decides its plan but the guess.
struct Problem {
  const Batch* batch;
  const GroupForcing* forcing;
  const Timeline* timeline;
  const Start* start;
  double tolerance_k;
};

struct Found {
  Plan plan;
  Run run;
};

/// Runs the problem with better and better guesses until the tolerance is kept; with `economise` also with coarser ones
/// where that pays.
/// `guess` is the first one and becomes the last.
Found find(const Problem& problem, const Layers& layers, Guess& guess, bool economise, int threads) {
  const double tolerance_k = problem.tolerance_k;
  for (int trial = 1;; ++trial) {
    Plan plan = plan_of(*problem.batch, layers, guess);
    Run run = run_plan(plan, *problem.forcing, *problem.timeline, *problem.start, tolerance_k, threads);
    const Promise promised = run.promised;
    const bool kept = keeps(promised, tolerance_k);
    const Guess next = next_guess(guess, promised, tolerance_k, kept);
    if (kept && !(economise && trial <= kMostEconomies && pays(next, guess, layers.one_node)))
      return {std::move(plan), std::move(run)};
    if (trial == kMostTrials || next.density > kFinestDensity) give_up(promised, tolerance_k);
    guess = next;
  }
}

struct Prepared {
  Layers layers;
  Guess guess;
};

/// The guess after the trial of a few facets; a batch of few is its own trial.
Prepared prepare(const Problem& problem) {
  require_valid(*problem.batch);
  if (!(problem.tolerance_k > 0.0) || !std::isfinite(problem.tolerance_k))
    throw mtf::UsageError("heat: the tolerance is " + mtf::format_double(problem.tolerance_k) +
                          " K, has to be above 0");
  if (!(problem.timeline->end_s > problem.timeline->start_s))
    throw mtf::UsageError("heat: the end of the timeline is not after its start");
  const auto* uniform = std::get_if<UniformStart>(problem.start);
  const double start_k = uniform ? uniform->temperature_k : std::numeric_limits<double>::quiet_NaN();
  const Survey seen = survey(*problem.batch, *problem.forcing, *problem.timeline, start_k);
  Prepared prepared{.layers = layers_of(*problem.batch, seen, *problem.timeline, problem.tolerance_k),
                    .guess = {.step_tolerance_k = kFirstStepShare * problem.tolerance_k}};
  if (problem.batch->facets > kLanes) {
    const Trial trial = trial_of(*problem.batch, *problem.forcing, block_to_try(seen, kLanes));
    Problem few = problem;
    few.batch = &trial.batch;
    few.forcing = &trial.forcing;
    find(few, prepared.layers, prepared.guess, true, 1);
  }
  return prepared;
}

}  // namespace

Plan make_plan(const Batch& batch, const Forcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k) {
  return make_plan(batch, for_all_groups(forcing), timeline, start, tolerance_k);
}

Plan make_plan(const Batch& batch, const GroupForcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k) {
  const Problem problem{&batch, &forcing, &timeline, &start, tolerance_k};
  Prepared prepared = prepare(problem);
  if (batch.facets <= kLanes) return find(problem, prepared.layers, prepared.guess, true, 1).plan;
  return plan_of(batch, prepared.layers, prepared.guess);
}

Solution solve(const Batch& batch, const Forcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k, int threads) {
  return solve(batch, for_all_groups(forcing), timeline, start, tolerance_k, threads);
}

Solution solve(const Batch& batch, const GroupForcing& forcing, const Timeline& timeline, const Start& start,
               double tolerance_k, int threads) {
  const Problem problem{&batch, &forcing, &timeline, &start, tolerance_k};
  Prepared prepared = prepare(problem);
  Found found = find(problem, prepared.layers, prepared.guess, false, threads);
  return {std::move(found.plan), std::move(found.run)};
}

}  // namespace radiometry::heat
