// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/units.h"
#include "radiometry/heat/lanes.h"
#include "radiometry/heat/surface_loss.h"

namespace radiometry::heat {
namespace {

// TR-BDF2 for a group of facets: a trapezoidal stage to t + gamma h, then the second-order backward difference to
// t + h, gamma = 2 - sqrt(2), so that both stages have the matrix M + a K with a = gamma h / 2 (Bank et al., IEEE
// Trans. Electron Devices 32, 1992, 1985; Hosea & Shampine, Appl. Numer. Math. 20, 21, 1996, for the embedded error
// estimate of third order, smoothed by one more solution with that matrix). It is L-stable: what is faster than a step
// dies out.
//   M (T_(n+1) - T_n) = h [w F_n + w F_g + d F_(n+1)],  w = sqrt(2)/4, d = gamma/2
// so the heat of a step is the sum of the flows at the three instants with these weights, to rounding.

constexpr double kGamma = 0.58578643762690495120;  ///< 2 - sqrt(2)

/// Eliminations of one grid by the length of the step.
class Eliminations {
 public:
  Eliminations(const Grid& grid, bool sheet) : grid_(&grid), sheet_(sheet) {}
  const Elimination<double>& of_step(double step_s) {
    const auto found = of_step_.find(step_s);
    if (found != of_step_.end()) return found->second;
    return of_step_.emplace(step_s, eliminate(*grid_, sheet_, 0.5 * kGamma * step_s)).first->second;
  }
  /// Forgets all when there are too many; references end.
  void limit() {
    constexpr std::size_t kMostEliminations = 1024;
    if (of_step_.size() > kMostEliminations) of_step_.clear();
  }

