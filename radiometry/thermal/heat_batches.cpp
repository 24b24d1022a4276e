// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/heat_batches.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/heat/lanes.h"
#include "radiometry/heat/solve.h"
#include "radiometry/light/constants.h"
#include "radiometry/thermal/facet_units.h"
#include "radiometry/weather/instant.h"

namespace radiometry::thermal {
namespace {

constexpr double kPlanShare = 0.7;    // of the tolerance: plans are made by trial, other units and days may need more
constexpr double kStepsFactor = 2.0;  // see the header
constexpr int kStartDays = 2;         // where a state that repeats is found from nothing
constexpr double kCoarseStop_s = 1200.0;  // steps of a coarse plan end there, unless their error has them end before
constexpr double kCoarseStepShare = 2.0, kCoarseStep_k = 0.15;  // of the tolerance, and at most

/// The larger of two promises, part by part.
heat::Promise worse(const heat::Promise& a, const heat::Promise& b) {
  return {std::max(a.steps_k, b.steps_k), std::max(a.grid_k, b.grid_k), std::max(a.depth_k, b.depth_k),
          std::max(a.start_k, b.start_k)};
}

double worst_drift(const std::vector<heat::HeatBalance>& balances) {
  double worst = 0.0;
  for (const heat::HeatBalance& balance : balances) worst = std::max(worst, balance.relative_drift());
  return worst;
}

/// The states of some facets, and back.
heat::State picked(const heat::State& all, const std::vector<std::uint32_t>& places) {
  heat::State some{all.time_s, places.size(), {}, {}, {}, {}};
  for (std::size_t node = 0; node < all.fine.size() / all.facets; ++node)
    for (const std::uint32_t place : places) some.fine.push_back(all.fine[node * all.facets + place]);
  some.step_s.assign((places.size() + heat::kLanes - 1) / heat::kLanes, std::numeric_limits<double>::infinity());
  return some;
}

void put_back(const heat::State& some, const std::vector<std::uint32_t>& places, heat::State& all) {
  for (std::size_t node = 0; node < all.fine.size() / all.facets; ++node)
    for (std::size_t i = 0; i < places.size(); ++i)
      all.fine[node * all.facets + places[i]] = some.fine[node * some.facets + i];
}

void add(heat::StepCount& sum, const heat::StepCount& steps) {
  sum.taken += steps.taken;
  sum.refused += steps.refused;
  sum.facet_steps += steps.facet_steps;
}

/// A shortened chain has no depths (radiometry/heat/depth/depth_grid.h); layers that generate heat need them.
bool is_whole(const heat::Grid& grid, const heat::Construction& construction) {
  const std::size_t nodes = grid.nodes();
  const bool chain = grid.depth_m.empty() && grid.layer_m.empty() && !construction.generates;
  return nodes > 0 && grid.conductance.size() + 1 == nodes &&
         (chain || (grid.depth_m.size() == nodes && grid.layer_m.size() == nodes * construction.layers.size()));
}

/// Whether a state is one of so many facets on the grids of its batch.
bool fits(const heat::State& state, const SavedBatch& batch, std::size_t facets) {
  const std::size_t fine = batch.fine.nodes() * facets, coarse = batch.coarse.nodes() * facets;
  const bool one = state.doubled.empty() && state.coarse.empty();
  return state.facets == facets && state.fine.size() == fine &&
         (one || (state.doubled.size() == fine && state.coarse.size() == coarse)) &&
         state.step_s.size() == (facets + heat::kLanes - 1) / heat::kLanes;
}

}  // namespace

std::vector<Window> windows_of(const Surroundings& s) {
  std::vector<Window> windows;
  for (std::size_t first = 0; first + 1 < s.nodes(); first = windows.back().last) {
    const double end = s.time_s[first] + heat::kDay_s + 1e-3;
    const auto above = std::upper_bound(s.time_s.begin(), s.time_s.end(), end);
    windows.push_back({first, static_cast<std::size_t>(above - s.time_s.begin()) - 1});
  }
  return windows;
}

HeatBatches::HeatBatches(const HeatScene& scene, const Units& units, const GroundLight& ground, double tolerance_k,
                         int threads)
    : scene_(scene),
      units_(units),
      ground_(ground),
      tolerance_k_(tolerance_k),
      threads_(threads),
      means_(patch_means(units)) {
  const std::vector<bool> solved = solved_units(units, scene);
  for (std::uint32_t i = 0; i < units.unit.size(); ++i) {
    const Unit& unit = units.unit[i];
    if (unit.given || !solved[i]) continue;
    if (batches_.empty() || batches_.back().material != *unit.material) {
      batches_.emplace_back();
      batches_.back().material = *unit.material;
      batches_.back().run.name = scene.material[*unit.material].name;
      batches_.back().wanted_k = kPlanShare * tolerance_k;
    }
    batches_.back().all.unit.push_back(i);
  }
  // Shares of the area of a patch that is solved or given.
  std::vector<double> share(units.exchange.receivers(), 0.0), area_m2(units.exchange.patches(), 0.0);
  const auto has_temperature = [&](const Unit& unit) {
    return unit.given || solved[static_cast<std::size_t>(&unit - units.unit.data())];
  };
  for_receivers(units, [&](std::size_t r, const Unit& unit, const UnitSide&) {
    if (has_temperature(unit)) area_m2[units.exchange.patch_of[r]] += units.exchange.receiver_area_m2[r];
  });
  emission_.assign(units.exchange.receivers(), 0.0);
  for_receivers(units, [&](std::size_t r, const Unit& unit, const UnitSide& side) {
    if (!has_temperature(unit)) return;
    share[r] = units.exchange.receiver_area_m2[r] / area_m2[units.exchange.patch_of[r]];
    emission_[r] = share[r] * side.emissivity * kStefanBoltzmann_w_m2_k4;
    if (unit.given) return;
    solved_receivers_.push_back(static_cast<std::uint32_t>(r));
    if (unit.paired) solved_receivers_.push_back(static_cast<std::uint32_t>(unit.back_receiver));
  });
  std::vector<std::vector<std::uint32_t>> of_patch(units.exchange.patches());
  for (std::uint32_t r = 0; r < emission_.size(); ++r)
    if (emission_[r] > 0.0) of_patch[units.exchange.patch_of[r]].push_back(r);
  for (const std::vector<std::uint32_t>& receivers : of_patch) {
    emitting_.first.push_back(static_cast<std::uint32_t>(emitting_.receiver.size()));
    for (const std::uint32_t r : receivers) {
      emitting_.receiver.push_back(r);
      emitting_.emission.push_back(emission_[r]);
    }
  }
  emitting_.first.push_back(static_cast<std::uint32_t>(emitting_.receiver.size()));
  std::ranges::sort(solved_receivers_);
  const auto repeated = std::ranges::unique(solved_receivers_);
  solved_receivers_.erase(repeated.begin(), repeated.end());
  const std::vector<bool> sampled = sampled_units(units, scene);
  sampled_share_.assign(units.exchange.patches(), 0.0);
  for (Batch& batch : batches_) {
    for (const std::uint32_t i : batch.all.unit)
      if (sampled[i]) batch.sample.unit.push_back(i);
    batch.promise.unit = batch.sample.unit;
    batch.run.units = batch.all.unit.size();
    batch.run.sample = batch.sample.unit.size();
    for (Group* group : {&batch.all, &batch.sample, &batch.promise}) {
      group->heat.construction = scene.material[batch.material].construction;
      group->heat.facets = group->unit.size();
      for (const std::uint32_t i : group->unit)
        group->heat.up.push_back(std::clamp(units.unit[i].front.normal[2], -1.0, 1.0));
    }
    for (const std::uint32_t i : batch.sample.unit) {
      const Unit& unit = units.unit[i];
      for (std::size_t r = unit.receiver; r <= unit.receiver + (unit.has_own_back() ? 1 : 0); ++r) {
        sampled_receivers_.push_back(static_cast<std::uint32_t>(r));
        sampled_share_[units.exchange.patch_of[r]] += share[r];
      }
    }
  }
}

heat::Timeline HeatBatches::timeline(std::size_t first, std::size_t last, Pace pace) const {
  const std::vector<double>& times = scene_.surroundings.time_s;
  heat::Timeline line{times[first], times[last], {}, {}, {}, kUsualLag_s};
  double next_s = times[first];  // where steps have to end
  for (std::size_t k = first; k <= last; ++k) {
    const bool ends = pace == Pace::fine || k == last || times[k] >= next_s;
    if (ends) next_s = times[k] + kCoarseStop_s - 1e-3;
    if (ends) line.breaks_s.push_back(times[k]);
    (ends ? line.outputs_s : line.between_s).push_back(times[k]);
    if (k < last) line.between_s.push_back(0.5 * (times[k] + times[k + 1]));
  }
  return line;
}

void HeatBatches::set_window(const Window& window, bool first) {
  const std::vector<double>& times = scene_.surroundings.time_s;
  const std::size_t receivers = units_.exchange.receivers(), patches = units_.exchange.patches();
  const Window old = window_;
  const std::vector<double> emitted = std::move(emitted_), beyond = std::move(beyond_sample_);
  window_ = window;
  light_ = make_patch_light(units_, window.first, window.last);
  const std::size_t moments = light_.moments();
  receiver_k_.assign(moments * receivers, 0.0);
  samples_ = 0;
  emitted_.assign(moments * patches, 0.0);
  beyond_sample_.assign(moments * patches, 0.0);
  given_.assign(moments * patches, 0.0);
  struct Given {
    std::size_t receiver;
    std::uint32_t facet;
  };
  std::vector<Given> all_given;
  std::vector<double> emission(patches, 0.0);  // of what is solved, as emission_
  for_receivers(units_, [&](std::size_t i, const Unit& unit, const UnitSide&) {
    if (unit.given)
      all_given.push_back({i, unit.leader});
    else
      emission[units_.exchange.patch_of[i]] += emission_[i];
  });
  std::size_t near = 2 * old.first;  // a moment of the old window
  const auto time_of = [&](std::size_t moment) {
    return moment % 2 == 0 ? times[moment / 2] : 0.5 * (times[moment / 2] + times[moment / 2 + 1]);
  };
  for (std::size_t m = 0; m < moments; ++m) {
    const double time = time_of(2 * window.first + m);
    while (!first && near + 1 < 2 * old.last && time_of(near + 1) < time - heat::kDay_s) ++near;
    const double step_s = first ? 1.0 : time_of(near + 1) - time_of(near);
    const double share = first ? 0.0 : std::clamp((time - heat::kDay_s - time_of(near)) / step_s, 0.0, 1.0);
    for (const Given& given : all_given) {
      const double kelvin_here = scene_.given_k(given.facet, time);
      receiver_k_[m * receivers + given.receiver] = kelvin_here;
      given_[m * patches + units_.exchange.patch_of[given.receiver]] +=
          emission_[given.receiver] * std::pow(kelvin_here, 4);
    }
    const double of_air = std::pow(scene_.surroundings.air_k[window.first + m / 2], 4);
    for (std::size_t p = 0; p < patches; ++p) {
      double& value = emitted_[m * patches + p];
      if (first) {  // a guess: everything is as warm as the air
        value = emission[p] * of_air;
      } else {  // the day before
        const std::size_t from = (near - 2 * old.first) * patches + p;
        const auto then = [&](const std::vector<double>& of) {
          return of[from] + share * (of[from + patches] - of[from]);
        };
        value = sampled_share_[p] > 0.0 ? then(emitted) : 0.0;
        beyond_sample_[m * patches + p] = then(beyond);
      }
      value += given_[m * patches + p];
    }
  }
  const PatchScene patch = patch_scene();
  fill_solar(patch, light_);
  for (Batch& batch : batches_)
    for (Group* group : {&batch.all, &batch.sample, &batch.promise}) set_forcing(*group, batch);
}

void HeatBatches::set_forcing(Group& group, const Batch& batch) {
  ForcedUnits forced{{}, window_.first, window_.last};
  for (const std::uint32_t i : group.unit) forced.unit.push_back(&units_.unit[i]);
  group.forcing = forcing_of(std::move(forced), units_, scene_.surroundings, ground_, light_,
                             scene_.material[batch.material], scene_.input.start_s);
}

heat::Plan HeatBatches::make_plan_of(const Batch& batch) {
  // Made for the whole run, whose later days may be clearer; only the exchange is that of the first day.
  const std::size_t last = scene_.surroundings.nodes() - 1;
  ForcedUnits forced{{}, 0, last};
  for (const std::uint32_t i : batch.sample.unit) forced.unit.push_back(&units_.unit[i]);
  return make_plan(batch.sample.heat,
                   forcing_of(std::move(forced), units_, scene_.surroundings, ground_, light_,
                              scene_.material[batch.material], scene_.input.start_s),
                   timeline(0, last, Pace::fine), heat::RepeatingStart{heat::kDay_s}, batch.wanted_k);
}

void HeatBatches::make_plans() {
  mtf::parallel_for_each(static_cast<std::int64_t>(batches_.size()), 1, threads_, [&](std::size_t b) {
    if (!batches_[b].sample.plan) batches_[b].sample.plan = make_plan_of(batches_[b]);
  });
}

heat::Run HeatBatches::run(Batch& batch, Group& group, int days, heat::Runs runs, Pace pace,
                           const heat::OutputSink& sink) {
  if (!group.plan) {
    if (!batch.sample.plan) batch.sample.plan = make_plan_of(batch);
    group.plan = batch.sample.plan;
    group.plan->batch = group.heat;
  }
  const heat::Timeline line = timeline(window_.first, window_.last, pace);
  heat::Plan& plan = *group.plan;
  const double step_tolerance_k = plan.step_tolerance_k;
  if (pace == Pace::coarse)
    plan.step_tolerance_k = std::max(step_tolerance_k, std::min(kCoarseStepShare * tolerance_k_, kCoarseStep_k));
  // A plan that was made anew has other cells: then the state is found from nothing.
  if (days == 0 && group.begin.fine.size() != plan.fine.nodes() * group.unit.size())
    this->run(batch, group, kStartDays, runs, pace);
  heat::Run run;
  if (days > 0) {
    heat::PeriodicStart repeating =
        periodic_start(plan, group.forcing, line, kStartShare * tolerance_k_, days, threads_, runs, sink);
    group.begin = std::move(repeating.state);
    group.slopes = std::move(repeating.slopes);
    run = std::move(repeating.last);
  } else {
    run = advance(plan, group.begin, group.forcing, line, threads_, sink);
  }
  plan.step_tolerance_k = step_tolerance_k;
  group.end = run.end;
  add(batch.run.steps, run.steps);
  return run;
}

void HeatBatches::promise(Batch& batch, bool first) {
  heat::Promise promised;
  for (int i = 0;; ++i) {
    if (first) run(batch, batch.promise, 2, heat::Runs::three, Pace::fine);
    const heat::Run three = run(batch, batch.promise, 0, heat::Runs::three, Pace::fine);
    promised = three.promised;
    promised.steps_k *= kStepsFactor;
    batch.run.drift = std::max(batch.run.drift, worst_drift(three.balance));
    // Plans are made by trial on a few units; where another one breaks the promise, a finer plan is made.
    if (!first || promised.total_k() <= tolerance_k_ || i == 4) break;
    batch.wanted_k *= 0.7 * tolerance_k_ / promised.total_k();
    for (Group* group : {&batch.sample, &batch.promise, &batch.all}) group->plan.reset();
  }
  batch.promise.begin = std::move(batch.promise.end);
  batch.run.nodes = batch.promise.plan->fine.nodes();
  batch.run.promised = worse(batch.run.promised, promised);
}

std::vector<double> HeatBatches::run_sample(int days, Pace pace) {
  const std::size_t patches = units_.exchange.patches();
  std::vector<double> emitted(light_.moments() * patches, 0.0);
  for (Batch& batch : batches_) {
    Group& group = batch.sample;
    add_emitted(group, run(batch, group, days, heat::Runs::one, pace), emitted);
    // The first day repeats itself: the next iteration begins where this one ended.
    if (window_.first == 0 && days == 0) {
      group.begin = group.end;
      group.begin.time_s = scene_.surroundings.time_s[window_.first];
    }
  }
  for (std::size_t e = 0; e < emitted.size(); ++e) {
    const double share = sampled_share_[e % patches];
    emitted[e] = (share > 0.0 ? emitted[e] / share : 0.0) + given_[e];
  }
  return emitted;
}

void HeatBatches::run_all(int days, Pace pace) {
  for (Batch& batch : batches_) run(batch, batch.all, days, heat::Runs::one, pace, keeper_of(batch.all.unit));
}

void HeatBatches::run_again(const std::vector<std::vector<std::uint32_t>>& places,
                            const std::vector<heat::State>& steps) {
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    if (places[b].empty()) continue;
    Batch& batch = batches_[b];
    Group some;
    some.heat.construction = batch.all.heat.construction;
    some.heat.facets = places[b].size();
    for (const std::uint32_t place : places[b]) {
      some.unit.push_back(batch.all.unit[place]);
      some.heat.up.push_back(batch.all.heat.up[place]);
    }
    set_forcing(some, batch);
    some.plan = batch.all.plan;
    some.plan->batch = some.heat;
    some.begin = picked(batch.all.begin, places[b]);
    if (!steps.empty()) {  // this day repeats itself
      const heat::State step = picked(steps[b], places[b]);
      for (std::size_t i = 0; i < step.fine.size(); ++i) some.begin.fine[i] += step.fine[i];
    }
    run(batch, some, 0, heat::Runs::one, Pace::fine, keeper_of(some.unit));
    put_back(some.begin, places[b], batch.all.begin);
    put_back(some.end, places[b], batch.all.end);
  }
}

