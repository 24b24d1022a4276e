// SPDX-License-Identifier: Apache-2.0
#pragma once

// The best design of a study. Numeric axes are continuous between their ends, every value of a discrete axis is tried,
// and links and constraints are those of the study. Local searches from points of Sobol's sequence, each to an optimum
// that is checked by its slopes. What does not end well is an outcome, never an exception.

#include <functional>

#include "apps/study/optimum/design_problem.h"

namespace study {

struct OptimizeOptions {
  enum class Method { smooth, search };
  std::vector<double> weights{};   ///< by objective, >= 0, not all 0: what counts is the sum of weight x objective as
                                   ///< shown, signed by its direction
  Method method = Method::smooth;  ///< smooth continues as search where it finds no optimum
  int starts = 8;                  ///< number of starts in each combination of levels
  int threads = 0;                 ///< 0 = all cores; the result is the same for any
  std::function<void(double)> progress{};  ///< share done; called by one thread at a time
};

/// A constraint or an end of an axis at which a design lies.
struct Limit {
  enum class Kind { constraint, lower, upper } kind = Kind::constraint;
  std::size_t index = 0;  ///< into Study::constraints or Study::axes
  std::string text;       ///< "netd < 50 mK", "optics.aperture <= 200 mm"
  std::string unit;       ///< unit of the limit: that of a metric or parameter that is one side by itself, else SI
  double value = 0.0;     ///< the limit, in it
  double gain = 0.0;  ///< improvement of the goal by a limit that is wider by one unit; 0: does not limit. NaN where
                      ///< the design has no slopes, or is not the optimum by them
};

/// The limit in words and units of the study, at a design with these values of the axes and sides of the constraints.
Limit limit_of(const Study& study, Limit::Kind kind, std::size_t index, std::span<const double> axis_values,
               std::span<const ConstraintValues> sides);

/// The unit that a constraint is thought of in.
std::string unit_of(const Study& study, const Constraint& constraint);

/// "at its limit", "at its lower end", "at its upper end".
std::string_view state_words(Limit::Kind kind);

/// What a design misses.
struct Violation {
  std::size_t constraint = 0;
  double by = 0.0;     ///< how much is missing, in `unit`
  double share = 0.0;  ///< the same as a share of the size of the constraint's sides
  std::string unit;
};

struct Optimum {
  std::vector<double> axis_values;  ///< as Evaluator takes them
  std::vector<double> row;          ///< values of columns_of(study), to kSharp; metrics only of the best design
  std::vector<double> objectives;   ///< as shown
  double goal = 0.0;                ///< weighted sum, to be made small
  bool feasible = false;
  std::vector<Limit> limits;
  std::vector<Violation> violations;
  bool shared = false;     ///< limits depend on each other: the gains are one split of many
  double residual = 0.0;   ///< slope of the goal that no limit holds, over the whole length of an axis, as a share of
                           ///< the goal's spread; NaN without slopes
  bool converged = false;  ///< residual at most 1e-5
  OptimizeOptions::Method method = OptimizeOptions::Method::smooth;  ///< that found it
  std::string why;      ///< why it was not the method asked for; "" when it was
  std::string edge;     ///< what keeps designs from going on where no limit does: a problem of Evaluator
  int starts = 1;       ///< that ended here
  std::string caution;  ///< Evaluator::last_caution, of the best design only
};

struct OptimizeOutcome {
  enum class Status {
    optimal,     ///< best.converged
    stopped,     ///< feasible, found by a search that cannot show that it is an optimum
    infeasible,  ///< best is the nearest design, `contradiction` says which limits exclude each other
    impossible   ///< no start could be worked out: `problem`
  } status = Status::impossible;
  Optimum best;
  std::vector<Optimum> others;  ///< other places where searches ended, feasible, best first, at most 10
  int starts = 0;               ///< all of them
  int starts_of_best = 0;       ///< in its combination of levels
  std::int64_t evaluations = 0;
  std::vector<std::string> contradiction;  ///< constraints and ends of axes, as text
  std::string problem;
};

/// The largest number of combinations of levels that are tried.
inline constexpr std::int64_t kMostCombinations = 200;

/// Throws UsageError for a study without objectives, weights that do not fit them, more combinations of levels,
/// objectives or constraints over metrics that the study cannot have; RuntimeError for files that cannot be read.
OptimizeOutcome optimize(const Study& study, const OptimizeOptions& options);

/// What the outcome means: what limits the design and what would be gained, how sure that is, what contradicts.
std::vector<std::string> sentences(const Study& study, const OptimizeOptions& options, const OptimizeOutcome& outcome);

}  // namespace study
