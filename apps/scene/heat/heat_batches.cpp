// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/heat_batches.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/heat/solve.h"
#include "radiometry/heat/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;
constexpr int kMostIterations = 60;
constexpr int kStarts = 2;
constexpr double kPlanShare = 0.5;   // of the tolerance: plans are made by trial, other units and days may need more
constexpr double kStartShare = 0.2;  // of the tolerance: what the state at the start may change in a day

heat::Timeline timeline_of(const Surroundings& s, const Window& window) {
  const auto first = s.time_s.begin() + static_cast<std::ptrdiff_t>(window.first);
  const std::vector<double> nodes(first, s.time_s.begin() + static_cast<std::ptrdiff_t>(window.last) + 1);
  return {nodes.front(), nodes.back(), nodes, nodes};
}

/// The larger of two promises, part by part.
heat::Promise worse(const heat::Promise& a, const heat::Promise& b) {
  return {std::max(a.steps_k, b.steps_k), std::max(a.grid_k, b.grid_k), std::max(a.depth_k, b.depth_k)};
}

double worst_drift(const std::vector<heat::HeatBalance>& balances) {
  double worst = 0.0;
  for (const heat::HeatBalance& balance : balances) worst = std::max(worst, balance.relative_drift());
  return worst;
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
    : scene_(scene), units_(units), ground_(ground), tolerance_k_(tolerance_k), threads_(threads) {
  for (std::size_t i = 0; i < units.unit.size(); ++i) {
    const Unit& unit = units.unit[i];
    if (unit.given) continue;
    if (batches_.empty() || batches_.back().material != *unit.material) {
      Batch batch;
      batch.first = i;
      batch.material = *unit.material;
      batch.run.name = scene.material[batch.material].name;
      batch.heat.construction = scene.material[batch.material].construction;
      batches_.push_back(std::move(batch));
    }
    ++batches_.back().units;
    batches_.back().heat.up.push_back(std::clamp(unit.front.normal[2], -1.0, 1.0));
  }
  for (Batch& batch : batches_) {
    batch.heat.facets = batch.run.units = batch.units;
    batch.wanted_k = kPlanShare * tolerance_k;
    batch.forcing =
        forcing_of(std::span(units.unit).subspan(batch.first, batch.units), units, scene.surroundings, ground, solar_,
                   longwave_, scene.material[batch.material].inside, scene.file.time.start_s);
  }
}

double HeatBatches::update_exchange() {
  const std::size_t receivers = units_.exchange.receivers();
  std::vector<double> change(longwave_.nodes(), 0.0);
  mtf::parallel_for(static_cast<std::int64_t>(change.size()), 1, threads_, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> before(receivers);
    for (std::int64_t k = begin; k < end; ++k) {
      const auto row = static_cast<std::size_t>(k);
      const std::span<float> irradiance = longwave_.row(window_.first + row);
      std::copy(irradiance.begin(), irradiance.end(), before.begin());
      longwave_exchange(units_, scene_.surroundings, ground_, window_.first + row,
                        std::span(receiver_k_).subspan(row * receivers, receivers), irradiance);
      for (std::size_t i = 0; i < receivers; ++i)
        change[row] = std::max(change[row], static_cast<double>(std::abs(irradiance[i] - before[i])));
    }
  });
  return *std::max_element(change.begin(), change.end());
}

void HeatBatches::set_window(const Window& window, bool first) {
  const std::vector<double>& times = scene_.surroundings.time_s;
  const std::size_t receivers = units_.exchange.receivers();
  const std::vector<double> before = std::move(receiver_k_);
  const Window old = window_;
  window_ = window;
  receiver_k_.assign((window.last + 1 - window.first) * receivers, 0.0);
  std::size_t near = old.first;  // a guess: the temperatures of a day before
  for (std::size_t k = window.first; k <= window.last; ++k) {
    if (first) {
      std::fill_n(&kelvin(k, 0), receivers, scene_.surroundings.air_k[k]);
    } else {
      while (near < old.last && times[near] < times[k] - heat::kDay_s) ++near;
      std::copy_n(before.begin() + static_cast<std::ptrdiff_t>((near - old.first) * receivers), receivers,
                  &kelvin(k, 0));
    }
    for (const Unit& unit : units_.unit)
      if (unit.given) kelvin(k, unit.receiver) = scene_.given_k(unit.leader, times[k]);
  }
  solar_ = make_receiver_table(window.first, window.last, receivers);
  longwave_ = solar_;
  fill_solar_exchange(units_, scene_.surroundings, ground_, threads_, solar_);
}

void HeatBatches::start(Batch& batch, const heat::Timeline& day) {
  // Made for the whole run, whose later days may be clearer; only the exchange is that of the first day.
  if (!batch.plan)
    batch.plan =
        make_plan(batch.heat, batch.forcing, timeline_of(scene_.surroundings, {0, scene_.surroundings.nodes() - 1}),
                  heat::RepeatingStart{heat::kDay_s}, batch.wanted_k);
  batch.begin = periodic_start(*batch.plan, batch.forcing, day, kStartShare * tolerance_k_, 8, threads_).state;
}

