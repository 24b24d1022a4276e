// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a design is an optimum, and which limits make it one: the slope of F has to be a sum of slopes of active
// limits, with multipliers >= 0 (Karush, Kuhn and Tucker). The multipliers are those of least squares (Lawson and
// Hanson, Solving Least Squares Problems, chapter 23), and each is what F would gain by its limit being relaxed.

#include "apps/study/optimum/design_problem.h"

namespace study {

/// A limit is active when the design is as close to it as this, relative.
inline constexpr double kReached = 1e-6;

/// An active limit: a constraint, or an end of an axis.
struct ReachedLimit {
  enum class Kind { constraint, lower, upper } kind = Kind::constraint;
  std::size_t index = 0;    ///< index of the constraint, or of the variable
  double multiplier = 0.0;  ///< derivative of scaled F by the scaled margin, or by z
  double gain = 0.0;        ///< decrease of F by a margin wider by one (SI), or an axis longer by one of its unit
};

struct Optimality {
  std::vector<ReachedLimit> limits;  ///< within 1e-6 of the limit, or of the axis
  bool smooth = false;               ///< the design has slopes; else no multipliers and no residual
  bool shared = false;               ///< slopes of limits depend on each other: the multipliers are one choice of many
  double residual = 0.0;             ///< largest part, by axis, of the slope of F / ProblemScale::f that nothing holds
  std::vector<double> downhill;      ///< minus that slope
};

Optimality optimality_at(DesignProblem& problem, const ProblemScale& scale, std::span<const double> z);

/// For a design that misses constraints: which limits of the box prevent smaller violations, and what
/// is left of the slope of half the sum of their squares.
Optimality nearness_at(DesignProblem& problem, const ProblemScale& scale, std::span<const double> z);

}  // namespace study