 private:
  const Grid* grid_;
  bool sheet_;
  std::map<double, Elimination<double>> of_step_;
};

/// Temperatures of a group on one grid, and what a step leaves.
struct GroupState {
  explicit GroupState(std::size_t nodes) : t(nodes * kLanes), first(nodes * kLanes), second(t), scratch(t) {}
  std::vector<double> t;              ///< K
  std::vector<double> first, second;  ///< increments of the two stages of the last step
  std::vector<double> scratch;
};

/// The boundaries at the three instants of a step: t, t + gamma h and t + h.
struct StepBoundaries {
  const Boundary *begin, *middle, *end;
};

/// M D2 = kKeep M D1 + a F_(n+1)
constexpr double kKeep = (1.0 - kGamma) * (1.0 - kGamma) / (kGamma * (2.0 - kGamma));

// 2 k h [F_n / gamma - F_g / (gamma (1 - gamma)) + F_(n+1) / (1 - gamma)] with h = 2 a / gamma,
// a F_g = M D1 - a F_n and a F_(n+1) = M (D2 - kKeep D1).
constexpr double kError = (-3.0 * kGamma * kGamma + 4.0 * kGamma - 2.0) / (12.0 * (2.0 - kGamma)) * 4.0 / kGamma;
constexpr ErrorWeights kErrorWeights{.of_flow = kError * (1.0 / kGamma + 1.0 / (kGamma * (1.0 - kGamma))),
                                     .of_first = -kError * (1.0 / (kGamma * (1.0 - kGamma)) + kKeep / (1.0 - kGamma)),
                                     .of_second = kError / (1.0 - kGamma)};

/// `heat`: the heat over the boundaries is added there, unless it is null.
void take_step(const GroupGrid& group, const Elimination<double>& elimination, const StepBoundaries& boundaries,
               GroupState& state, HeatSums* heat) {
  const double outer = (1.0 + kKeep) * elimination.a;  // w h
  if (heat) add_heat(group, *boundaries.begin, state.t, outer, *heat);
  run_stage(group, {&elimination, 0.0, boundaries.begin, boundaries.middle}, state.t, state.first, state.scratch);
  if (heat) add_heat(group, *boundaries.middle, state.t, outer, *heat);
  std::copy(state.first.begin(), state.first.end(), state.second.begin());
  run_stage(group, {&elimination, kKeep, nullptr, boundaries.end}, state.t, state.second, state.scratch);
  if (heat) add_heat(group, *boundaries.end, state.t, elimination.a, *heat);
}

/// The error of the step that was just taken from the temperatures `before`, K: the largest of the lanes.
double step_error(const GroupGrid& group, const Elimination<double>& elimination, const Boundary& begin,
                  const std::vector<double>& before, GroupState& after) {
  return surface_error(group, elimination, kErrorWeights, begin, before, after.first, after.second, after.scratch);
}

// One group of facets over time: the three runs of solver.h side by side, with steps that all lanes share.

/// Positions in an interval between breaks count in 2^-kFinest of it. A step is the interval halved a number of times,
/// so intervals of equal length share their eliminations.
constexpr int kFinest = 48;
constexpr std::int64_t kWhole = std::int64_t{1} << kFinest;
constexpr double kUnit = 1.0 / static_cast<double>(kWhole);

/// The film of tarp goes with the root of the wind, which has no Taylor series where the wind comes from 0 or falls to
/// 0: the film changes by less than this factor in a step, but where the step is a small part of the interval.
constexpr double kFilmFactor = 2.0;
constexpr std::int64_t kSmallPart = kWhole >> 10;

bool is_smooth(const Buoyancy& of_tarp, double film, double later) {
  return !of_tarp.present || film == later || std::max(film, later) <= kFilmFactor * std::min(film, later);
}

/// The error of a step falls with its third power; a step grows to at most four times the last.
double next_step(double step_s, double error_k, double tolerance_k) {
  const double ratio = 0.9 * std::cbrt(tolerance_k / std::max(error_k, 1e-12 * tolerance_k));
  return step_s * std::clamp(ratio, 1.0 / 16.0, 4.0);
}

void gather(const std::vector<double>& all, std::size_t facets, std::size_t first, std::size_t count,
            std::vector<double>& lanes) {
  for (std::size_t i = 0; i < lanes.size() / kLanes; ++i)
    for (std::size_t l = 0; l < kLanes; ++l) lanes[i * kLanes + l] = all[i * facets + first + std::min(l, count - 1)];
}

void scatter(const std::vector<double>& lanes, std::size_t facets, std::size_t first, std::size_t count,
             std::vector<double>& all) {
  for (std::size_t i = 0; i < lanes.size() / kLanes; ++i)
    std::copy_n(lanes.begin() + static_cast<std::ptrdiff_t>(i * kLanes), count,
                all.begin() + static_cast<std::ptrdiff_t>(i * facets + first));
}

Buoyancy buoyancy_of(const Convection& convection, const Batch& batch, std::size_t first, std::size_t count,
                     double side) {
  Buoyancy buoyancy{.present = std::holds_alternative<Tarp>(convection)};
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double up = batch.up.empty() ? 0.0 : batch.up[first + std::min(l, count - 1)];
    const NaturalConvection natural = natural_coefficient(convection, side * up);
    buoyancy.warm[l] = natural.warm;
    buoyancy.cold[l] = natural.cold;
  }
  return buoyancy;
}

GroupGrid group_grid(const Grid& grid, const Construction& construction, const Buoyancy& front, const Buoyancy& back) {
  const Sides sides = !construction.is_sheet() ? Sides::one : grid.nodes() == 1 ? Sides::two_on_one_node : Sides::two;
  return {&grid, sides, std::holds_alternative<InnerFlux>(construction.inside), construction.is_wet(), &front, &back};
}

/// The eliminations that a thread keeps from group to group.
struct PlanEliminations {
  explicit PlanEliminations(const Plan& plan)
      : fine(plan.fine, plan.batch.construction.is_sheet()), coarse(plan.coarse, plan.batch.construction.is_sheet()) {}
  Eliminations fine, coarse;
};

/// Surface temperatures of the three runs; of Runs::one the last two are null.
struct Surfaces {
  const double *fine, *doubled, *coarse;  ///< kLanes each
};

/// An interval between breaks. Positions in it count in 2^-kFinest of its length.
struct Interval {
  double t0_s, t1_s;
  double length_s() const { return t1_s - t0_s; }
  Instant at(double position) const {
    if (position >= static_cast<double>(kWhole)) return {t1_s, Instant::Limit::before};
    return {t0_s + length_s() * (position / static_cast<double>(kWhole)), Instant::Limit::after};
  }
};

class GroupRun {
 public:
  /// Facets `first` and up to kLanes - 1 more of the batch.
  GroupRun(const Plan& plan, const State& start, const Forcing& forcing, std::size_t first, PlanEliminations& kept)
      : plan_(&plan),
        forcing_(&forcing),
        kept_(&kept),
        first_(first),
        count_(std::min(kLanes, plan.batch.facets - first)),
        three_(start.runs() == Runs::three),
        fine_(plan.fine.nodes()),
        doubled_(three_ ? plan.fine.nodes() : 0),
        coarse_(three_ ? plan.coarse.nodes() : 0),
        before_(plan.fine.nodes() * kLanes),
        wanted_s_(start.step_s[first / kLanes]) {
    const Construction& construction = plan.batch.construction;
    front_buoyancy_ = buoyancy_of(construction.convection, plan.batch, first, count_, 1.0);
    if (const auto* sheet = std::get_if<Sheet>(&construction.inside))
      back_buoyancy_ = buoyancy_of(sheet->convection, plan.batch, first, count_, -1.0);
    fine_grid_ = group_grid(plan.fine, construction, front_buoyancy_, back_buoyancy_);
    coarse_grid_ = group_grid(plan.coarse, construction, front_buoyancy_, back_buoyancy_);
    gather(start.fine, start.facets, first, count_, fine_.t);
    if (!three_) return;
    gather(start.doubled, start.facets, first, count_, doubled_.t);
    gather(start.coarse, start.facets, first, count_, coarse_.t);
  }