std::vector<MaterialRun> HeatBatches::materials() const {
  std::vector<MaterialRun> runs;
  for (const Batch& batch : batches_) runs.push_back(batch.run);
  return runs;
}

void damaged_checkpoint() {
  throw mtf::RuntimeError("the state of an interrupted run is damaged; --anew begins again and replaces it");
}

SavedBatches HeatBatches::save() const {
  SavedBatches saved{window_, emitted_, beyond_sample_, {}};
  for (const Batch& batch : batches_) {
    const heat::Plan& plan = *batch.all.plan;
    saved.batch.push_back({batch.wanted_k, batch.run, plan.fine, plan.coarse, plan.request, plan.step_tolerance_k,
                           plan.depth_k, batch.all.begin, batch.sample.begin, batch.promise.begin});
  }
  return saved;
}

void HeatBatches::restore(const SavedBatches& saved, const Window& window) {
  const std::size_t moments = 2 * (window.last - window.first) + 1, size = moments * units_.exchange.patches();
  if (saved.batch.size() != batches_.size() || saved.window.first != window.first || saved.window.last != window.last ||
      saved.emitted.size() != size || saved.beyond_sample.size() != size)
    damaged_checkpoint();
  window_ = saved.window;
  emitted_ = saved.emitted;
  beyond_sample_ = saved.beyond_sample;
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    Batch& batch = batches_[b];
    const SavedBatch& from = saved.batch[b];
    for (const heat::Grid* grid : {&from.fine, &from.coarse})
      if (!is_whole(*grid, batch.all.heat.construction)) damaged_checkpoint();
    if (!fits(from.all, from, batch.all.unit.size()) || !fits(from.sample, from, batch.sample.unit.size()) ||
        !fits(from.promise, from, batch.promise.unit.size()))
      damaged_checkpoint();
    batch.wanted_k = from.wanted_k;
    batch.run = from.run;
    for (Group* group : {&batch.all, &batch.sample, &batch.promise})
      group->plan = heat::Plan{group->heat, from.fine, from.coarse, from.request, from.step_tolerance_k, from.depth_k};
    batch.all.begin = from.all;
    batch.sample.begin = from.sample;
    batch.promise.begin = from.promise;
  }
}

}  // namespace radiometry::thermal
