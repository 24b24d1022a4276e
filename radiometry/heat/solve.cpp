// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/solve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/heat/depth/depth_grid.h"
#include "radiometry/heat/forcing.h"
#include "radiometry/heat/lanes.h"
#include "radiometry/heat/surface_loss.h"

namespace radiometry::heat {
namespace {

// What a plan has to know of the forcing before anything is solved, from samples of it.

struct Survey {
  std::vector<double> lowest_w_m2, highest_w_m2;  ///< per facet: absorbed flux of both sides
  double coldest_k = 0.0, hottest_k = 0.0;        ///< no facet leaves this range, nor that of its start
  double flux_w_m2 = 0.0;                         ///< no net flux into a surface is larger
  double shortest_lag_s = 0.0;                    ///< from a break (or the start) to the next output
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostSamples = 128;
constexpr std::size_t kFacetsAtOnce = 256;

/// The stops in the timeline, once each, thinned to at most `kMostSamples`.
std::vector<double> stops_of(const Timeline& timeline) {
  std::vector<double> stops{timeline.start_s, timeline.end_s};
  for (const auto* list : {&timeline.outputs_s, &timeline.breaks_s})
    for (const double t : *list)
      if (t > timeline.start_s && t < timeline.end_s) stops.push_back(t);
  std::sort(stops.begin(), stops.end());
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  return stops;
}

/// The shortest time from the start or a break to the next output.
double shortest_lag(const Timeline& timeline) {
  double lag = timeline.end_s - timeline.start_s;
  std::vector<double> breaks = timeline.breaks_s;
  std::sort(breaks.begin(), breaks.end());
  for (const double output : timeline.outputs_s) {
    if (output <= timeline.start_s || output > timeline.end_s) continue;
    const auto before = std::lower_bound(breaks.begin(), breaks.end(), output);
    const double since = before == breaks.begin() ? timeline.start_s : std::max(*(before - 1), timeline.start_s);
    lag = std::min(lag, output - since);
  }
  return std::max(lag, timeline.least_lag_s);
}

std::vector<Instant> sample_instants(const std::vector<double>& stops) {
  const std::size_t stride = 1 + stops.size() / (kMostSamples / 4);
  std::vector<Instant> instants;
  for (std::size_t i = 0; i + 1 < stops.size(); i += stride) {
    if (i > 0) instants.push_back({stops[i], Instant::Limit::before});
    instants.push_back({stops[i], Instant::Limit::after});
    for (const double part : {0.25, 0.5, 0.75})
      instants.push_back({stops[i] + part * (stops[std::min(i + stride, stops.size() - 1)] - stops[i])});
  }
  instants.push_back({stops.back(), Instant::Limit::before});
  return instants;
}

/// What a surface gains at an instant when it has a temperature; an inside temperature acts through all layers.
struct Gain {
  const Construction* construction;
  const ForcingValues* values;
  std::size_t facet;
  double up;