  /// Advances from t0 to t1, between which there is no break. `after_step` is called with the begin and the end of
  /// every step that was taken. Throws RuntimeError as advance does.
  void advance(double t0_s, double t1_s, const std::function<void(double, double)>& after_step) {
    const Interval interval{t0_s, t1_s};
    kept_->fine.limit();
    kept_->coarse.limit();
    evaluate(interval.at(0.0), begin_);
    for (std::int64_t at = 0; at < kWhole;) {
      std::int64_t step = kWhole;
      while (step > 2 && (step > kWhole - at || interval.length_s() * (static_cast<double>(step) * kUnit) > wanted_s_))
        step /= 2;
      if (step <= 2)
        throw mtf::RuntimeError("heat: no step keeps the tolerance at " +
                                mtf::format_double(interval.at(static_cast<double>(at)).time_s) +
                                " s: has the forcing a jump that is not in the breaks?");
      const double from = static_cast<double>(at), whole = static_cast<double>(step);
      if (!(three_ ? step_of_three(interval, from, whole) : step_of_one(interval, from, whole))) continue;
      std::swap(begin_, end_);
      at += step;
      after_step(interval.at(from).time_s, interval.at(from + whole).time_s);
    }
  }

  std::size_t count() const { return count_; }
  Surfaces front() const {
    return {fine_.t.data(), three_ ? doubled_.t.data() : nullptr, three_ ? coarse_.t.data() : nullptr};
  }
  Surfaces back() const {
    const auto last = [](const GroupState& state) { return state.t.data() + (state.t.size() - kLanes); };
    return {last(fine_), three_ ? last(doubled_) : nullptr, three_ ? last(coarse_) : nullptr};
  }
  /// Of Runs::one, within the last step: `share` of it is over. See Timeline::between_s.
  Lanes front_within(double share) const { return within(share, 0); }
  Lanes back_within(double share) const { return within(share, fine_.t.size() - kLanes); }
  const HeatSums& heat() const { return heat_; }
  const StepCount& steps() const { return steps_; }
  void store(State& end) const {
    scatter(fine_.t, end.facets, first_, count_, end.fine);
    end.step_s[first_ / kLanes] = wanted_s_;
    if (!three_) return;
    scatter(doubled_.t, end.facets, first_, count_, end.doubled);
    scatter(coarse_.t, end.facets, first_, count_, end.coarse);
  }

