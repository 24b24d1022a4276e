// SPDX-License-Identifier: Apache-2.0

// The exchange of radiation between units, by iteration: see heat_batches.h.

#include <algorithm>
#include <cmath>
#include <utility>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/words.h"
#include "radiometry/thermal/heat_batches.h"

namespace radiometry::thermal {
namespace {

constexpr int kMostIterations = 60;
constexpr int kStarts = 2;             // iterations of the sample that find the state which repeats anew
constexpr int kMostRounds = 20;        // solutions of units
constexpr double kAgainShare = 0.6;    // of what is allowed: with more a unit is solved again, once another has to be
constexpr double kSampleShare = 0.25;  // of what is allowed: where the iteration of the sample ends

constexpr double kGuessShare = 0.02;  // of what its first iteration changed: where it ends with coarse plans

/// How far the begin of a facet is from the state that repeats: Newton's step, and all that would follow it where steps
/// become smaller as the last two did (periodic.h), by half at most.
struct StartError {
  double step_k = 0.0, error_k = 0.0;

  void update(const heat::State& step, std::size_t facet) {
    constexpr double kLeast = 2.0, kMost = 10.0;
    const double last_k = std::exchange(step_k, 0.0);
    for (std::size_t at = facet; at < step.fine.size(); at += step.facets)
      step_k = std::max(step_k, std::abs(step.fine[at]));
    const double left = last_k > 0.0 ? 1.0 - step_k / last_k : 1.0;
    error_k = step_k * (left > 1.0 / kMost ? std::max(1.0 / left, kLeast) : kMost);
  }
};

}  // namespace

void HeatBatches::add_emitted(const Group& group, const heat::Run& run, std::vector<double>& emitted) const {
  const scene::Exchange& exchange = units_.exchange;
  const std::size_t patches = exchange.patches(), units = group.unit.size();
  mtf::parallel_for_each(static_cast<std::int64_t>(light_.moments()), 8, threads_, [&](std::size_t m) {
    for (std::size_t i = 0; i < units; ++i) {
      const Unit& unit = units_.unit[group.unit[i]];
      const auto side = [&](std::size_t r, double kelvin_here) {
        const double square = kelvin_here * kelvin_here;
        emitted[m * patches + exchange.patch_of[r]] += emission_[r] * square * square;
      };
      side(unit.receiver, run.front_k[m * units + i]);
      if (unit.has_own_back()) side(unit.back_receiver, run.back_k[m * units + i]);
    }
  });
}

heat::OutputSink HeatBatches::keeper_of(const std::vector<std::uint32_t>& units) {
  return [&units, this](std::size_t moment, std::size_t first, std::span<const double> front,
                        std::span<const double> back) {
    double* kelvin = receiver_k_.data() + moment * units_.exchange.receivers();
    for (std::size_t i = 0; i < front.size(); ++i) {
      const Unit& unit = units_.unit[units[first + i]];
      kelvin[unit.receiver] = front[i];
      if (!back.empty() && unit.has_own_back()) kelvin[unit.back_receiver] = back[i];
    }
  };
}

std::vector<double> HeatBatches::emitted_by_all() const {
  const scene::Exchange& exchange = units_.exchange;
  const std::size_t patches = exchange.patches();
  std::vector<double> emitted(light_.moments() * patches, 0.0);
  mtf::parallel_for_each(static_cast<std::int64_t>(light_.moments()), 8, threads_, [&](std::size_t m) {
    const double* kelvin = receiver_k_.data() + m * exchange.receivers();
    for (std::size_t p = 0; p < patches; ++p) {
      double sum = 0.0;
      for (std::uint32_t i = emitting_.first[p]; i < emitting_.first[p + 1]; ++i) {
        const double square = kelvin[emitting_.receiver[i]] * kelvin[emitting_.receiver[i]];
        sum += emitting_.emission[i] * square * square;
      }
      emitted[m * patches + p] = sum;
    }
  });
  return emitted;
}

std::vector<double> HeatBatches::patch_radiosity(std::size_t node) const {
  const PatchTable& table = light_.longwave;
  const std::size_t moment = 2 * (node - window_.first);
  std::vector<double> radiosity;
  for (std::size_t p = 0; p < units_.exchange.patches(); ++p)
    radiosity.push_back(table.reference_w_m2[moment] +
                        static_cast<double>(table.radiosity[p * table.moments + moment]));
  return radiosity;
}

void HeatBatches::relax_sample(bool first, const Exchange& exchange, Pace pace) {
  const PatchScene patch = patch_scene();
  double last = 0.0, enough_k = kSampleShare * exchange.tolerance_k;
  for (int iteration = 1;; ++iteration) {
    const std::vector<double> emitted = run_sample(first && samples_ < kStarts ? kStarts : 0, pace);
    ++samples_;
    for (std::size_t e = 0; e < emitted.size(); ++e) emitted_[e] = emitted[e] + beyond_sample_[e];
    const PatchTable before = light_.longwave;
    fill_longwave(patch, emitted_, light_);
    const double most = largest_change(patch, before, light_.longwave, sampled_receivers_) / exchange.loss_w_m2_k;
    if (iteration == 1 && pace == Pace::coarse) enough_k = std::max(enough_k, kGuessShare * most);
    // A change becomes smaller by the ratio at least with every iteration; it may do so faster than the bound says.
    const double ratio =
        iteration > 2 && last > 0.0 ? std::min(exchange.ratio_bound, most / last) : exchange.ratio_bound;
    const double error = most / (1.0 - std::clamp(ratio, 0.0, 0.99));
    if (error <= enough_k && (!first || samples_ > kStarts)) return;
    if (iteration == kMostIterations)
      throw mtf::RuntimeError("the exchange of radiation between surfaces has an error of " +
                              mtf::significant(error, 2) + " K after " + mtf::plural(kMostIterations, "iteration") +
                              "; ask for a larger tolerance");
    last = most;
  }
}

void HeatBatches::guess_exchange(bool first, const Exchange& exchange) {
  const PatchScene patch = patch_scene();
  relax_sample(first, exchange, Pace::coarse);
  double last = 0.0;
  for (int pass = 1;; ++pass) {
    // Both in the same way: the first time by a day that finds the state which repeats, then from where that ended.
    const int days = first && pass == 1 ? 1 : 0;
    const std::vector<double> sample = run_sample(days, Pace::coarse);
    run_all(days, Pace::coarse);
    if (first && pass > 1)  // the first day repeats itself
      for (Batch& batch : batches_) {
        batch.all.begin = batch.all.end;
        batch.all.begin.time_s = scene_.surroundings.time_s[window_.first];
      }
    const std::vector<double> all = emitted_by_all();
    for (std::size_t e = 0; e < all.size(); ++e) beyond_sample_[e] = all[e] - sample[e];
    const PatchTable before = light_.longwave;
    relax_sample(first, exchange, Pace::coarse);
    const double most = largest_change(patch, before, light_.longwave, sampled_receivers_) / exchange.loss_w_m2_k;
    // What the next pass would change, by how this one changed less than the last; or none comes nearer.
    const double ratio = pass > 1 ? most / last : 1.0;
    if (ratio * most <= exchange.tolerance_k || (pass > 1 && ratio > 0.5)) return;
    last = most;
  }
}

std::vector<double> HeatBatches::changes_of_units(const std::vector<PatchTable>& of_round,
                                                  const std::vector<std::uint8_t>& round_of) const {
  std::vector<double> of_unit(units_.unit.size(), 0.0);
  for (std::size_t round = 0; round < of_round.size(); ++round) {
    std::vector<std::uint32_t> units, receivers;
    for (const Batch& batch : batches_)
      for (const std::uint32_t u : batch.all.unit) {
        if (round_of[u] != round) continue;
        units.push_back(u);
        receivers.push_back(static_cast<std::uint32_t>(units_.unit[u].receiver));
        if (units_.unit[u].back) receivers.push_back(static_cast<std::uint32_t>(units_.unit[u].back_receiver));
      }
    const std::vector<double> change = changes(patch_scene(), of_round[round], light_.longwave, receivers);
    for (const std::uint32_t u : units) {
      const Unit& unit = units_.unit[u];
      of_unit[u] = std::max(change[unit.receiver], unit.back ? change[unit.back_receiver] : 0.0);
    }
  }
  return of_unit;
}

Relaxed HeatBatches::solve(const Window& window, bool first, double tolerance_k, double loss_w_m2_k,
                           double ratio_bound) {
  set_window(window, first);
  const PatchScene patch = patch_scene();
  fill_longwave(patch, emitted_, light_);
  make_plans();
  const Exchange exchange{tolerance_k, loss_w_m2_k, ratio_bound};
  guess_exchange(first, exchange);
  relax_sample(first, exchange, Pace::fine);
  for (Batch& batch : batches_) promise(batch, first);

  // All units; then those again that saw another light than this one comes to, or whose day does not repeat.
  run_all(0, Pace::fine);
  Relaxed relaxed{.iterations = 1, .error_k = 0.0};
  std::vector<PatchTable> of_round{light_.longwave};          // with which units were solved
  std::vector<std::uint8_t> round_of(units_.unit.size(), 0);  // the last one in which each of them was
  std::vector<StartError> start(units_.unit.size());          // of the first day, which repeats itself
  for (;; ++relaxed.iterations) {
    const std::vector<double> all = emitted_by_all();
    for (std::size_t e = 0; e < all.size(); ++e) {
      beyond_sample_[e] += all[e] - emitted_[e];
      emitted_[e] = all[e];
    }
    fill_longwave(patch, emitted_, light_);
    const std::vector<double> change = changes_of_units(of_round, round_of);
    relaxed.error_k = 0.0;
    std::vector<std::vector<std::uint32_t>> places(batches_.size());
    bool enough = true;
    std::vector<heat::State> steps;
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch& batch = batches_[b];
      if (first) {
        batch.run.promised.start_k = 0.0;
        steps.push_back(newton_step(*batch.all.plan, batch.all.slopes, batch.all.begin, batch.all.end, threads_));
      }
      for (std::uint32_t place = 0; place < batch.all.unit.size(); ++place) {
        const std::uint32_t u = batch.all.unit[place];
        const double error_k = change[u] / loss_w_m2_k / (1.0 - std::clamp(ratio_bound, 0.0, 0.99));
        if (first && round_of[u] + 1U == of_round.size()) start[u].update(steps[b], place);
        const double start_k = start[u].error_k;
        relaxed.error_k = std::max(relaxed.error_k, error_k);
        if (first) batch.run.promised.start_k = std::max(batch.run.promised.start_k, start_k);
        const double part = std::max(error_k / tolerance_k, start_k / (kStartShare * tolerance_k_));
        enough = enough && part <= 1.0;
        if (part <= kAgainShare) continue;
        places[b].push_back(place);
        round_of[u] = static_cast<std::uint8_t>(of_round.size());
      }
    }
    if (enough) break;
    if (relaxed.iterations == kMostRounds)
      throw mtf::RuntimeError("the exchange of radiation between surfaces has an error of " +
                              mtf::significant(relaxed.error_k, 2) + " K after " +
                              mtf::plural(kMostRounds, "solution") + "; ask for a larger tolerance");
    relax_sample(first, exchange, Pace::fine);
    run_again(places, steps);
    of_round.push_back(light_.longwave);
  }
  relaxed.error_k += parabola_error(patch, light_, solved_receivers_) / loss_w_m2_k;
  for (Batch& batch : batches_) {
    batch.all.begin = std::move(batch.all.end);
    batch.sample.begin = std::move(batch.sample.end);
    batch.sample.begin.time_s = batch.all.begin.time_s;
  }
  return relaxed;
}

}  // namespace radiometry::thermal
