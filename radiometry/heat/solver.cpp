// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/heat/group_run.h"

namespace radiometry::heat {
namespace {

/// Pieces of the batch for each thread: a piece shares its eliminations, more than one evens out the load.
constexpr std::int64_t kPieces = 4;

std::size_t groups_of(const Plan& plan) { return (plan.batch.facets + kLanes - 1) / kLanes; }

void require(bool holds, const char* message) {
  if (!holds) throw mtf::UsageError(std::string("heat: ") + message);
}

void require_state_of(const Plan& plan, const State& state) {
  require(state.facets == plan.batch.facets && state.fine.size() == plan.fine.nodes() * state.facets &&
              (state.runs() == Runs::one ? state.coarse.empty()
                                         : state.doubled.size() == state.fine.size() &&
                                               state.coarse.size() == plan.coarse.nodes() * state.facets) &&
              state.step_s.size() == groups_of(plan),
          "the state is of another plan: start with uniform_state or periodic_start of this plan");
}

/// A time at which steps end, unless it is `between`.
struct Stop {
  double time_s;
  bool output, between;
};

/// The stops of a timeline, and the outputs between them where they are wanted, once each.
std::vector<Stop> stops_of(const Timeline& timeline, bool with_between) {
  require(std::isfinite(timeline.start_s) && std::isfinite(timeline.end_s) && timeline.start_s < timeline.end_s,
          "the end of the timeline is not after its start");
  std::vector<Stop> all{{timeline.start_s, false, false}, {timeline.end_s, false, false}};
  for (const double output : timeline.outputs_s) all.push_back({output, true, false});
  for (const double at : timeline.breaks_s) all.push_back({at, false, false});
  if (with_between)
    for (const double output : timeline.between_s) all.push_back({output, true, true});
  for (const Stop& stop : all) require(std::isfinite(stop.time_s), "a time of the timeline is not finite");
  require(std::is_sorted(timeline.outputs_s.begin(), timeline.outputs_s.end()), "the outputs do not rise");
  std::erase_if(all, [&](const Stop& stop) { return stop.time_s < timeline.start_s || stop.time_s > timeline.end_s; });
  std::sort(all.begin(), all.end(), [](const Stop& a, const Stop& b) { return a.time_s < b.time_s; });
  std::vector<Stop> merged;
  for (const Stop& stop : all) {
    if (merged.empty() || merged.back().time_s < stop.time_s) merged.push_back({stop.time_s, false, true});
    merged.back().output |= stop.output;
    merged.back().between &= stop.between;
  }
  return merged;
}

double worst_difference(const double* a, const double* b, std::size_t count) {
  double worst = 0.0;
  for (std::size_t l = 0; l < count; ++l) worst = std::max(worst, std::abs(a[l] - b[l]));
  return worst;
}

/// What an output adds to the promise.
void add_differences(const Surfaces& surfaces, std::size_t count, Promise& promised) {
  if (surfaces.doubled == nullptr) return;
  promised.steps_k = std::max(promised.steps_k, worst_difference(surfaces.fine, surfaces.doubled, count));
  promised.grid_k = std::max(promised.grid_k, worst_difference(surfaces.doubled, surfaces.coarse, count));
}

HeatBalance balance_of(const HeatSums& heat, std::size_t lane, double stored) {
  return {.absorbed = heat.absorbed[lane],
          .emitted = heat.emitted[lane],
          .convected = heat.convected[lane],
          .inside = heat.inside[lane],
          .stored = stored};
}

double heat_stored(const Plan& plan, const State& start, const State& end, std::size_t facet) {
  double sum = 0.0;
  for (std::size_t i = 0; i < plan.fine.nodes(); ++i) {
    const std::size_t at = i * start.facets + facet;
    sum += plan.fine.capacity[i] * (end.fine[at] - start.fine[at]);
  }
  return sum;
}

}  // namespace

double HeatBalance::exchanged() const { return std::abs(absorbed) + emitted + std::abs(convected) + std::abs(inside); }

double HeatBalance::relative_drift() const { return exchanged() > 0.0 ? std::abs(drift()) / exchanged() : 0.0; }

State uniform_state(const Plan& plan, double time_s, std::span<const double> temperature_k, Runs runs) {
  const std::size_t facets = plan.batch.facets;
  require(temperature_k.size() == facets, "as many temperatures are needed as the batch has facets");
  for (const double t : temperature_k)
    require(t >= 0.0 && std::isfinite(t), "a temperature of the start is below 0 K or not finite");
  State state{.time_s = time_s,
              .facets = facets,
              .fine = {},
              .doubled = {},
              .coarse = {},
              .step_s = std::vector<double>(groups_of(plan), std::numeric_limits<double>::infinity())};
  for (std::size_t i = 0; i < plan.fine.nodes(); ++i)
    state.fine.insert(state.fine.end(), temperature_k.begin(), temperature_k.end());
  if (runs == Runs::one) return state;
  state.doubled = state.fine;
  state.coarse.assign(state.fine.begin(),
                      state.fine.begin() + static_cast<std::ptrdiff_t>(plan.coarse.nodes() * facets));
  return state;
}

State uniform_state(const Plan& plan, double time_s, double temperature_k, Runs runs) {
  return uniform_state(plan, time_s, std::vector<double>(plan.batch.facets, temperature_k), runs);
}

Run advance(const Plan& plan, const State& start, const Forcing& forcing, const Timeline& timeline, int threads) {
  return advance(plan, start, for_all_groups(forcing), timeline, threads);
}

Run advance(const Plan& plan, const State& start, const GroupForcing& forcing, const Timeline& timeline, int threads,
            const OutputSink& sink) {
  require_state_of(plan, start);
  require(start.time_s == timeline.start_s, "the state is of another time than the start of the timeline");
  const std::size_t facets = plan.batch.facets;
  const bool sheet = plan.batch.construction.is_sheet(), three = start.runs() == Runs::three;
  const std::vector<Stop> stops = stops_of(timeline, !three);

  Run run;
  run.promised.depth_k = plan.depth_k;
  if (!three) run.promised.steps_k = run.promised.grid_k = std::numeric_limits<double>::infinity();
  for (const Stop& stop : stops)
    if (stop.output) run.outputs_s.push_back(stop.time_s);
  if (!sink) run.front_k.resize(run.outputs_s.size() * facets);
  if (sheet) run.back_k.resize(run.front_k.size());
  const OutputSink keep = [&](std::size_t output, std::size_t first, std::span<const double> front,
                              std::span<const double> back) {
    std::copy(front.begin(), front.end(), run.front_k.begin() + static_cast<std::ptrdiff_t>(output * facets + first));
    std::copy(back.begin(), back.end(), run.back_k.begin() + static_cast<std::ptrdiff_t>(output * facets + first));
  };
  const OutputSink& give = sink ? sink : keep;
  if (three) run.balance.resize(facets);
  run.end = start;
  run.end.time_s = timeline.end_s;

  std::mutex merging;
  const auto advance_groups = [&](std::int64_t begin, std::int64_t end) {
    PlanEliminations kept(plan);
    Promise promised;
    StepCount steps;
    for (std::int64_t g = begin; g < end; ++g) {
      const std::size_t first = static_cast<std::size_t>(g) * kLanes;
      const Forcing own = forcing(first, std::min(kLanes, facets - first));
      GroupRun group(plan, start, own, first, kept);
      const std::size_t count = group.count(), back_count = sheet ? count : 0;
      std::size_t output = 0, next = 0;  // next: of the stops, the first that is not over
      const auto after_step = [&](double begin_s, double end_s) {
        for (; stops[next].between && stops[next].time_s < end_s; ++next) {
          const double share = (stops[next].time_s - begin_s) / (end_s - begin_s);
          const Lanes front = group.front_within(share), back = sheet ? group.back_within(share) : Lanes{};
          give(output++, first, {front.at.data(), count}, {back.at.data(), back_count});
        }
      };
      for (double from_s = timeline.start_s; next < stops.size(); ++next) {
        const auto to = std::find_if(stops.begin() + static_cast<std::ptrdiff_t>(next), stops.end(),
                                     [](const Stop& stop) { return !stop.between; });
        if (to->time_s > from_s) group.advance(from_s, to->time_s, after_step);
        from_s = to->time_s;
        if (!to->output) continue;
        add_differences(group.front(), count, promised);
        if (sheet) add_differences(group.back(), count, promised);
        give(output++, first, {group.front().fine, count}, {group.back().fine, back_count});
      }
      group.store(run.end);
      for (std::size_t l = 0; three && l < group.count(); ++l)
        run.balance[first + l] = balance_of(group.heat(), l, heat_stored(plan, start, run.end, first + l));
      steps.taken += group.steps().taken;
      steps.refused += group.steps().refused;
      steps.facet_steps += group.steps().facet_steps;
    }
    const std::lock_guard lock(merging);
    run.promised.steps_k = std::max(run.promised.steps_k, promised.steps_k);
    run.promised.grid_k = std::max(run.promised.grid_k, promised.grid_k);
    run.steps.taken += steps.taken;
    run.steps.refused += steps.refused;
    run.steps.facet_steps += steps.facet_steps;
  };
  const auto groups = static_cast<std::int64_t>(groups_of(plan));
  const std::int64_t pieces = kPieces * mtf::threads_of(threads);
  mtf::parallel_for(groups, (groups + pieces - 1) / pieces, threads, advance_groups);
  return run;
}

}  // namespace radiometry::heat