 private:
  /// One step of 2h by all runs, from `begin` at a position of an interval; false where it is refused.
  bool step_of_three(const Interval& interval, double from, double whole) {
    const double half = 0.5 * whole, step_s = interval.length_s() * (whole * kUnit);
    const Elimination<double>& long_step = kept_->fine.of_step(step_s);
    evaluate(interval.at(from + whole), end_);
    if (!is_short_enough(step_s, whole)) return false;
    evaluate(interval.at(from + kGamma * whole), doubled_middle_);
    before_ = doubled_.t;
    take_step(fine_grid_, long_step, {&begin_, &doubled_middle_, &end_}, doubled_, nullptr);
    steps_.facet_steps += static_cast<std::int64_t>(count_);
    const double error = step_error(fine_grid_, long_step, begin_, before_, doubled_);
    if (!accept(step_s, error)) {
      doubled_.t = before_;
      return false;
    }
    evaluate(interval.at(from + kGamma * half), early_);
    evaluate(interval.at(from + half), quarter_);
    evaluate(interval.at(from + half + kGamma * half), late_);
    const Elimination<double>& short_step = kept_->fine.of_step(0.5 * step_s);
    take_step(fine_grid_, short_step, {&begin_, &early_, &quarter_}, fine_, &heat_);
    take_step(fine_grid_, short_step, {&quarter_, &late_, &end_}, fine_, &heat_);
    take_step(coarse_grid_, kept_->coarse.of_step(step_s), {&begin_, &doubled_middle_, &end_}, coarse_, nullptr);
    steps_.facet_steps += 3 * static_cast<std::int64_t>(count_);
    return true;
  }
  bool step_of_one(const Interval& interval, double from, double whole) {
    const double step_s = interval.length_s() * (whole * kUnit);
    const Elimination<double>& elimination = kept_->fine.of_step(step_s);
    evaluate(interval.at(from + whole), end_);
    if (!is_short_enough(step_s, whole)) return false;
    evaluate(interval.at(from + kGamma * whole), doubled_middle_);
    before_ = fine_.t;
    take_step(fine_grid_, elimination, {&begin_, &doubled_middle_, &end_}, fine_, nullptr);
    steps_.facet_steps += static_cast<std::int64_t>(count_);
    if (accept(step_s, step_error(fine_grid_, elimination, begin_, before_, fine_))) return true;
    fine_.t = before_;
    return false;
  }
  /// Whether the film changes little enough from begin_ to end_; else half the step is tried next.
  bool is_short_enough(double step_s, double whole) {
    if (whole <= static_cast<double>(kSmallPart) || (is_smooth(front_buoyancy_, begin_.front.film, end_.front.film) &&
                                                     is_smooth(back_buoyancy_, begin_.back.film, end_.back.film)))
      return true;
    wanted_s_ = 0.5 * step_s;
    ++steps_.refused;
    return false;
  }
  /// Whether a step of 2h with that error is taken, and the next one to try.
  bool accept(double step_s, double error_k) {
    wanted_s_ = next_step(step_s, error_k, plan_->step_tolerance_k);
    if (error_k <= plan_->step_tolerance_k) {
      ++steps_.taken;
      return true;
    }
    wanted_s_ = std::min(0.5 * step_s, wanted_s_);  // the first where the error is not a number
    ++steps_.refused;
    return false;
  }
  void evaluate(Instant instant, Boundary& boundary) const {
    const Construction& construction = plan_->batch.construction;
    const auto* sheet = std::get_if<Sheet>(&construction.inside);
    ForcingValues values;
    values.front.absorbed_w_m2 = {boundary.front.absorbed.at.data(), count_};
    if (sheet) values.back.absorbed_w_m2 = {boundary.back.absorbed.at.data(), count_};
    if (construction.generates) boundary.source_w_m3.resize(construction.layers.size());
    values.source_w_m3 = boundary.source_w_m3;
    (*forcing_)(instant, first_, values);

    double sum = values.inside;
    for (const double source : boundary.source_w_m3) sum += source;
    const auto take = [&](const SideForcing& from, double emissivity, const Convection& convection, double wet,
                          Surface& to) {
      to.emission = emissivity * kStefanBoltzmann_w_m2_k4;
      to.film = forced_coefficient(convection, from.wind_m_s);
      to.air_k = from.air_k;
      to.latent = latent_coefficient(wet, to.film, construction.air_pressure_pa);
      to.vapour_pa = from.vapour_pa;
      for (std::size_t l = count_; l < kLanes; ++l) to.absorbed[l] = to.absorbed[count_ - 1];
      for (const double absorbed : to.absorbed.at) sum += absorbed;
      sum += to.film + to.air_k + to.latent + to.vapour_pa;
    };
    take(values.front, construction.emissivity, construction.convection, construction.wet_fraction, boundary.front);
    if (sheet) take(values.back, sheet->emissivity, sheet->convection, sheet->wet_fraction, boundary.back);
    boundary.inside = values.inside;
    if (!std::isfinite(sum))
      throw mtf::RuntimeError("heat: the forcing of facets " + std::to_string(first_) + " to " +
                              std::to_string(first_ + count_ - 1) + " at " + mtf::format_double(instant.time_s) +
                              " s has a value that is not finite, or a wind below 0");
  }
  Lanes within(double share, std::size_t node) const {
    const double of_stage = share * (1.0 - share) / (kGamma * (1.0 - kGamma));
    const double of_end = share * (share - kGamma) / (1.0 - kGamma);
    Lanes kelvin;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double to_stage = fine_.first[node + l], to_end = to_stage + fine_.second[node + l];
      kelvin[l] = before_[node + l] + of_stage * to_stage + of_end * to_end;
    }
    return kelvin;
  }

  const Plan* plan_;
  const Forcing* forcing_;
  PlanEliminations* kept_;
  std::size_t first_, count_;
  Buoyancy front_buoyancy_, back_buoyancy_;
  GroupGrid fine_grid_, coarse_grid_;
  bool three_;
  GroupState fine_, doubled_, coarse_;
  Boundary begin_, early_, quarter_, late_, doubled_middle_, end_;
  std::vector<double> before_;
  double wanted_s_;  ///< the step 2h to try next
  HeatSums heat_;
  StepCount steps_;
};

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
