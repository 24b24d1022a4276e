// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/group_run.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/heat/surface_loss.h"

namespace radiometry::heat {
namespace {

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
  Buoyancy buoyancy{.present = std::holds_alternative<Tarp>(convection), .warm = {}, .cold = {}};
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

}  // namespace

GroupRun::GroupRun(const Plan& plan, const State& start, const Forcing& forcing, std::size_t first,
                   PlanEliminations& kept)
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

Surfaces GroupRun::front() const {
  return {fine_.t.data(), three_ ? doubled_.t.data() : nullptr, three_ ? coarse_.t.data() : nullptr};
}

Surfaces GroupRun::back() const {
  const auto last = [](const GroupState& state) { return state.t.data() + (state.t.size() - kLanes); };
  return {last(fine_), three_ ? last(doubled_) : nullptr, three_ ? last(coarse_) : nullptr};
}

Lanes GroupRun::within(double share, std::size_t node) const {
  const double of_stage = share * (1.0 - share) / (kGamma * (1.0 - kGamma));
  const double of_end = share * (share - kGamma) / (1.0 - kGamma);
  Lanes kelvin;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double to_stage = fine_.first[node + l], to_end = to_stage + fine_.second[node + l];
    kelvin[l] = before_[node + l] + of_stage * to_stage + of_end * to_end;
  }
  return kelvin;
}

void GroupRun::store(State& end) const {
  scatter(fine_.t, end.facets, first_, count_, end.fine);
  end.step_s[first_ / kLanes] = wanted_s_;
  if (!three_) return;
  scatter(doubled_.t, end.facets, first_, count_, end.doubled);
  scatter(coarse_.t, end.facets, first_, count_, end.coarse);
}

void GroupRun::evaluate(Instant instant, Boundary& boundary) const {
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

/// An interval between breaks. Positions in it count in 2^-kFinest of its length.
struct GroupRun::Interval {
  double t0_s, t1_s;
  double length_s() const { return t1_s - t0_s; }
  Instant at(double position) const {
    if (position >= static_cast<double>(kWhole)) return {t1_s, Instant::Limit::before};
    return {t0_s + length_s() * (position / static_cast<double>(kWhole)), Instant::Limit::after};
  }
};

bool GroupRun::step_of_three(const Interval& interval, double from, double whole) {
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

bool GroupRun::step_of_one(const Interval& interval, double from, double whole) {
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

bool GroupRun::is_short_enough(double step_s, double whole) {
  if (whole <= static_cast<double>(kSmallPart) || (is_smooth(front_buoyancy_, begin_.front.film, end_.front.film) &&
                                                   is_smooth(back_buoyancy_, begin_.back.film, end_.back.film)))
    return true;
  wanted_s_ = 0.5 * step_s;
  ++steps_.refused;
  return false;
}

bool GroupRun::accept(double step_s, double error_k) {
  wanted_s_ = next_step(step_s, error_k, plan_->step_tolerance_k);
  if (error_k <= plan_->step_tolerance_k) {
    ++steps_.taken;
    return true;
  }
  wanted_s_ = std::min(0.5 * step_s, wanted_s_);  // the first where the error is not a number
  ++steps_.refused;
  return false;
}

void GroupRun::advance(double t0_s, double t1_s, const std::function<void(double, double)>& after_step) {
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

}  // namespace radiometry::heat
