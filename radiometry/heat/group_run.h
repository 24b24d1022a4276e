// SPDX-License-Identifier: Apache-2.0
#pragma once

// One group of facets over time: the three runs of solver.h side by side, with steps that all lanes share.

#include "radiometry/heat/solver.h"
#include "radiometry/heat/steps.h"

namespace radiometry::heat {

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

class GroupRun {
 public:
  /// Facets `first` and up to kLanes - 1 more of the batch.
  GroupRun(const Plan& plan, const State& start, const Forcing& forcing, std::size_t first, PlanEliminations& kept);

  /// Advances from t0 to t1, between which there is no break. `after_step` is called with the begin and the end of
  /// every step that was taken. Throws RuntimeError as advance does.
  void advance(double t0_s, double t1_s, const std::function<void(double, double)>& after_step);

  std::size_t count() const { return count_; }
  Surfaces front() const;
  Surfaces back() const;
  /// Of Runs::one, within the last step: `share` of it is over. See Timeline::between_s.
  Lanes front_within(double share) const { return within(share, 0); }
  Lanes back_within(double share) const { return within(share, fine_.t.size() - kLanes); }
  const HeatSums& heat() const { return heat_; }
  const StepCount& steps() const { return steps_; }
  void store(State& end) const;

 private:
  /// One step of 2h by all runs, from `begin` at a position of an interval; false where it is refused.
  struct Interval;
  bool step_of_three(const Interval& interval, double from, double whole);
  bool step_of_one(const Interval& interval, double from, double whole);
  /// Whether the film changes little enough from begin_ to end_; else half the step is tried next.
  bool is_short_enough(double step_s, double whole);
  /// Whether a step of 2h with that error is taken, and the next one to try.
  bool accept(double step_s, double error_k);
  void evaluate(Instant instant, Boundary& boundary) const;
  Lanes within(double share, std::size_t node) const;

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

}  // namespace radiometry::heat