  double side(const SideForcing& from, bool back, double t) const {
    return from.absorbed_w_m2[facet] - surface_loss(*construction, back, from, back ? -up : up).at(t).loss;
  }
  double at(double t) const {
    double sum = side(values->front, false, t);
    if (construction->is_sheet()) sum += side(values->back, true, t);
    const double through = resistance(*construction);
    if (const auto* film = std::get_if<InnerFilm>(&construction->inside))
      sum += film->h_w_m2_k / (1.0 + film->h_w_m2_k * through) * (values->inside - t);
    if (std::holds_alternative<FixedTemperature>(construction->inside)) sum += (values->inside - t) / through;
    if (std::holds_alternative<InnerFlux>(construction->inside)) sum += values->inside;
    for (std::size_t i = 0; i < values->source_w_m3.size(); ++i)
      sum += values->source_w_m3[i] * construction->layers[i].thickness_m;
    return sum;
  }
};

constexpr double kHottest_k = 1e4;

/// The temperature at which nothing is gained, within 0.1 K; the gain falls with the temperature.
double balance_temperature(const Gain& gain) {
  double lo = 0.0, hi = kHottest_k;
  while (hi - lo > 0.1) {
    const double middle = 0.5 * (lo + hi);
    (gain.at(middle) > 0.0 ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

/// Samples the forcing at the stops, on both sides, and between. With balances linear in time between the samples a
/// surface stays within the range of the temperatures at which it would be in balance with each of them and that of its
/// start, `start_k` (NaN: none, as for a start that repeats).
Survey survey(const Batch& batch, const GroupForcing& forcing, const Timeline& timeline, double start_k) {
  const std::vector<double> stops = stops_of(timeline);
  const std::vector<Instant> instants = sample_instants(stops);
  const bool sheet = batch.construction.is_sheet();
  Survey result{.lowest_w_m2 = std::vector<double>(batch.facets, kInfinity),
                .highest_w_m2 = std::vector<double>(batch.facets, -kInfinity),
                .coldest_k = std::isnan(start_k) ? kInfinity : start_k,
                .hottest_k = std::isnan(start_k) ? -kInfinity : start_k,
                .flux_w_m2 = 0.0,
                .shortest_lag_s = shortest_lag(timeline)};
  std::vector<double> front(kFacetsAtOnce), back(kFacetsAtOnce);
  std::vector<double> source(batch.construction.generates ? batch.construction.layers.size() : 0);
  // Twice over the samples: the range of temperatures, then the largest net flux within it.
  for (const bool flux : {false, true})
    for (std::size_t first = 0; first < batch.facets; first += kFacetsAtOnce) {
      const std::size_t count = std::min(kFacetsAtOnce, batch.facets - first);
      const Forcing own = forcing(first, count);
      for (const Instant instant : instants) {
        ForcingValues values;
        values.front.absorbed_w_m2 = {front.data(), count};
        if (sheet) values.back.absorbed_w_m2 = {back.data(), count};
        values.source_w_m3 = source;
        own(instant, first, values);
        // A few facets stand for all of the piece: the extremes of the absorbed flux.
        std::size_t least = 0, most = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const double absorbed = front[i] + (sheet ? back[i] : 0.0);
          result.lowest_w_m2[first + i] = std::min(result.lowest_w_m2[first + i], absorbed);
          result.highest_w_m2[first + i] = std::max(result.highest_w_m2[first + i], absorbed);
          if (front[i] < front[least]) least = i;
          if (front[i] > front[most]) most = i;
        }
        for (const std::size_t i : {least, most}) {
          const Gain gain{&batch.construction, &values, i, batch.up.empty() ? 0.0 : batch.up[first + i]};
          if (flux) {
            for (const double t : {result.coldest_k, result.hottest_k})
              result.flux_w_m2 = std::max(result.flux_w_m2, std::abs(gain.at(t)));
          } else {
            const double t = balance_temperature(gain);
            result.coldest_k = std::min(result.coldest_k, t);
            result.hottest_k = std::max(result.hottest_k, t);
          }
        }
      }
    }
  return result;
}

/// Of the batch in blocks of `block` neighbours: the first facet of the one with the facet whose flux changes most.
std::size_t block_to_try(const Survey& survey, std::size_t block) {
  std::size_t best = 0;
  double most = -kInfinity;
  for (std::size_t i = 0; i < survey.highest_w_m2.size(); ++i) {
    const double change = survey.highest_w_m2[i] - survey.lowest_w_m2[i];
    if (change > most) {
      most = change;
      best = i;
    }
  }
  return best - best % block;
}

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
  double flux_w_m2 = 0.0, duration_s = 0.0, chain_error_k = 0.0;  ///< see ShortChain
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
  GroupForcing forcing{};
};

Trial trial_of(const Batch& batch, const GroupForcing& forcing, std::size_t begin) {
  const std::size_t count = std::min(kLanes, batch.facets - begin);
  Trial trial{.batch = {batch.construction, count, {}}};
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

/// Runs the problem with better and better guesses until the tolerance is kept; with `economise` also with coarser ones
/// where that pays. `guess` is the first one and becomes the last.
Solution find(const Problem& problem, const Layers& layers, Guess& guess, bool economise, int threads) {
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

/// Throws UsageError for a construction that is not valid, no facets, or `up` of another size or outside -1 ... 1.
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
  return find(problem, prepared.layers, prepared.guess, false, threads);
}

}  // namespace radiometry::heat
