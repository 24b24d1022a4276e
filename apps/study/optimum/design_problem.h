// SPDX-License-Identifier: Apache-2.0
#pragma once

// A study as a problem of optimisation: one combination of levels of the discrete axes, the numeric axes as a point z
// of the unit cube (0 and 1 are the ends of an axis, log axes in the logarithm), one number F to be minimized, and
// margins of the constraints, all with slopes by autodiff. Every value is computed to kSharp, whatever the study's
// tolerance: errors of 1e-4 would hide the optimum.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/study/design/evaluator.h"

namespace study {

/// F = sum of weight x objective as shown, to be made small: the weight of one to be maximized is negative, 0 leaves it
/// out. One for each of Study::objectives.
using Goal = std::vector<double>;

struct DesignPoint {
  double f = 0.0;              ///< F, NaN where the design cannot have it
  std::vector<double> margin;  ///< of each constraint, in SI, above 0 where it holds
};

struct DesignSlopes {
  std::vector<double> f;       ///< dF/dz
  std::vector<double> margin;  ///< [constraint][variable]; NaN, like f, where there is none
};

/// The units of scaled values: for F its spread over the box, for a margin the size of its sides.
struct ProblemScale {
  double f = 1.0, f_middle = 0.0;
  std::vector<double> margin;
};

class DesignProblem {
 public:
  /// `levels`: by axis, ignored for numeric ones.
  DesignProblem(std::shared_ptr<const Study> study, Goal goal, std::vector<int> levels);

  /// Numeric axes whose ends differ.
  std::size_t variables() const { return axes_.size(); }
  std::size_t constraints() const { return study_->constraints.size(); }
  /// The axis of a variable.
  const Axis& axis(std::size_t variable) const { return study_->axes[axes_[variable]]; }
  const Study& study() const { return *study_; }

  /// Values of all axes as Evaluator takes them.
  std::vector<double> axis_values(std::span<const double> z) const;
  /// The inverse; within the cube.
  std::vector<double> cube(std::span<const double> axis_values) const;
  /// d(value of the axis)/dz.
  double stretch(std::size_t variable, double z) const;

  DesignPoint at(std::span<const double> z);
  DesignSlopes slopes(std::span<const double> z);
  /// True when every constraint holds and F is a number.
  bool feasible(const DesignPoint& point) const;
  /// Why the last point can be no design, or has no F.
  const std::string& problem() const {
    return evaluator_.last_problem().empty() ? evaluator_.last_refusal() : evaluator_.last_problem();
  }
  std::span<const ConstraintValues> sides() const { return evaluator_.last_sides(); }
  std::span<const double> objectives() const { return evaluator_.last_objectives(); }
  std::span<const double> row() const { return row_; }
  Evaluator& evaluator() { return evaluator_; }
  int evaluations() const { return evaluations_; }

 private:
  std::shared_ptr<const Study> study_;
  Goal goal_;
  std::vector<int> levels_;
  std::vector<std::size_t> axes_, columns_;  // axis of each variable, and its place among the numeric ones
  std::size_t numeric_ = 0;
  Evaluator evaluator_;
  std::vector<double> row_;
  int evaluations_ = 0;
};

/// Error allowed to metrics here. The slopes are those of the same approximation, so that a search sees less of it.
inline constexpr double kSharp = 1e-6;
/// The study with this tolerance, or its own where that is smaller.
std::shared_ptr<const Study> sharpened(const Study& study);
/// The same, and in the places of metrics that no objective and no constraint takes one that costs nothing: what
/// expressions read stays where it is.
std::shared_ptr<const Study> only_needed(const Study& study);

/// Scales from points all over the box.
ProblemScale scale_of(DesignProblem& problem, const std::vector<std::vector<double>>& points);

/// Largest violation of a constraint in its scale; 0 when all hold, infinite where one has no number.
double violation(const DesignPoint& point, const ProblemScale& scale);
/// Root of the sum of squares of the same.
double total_violation(const DesignPoint& point, const ProblemScale& scale);

}  // namespace study
