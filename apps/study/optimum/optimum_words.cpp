// SPDX-License-Identifier: Apache-2.0

// Limits and outcomes in words.

#include <cmath>

#include "apps/study/optimum/optimize.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace study {
namespace {

using Status = OptimizeOutcome::Status;

/// The power of ten about a hundredth of the limit, to say what a little more room gives.
double little(double limit) {
  return limit == 0.0 || !std::isfinite(limit) ? 1.0 : std::pow(10.0, std::floor(std::log10(0.05 * std::abs(limit))));
}

/// "raise niirs_giqe5 by 0.012".
std::string gain_text(const Study& study, const OptimizeOptions& options, double gain) {
  std::size_t used = 0, which = 0;
  for (std::size_t i = 0; i < options.weights.size(); ++i)
    if (options.weights[i] != 0.0) {
      ++used;
      which = i;
    }
  if (used > 1) return "improve the weighted sum by " + mtf::significant(gain, 3);
  const Objective& objective = study.objectives[which];
  return (objective.maximize ? "raise " : "lower ") + objective.text + " by " +
         mtf::with_unit(mtf::significant(gain / options.weights[which], 3), objective.unit);
}

void limits(const Study& study, const OptimizeOptions& options, const Optimum& best, std::vector<std::string>& lines) {
  std::vector<std::string> idle;
  bool limited = false;
  for (const Limit& limit : best.limits) {
    if (std::isnan(limit.gain)) {
      lines.push_back(limit.text + " is active; what it costs is unknown, as the slopes do not show an optimum");
    } else if (limit.gain == 0.0) {
      idle.push_back(limit.text);
    } else {
      const double step = little(limit.value);
      limited = true;
      lines.push_back(limit.text + " limits: relaxing it by " + mtf::with_unit(mtf::significant(step, 3), limit.unit) +
                      " would " + gain_text(study, options, limit.gain * step));
    }
  }
  if (!idle.empty()) lines.push_back("active without limiting: " + mtf::listed(idle));
  if (best.shared && limited)
    lines.push_back("these limits depend on each other: relaxing one alone may gain less than stated");
  if (best.converged && !limited) lines.push_back("nothing limits it: the best design lies inside of all limits");
}

}  // namespace

std::string unit_of(const Study& study, const Constraint& constraint) {
  for (const Expression* side : {&constraint.left, &constraint.right})
    if (const auto slot = side->only_slot()) return study.unit_of(*slot);
  return si_unit(constraint.left.dimensions());
}

Limit limit_of(const Study& study, Limit::Kind kind, std::size_t index, std::span<const double> axis_values,
               std::span<const ConstraintValues> sides) {
  Limit limit{.kind = kind, .index = index, .text = {}, .unit = {}, .gain = std::nan("")};
  if (kind == Limit::Kind::constraint) {
    const Constraint& constraint = study.constraints[index];
    limit.text = constraint.text;
    limit.unit = unit_of(study, constraint);
    limit.value = (constraint.left.constant() ? sides[index].left : sides[index].right) / unit_scale(limit.unit).si;
    return limit;
  }
  const Parameter& parameter = study.parameters[static_cast<std::size_t>(study.axes[index].parameter)];
  limit.unit = parameter.unit;
  limit.value = axis_values[index];
  limit.text = parameter.name + (kind == Limit::Kind::lower ? " >= " : " <= ") +
               mtf::with_unit(mtf::format_double(limit.value), limit.unit);
  return limit;
}

std::string_view state_words(Limit::Kind kind) {
  return kind == Limit::Kind::constraint ? "at its limit"
         : kind == Limit::Kind::lower    ? "at its lower end"
                                         : "at its upper end";
}

std::vector<std::string> sentences(const Study& study, const OptimizeOptions& options, const OptimizeOutcome& outcome) {
  std::vector<std::string> lines;
  const Optimum& best = outcome.best;
  if (outcome.status == Status::impossible) {
    lines.push_back("no design could be worked out: " + outcome.problem);
    return lines;
  }
  if (!best.caution.empty()) lines.push_back("of the best design: " + best.caution);
  if (outcome.status == Status::infeasible) {
    lines.push_back("no design found that meets every constraint; this is the nearest");
    for (const Violation& v : best.violations)
      lines.push_back(study.constraints[v.constraint].text + " is missed by " +
                      mtf::with_unit(mtf::significant(v.by, 4), v.unit) + " (" + mtf::significant(100.0 * v.share, 3) +
                      " %)");
    if (outcome.contradiction.size() > 1)
      lines.push_back("contradict each other: " + mtf::listed(outcome.contradiction));
    return lines;
  }
  limits(study, options, best, lines);
  if (outcome.status == Status::stopped) {
    lines.push_back(best.edge.empty()
                        ? "the slopes do not show that this is an optimum: it lies on a kink, or the search has stopped"
                        : "designs stop being possible there: " + best.edge);
  }
  if (!best.why.empty()) lines.push_back("found by search: " + best.why);
  int elsewhere = 0;
  for (const Optimum& other : outcome.others)
    if (std::abs(other.goal - best.goal) <= 1e-6 * std::abs(best.goal)) elsewhere += other.starts;
  if (elsewhere > 0) {
    lines.push_back(std::to_string(elsewhere + best.starts) +
                    " starts ended at this value, at different designs: " + "some axes of the study do not change it");
    return lines;
  }
  if (outcome.starts_of_best > 1)
    lines.push_back(std::to_string(best.starts) + " of " + std::to_string(outcome.starts_of_best) +
                    " starts ended at it" + (best.starts == 1 ? "; more (--starts) may find a better one" : ""));
  return lines;
}

}  // namespace study