void HeatBatches::run(Batch& batch, const heat::Timeline& timeline, bool first) {
  heat::Run run = advance(*batch.plan, batch.begin, batch.forcing, timeline, threads_);
  // Plans are made by trial on a few units; where another one breaks the promise, a finer plan is made.
  for (int i = 0; first && run.promised.total_k() > tolerance_k_ && i < 4; ++i) {
    batch.wanted_k *= 0.7 * tolerance_k_ / run.promised.total_k();
    batch.plan.reset();
    start(batch, timeline);
    run = advance(*batch.plan, batch.begin, batch.forcing, timeline, threads_);
  }
  batch.end = run.end;
  batch.promised = run.promised;
  batch.drift = worst_drift(run.balance);
  batch.run.nodes = batch.plan->fine.nodes();
  batch.run.steps.taken += run.steps.taken;
  batch.run.steps.refused += run.steps.refused;
  batch.run.steps.facet_steps += run.steps.facet_steps;
  if (first) {
    batch.run.start_residual_k = 0.0;
    for (std::size_t i = 0; i < run.end.fine.size(); ++i)
      batch.run.start_residual_k =
          std::max(batch.run.start_residual_k, std::abs(run.end.fine[i] - batch.begin.fine[i]));
  }
  for (std::size_t k = 0; k < run.outputs_s.size(); ++k)
    for (std::size_t i = 0; i < batch.units; ++i) {
      const Unit& unit = units_.unit[batch.first + i];
      kelvin(window_.first + k, unit.receiver) = run.front_k[k * batch.units + i];
      if (unit.has_own_back()) kelvin(window_.first + k, unit.back_receiver) = run.back_k[k * batch.units + i];
    }
}

double HeatBatches::line_error() const {
  const std::vector<double>& times = scene_.surroundings.time_s;
  const std::size_t receivers = units_.exchange.receivers();
  std::vector<float> off(receivers, 0.0F), off_before(receivers, std::numeric_limits<float>::infinity());
  float worst = 0.0F;
  for (std::size_t k = window_.first + 1; k < window_.last; ++k) {
    const auto share = static_cast<float>((times[k] - times[k - 1]) / (times[k + 1] - times[k - 1]));
    const std::span<const float> before = longwave_.row(k - 1), here = longwave_.row(k), after = longwave_.row(k + 1);
    for (std::size_t i = 0; i < receivers; ++i) {
      off[i] = std::abs(here[i] - before[i] - share * (after[i] - before[i]));
      worst = std::max(worst, std::min(off[i], off_before[i]));
    }
    std::swap(off, off_before);
  }
  return 0.25 * static_cast<double>(worst);
}

Relaxed HeatBatches::solve(const Window& window, bool first, double tolerance_k, double loss_w_m2_k,
                           double ratio_bound) {
  set_window(window, first);
  update_exchange();
  const heat::Timeline timeline = timeline_of(scene_.surroundings, window);
  Relaxed relaxed;
  double last = 1.0;
  for (;;) {
    for (Batch& batch : batches_) {
      // The first day repeats itself: its start is found anew while the exchange still changes, and where it does not
      // repeat yet; then it is run again from where it ended.
      if (first && (relaxed.iterations < kStarts || batch.run.start_residual_k > kStartShare * tolerance_k_))
        start(batch, timeline);
      else if (first) {
        batch.begin = std::move(batch.end);
        batch.begin.time_s = timeline.start_s;
      }
      run(batch, timeline, first);
    }
    ++relaxed.iterations;
    const double change = update_exchange() / loss_w_m2_k;
    // A change becomes smaller by the ratio at least with every iteration; it may do so faster than the bound says.
    const double ratio = relaxed.iterations > 2 ? std::min(ratio_bound, change / last) : ratio_bound;
    relaxed.error_k = change / (1.0 - std::clamp(ratio, 0.0, 0.99));
    if (relaxed.error_k <= tolerance_k) break;
    if (relaxed.iterations == kMostIterations)
      throw mtf::RuntimeError("the exchange of radiation between surfaces has an error of " +
                              significant(relaxed.error_k, 2) + " K after " + plural(kMostIterations, "iteration") +
                              "; ask for a larger tolerance");
    last = change;
  }
  relaxed.error_k += line_error() / loss_w_m2_k;
  for (Batch& batch : batches_) {
    batch.begin = std::move(batch.end);
    batch.run.promised = worse(batch.run.promised, batch.promised);
    batch.run.drift = std::max(batch.run.drift, batch.drift);
  }
  return relaxed;
}

std::vector<MaterialRun> HeatBatches::materials() const {
  std::vector<MaterialRun> runs;
  for (const Batch& batch : batches_) runs.push_back(batch.run);
  return runs;
}

}  // namespace apps::scene
