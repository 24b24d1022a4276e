// SPDX-License-Identifier: Apache-2.0
#include "apps/study/optimum/optimize.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "apps/study/optimum/local_optimum.h"
#include "mtf/error.h"
#include "mtf/parallel.h"

namespace study {
namespace {

constexpr std::size_t kMostOthers = 10;

std::string quoted(const std::string& text) { return "\"" + text + "\""; }

Goal goal_of(const Study& study, const OptimizeOptions& options) {
  if (study.objectives.empty())
    throw mtf::UsageError(study.file +
                          ": no objectives to optimise; add for example objectives = [\"maximize mtf_nyquist\"]");
  if (options.weights.size() != study.objectives.size())
    throw mtf::UsageError(std::to_string(options.weights.size()) + " weights for " +
                          std::to_string(study.objectives.size()) + " objectives; give one for each");
  Goal goal;
  for (std::size_t i = 0; i < options.weights.size(); ++i) {
    const double weight = options.weights[i];
    if (!std::isfinite(weight) || weight < 0.0)
      throw mtf::UsageError("weights: " + mtf::format_double(weight) + " has to be a number >= 0");
    goal.push_back(study.objectives[i].maximize ? -weight : weight);
  }
  if (std::all_of(goal.begin(), goal.end(), [](double w) { return w == 0.0; }))
    throw mtf::UsageError("weights: all are 0; give one above it");
  return goal;
}

/// Metrics that a goal or constraint takes and the study cannot have.
void refuse_gaps(const std::shared_ptr<const Study>& study, const Goal& goal) {
  if (study->variants > 1) return;  // another level may have what the first has not
  const std::vector<Column> columns = columns_of(*study);
  const std::vector<std::string> gaps = Evaluator(study).gaps();
  const auto check = [&](const Expression& expression, const std::string& text) {
    for (const int slot : expression.slots()) {
      const auto i = static_cast<std::size_t>(slot);
      if (i < study->parameters.size()) continue;
      const std::string& name = study->metrics[i - study->parameters.size()].name;
      for (std::size_t c = 0; c < columns.size(); ++c)
        if (columns[c].role == Column::Role::metric && columns[c].name == name && !gaps[c].empty())
          throw mtf::UsageError(study->file + ": " + quoted(text) + " needs " + name +
                                ", which no design has: " + gaps[c]);
    }
  };
  for (std::size_t i = 0; i < goal.size(); ++i)
    if (goal[i] != 0.0) check(study->objectives[i].expression, study->objectives[i].text);
  for (const Constraint& constraint : study->constraints) {
    check(constraint.left, constraint.text);
    check(constraint.right, constraint.text);
  }
}

/// Levels of combination `c`, the last axis fastest.
std::vector<int> levels_of(const Study& study, std::int64_t c) {
  std::vector<int> levels(study.axes.size(), 0);
  for (std::size_t a = study.axes.size(); a-- > 0;) {
    if (!study.axes[a].discrete()) continue;
    levels[a] = static_cast<int>(c % study.axes[a].points());
    c /= study.axes[a].points();
  }
  return levels;
}

struct End {
  LocalEnd local;
  std::size_t combination = 0;
};

bool better(const End& a, const End& b) {
  if (a.local.optimum.feasible != b.local.optimum.feasible) return a.local.optimum.feasible;
  return a.local.optimum.feasible ? a.local.optimum.goal < b.local.optimum.goal : a.local.violation < b.local.violation;
}

/// The same optimum: levels, F and the values of all axes. Searches end less exactly than the smooth method.
bool same(const End& a, const End& b, double f_scale) {
  if (a.combination != b.combination || a.local.optimum.feasible != b.local.optimum.feasible) return false;
  if (std::abs(a.local.optimum.goal - b.local.optimum.goal) > 1e-6 * f_scale) return false;
  for (std::size_t i = 0; i < a.local.z.size(); ++i)
    if (std::abs(a.local.z[i] - b.local.z[i]) > 1e-3) return false;
  return true;
}

}  // namespace

OptimizeOutcome optimize(const Study& study, const OptimizeOptions& options) {
  const Goal goal = goal_of(study, options);
  if (study.variants > kMostCombinations)
    throw mtf::UsageError(study.file + ": " + std::to_string(study.variants) +
                          " combinations of levels of discrete axes; at most " + std::to_string(kMostCombinations) +
                          " are tried, so give some axis fewer levels");
  const std::shared_ptr<const Study> sharp = only_needed(study);
  refuse_gaps(sharp, goal);

  std::mutex mutex;
  std::int64_t done = 0;
  const auto advance = [&](std::int64_t of, double from, double to) {
    const std::lock_guard lock(mutex);
    ++done;
    if (options.progress) options.progress(from + (to - from) * static_cast<double>(done) / static_cast<double>(of));
  };

  std::vector<Combination> combinations(static_cast<std::size_t>(study.variants));
  mtf::parallel_for_each(study.variants, 1, options.threads, [&](std::int64_t c) {
    combinations[static_cast<std::size_t>(c)] =
        prepare_combination(sharp, goal, levels_of(study, c), std::max(1, options.starts));
    advance(study.variants, 0.0, 0.1);
  });

  OptimizeOutcome outcome;
  std::vector<std::pair<std::size_t, std::size_t>> tasks;
  for (std::size_t c = 0; c < combinations.size(); ++c) {
    outcome.evaluations += combinations[c].evaluations;
    for (std::size_t s = 0; s < combinations[c].starts.size(); ++s) tasks.emplace_back(c, s);
    if (outcome.problem.empty()) outcome.problem = combinations[c].problem;
  }
  if (tasks.empty()) {
    if (outcome.problem.empty()) outcome.problem = "no design has a number for every constraint and objective";
    return outcome;
  }
  outcome.problem.clear();
  std::vector<End> ends(tasks.size());
  done = 0;
  mtf::parallel_for_each(std::ssize(tasks), 1, options.threads, [&](std::int64_t t) {
    const auto i = static_cast<std::size_t>(t);
    const auto [c, s] = tasks[i];
    ends[i] = {local_optimum(sharp, goal, combinations[c], s, options.method), c};
    advance(std::ssize(tasks), 0.1, 1.0);
  });
  for (const End& end : ends) outcome.evaluations += end.local.evaluations;

  std::stable_sort(ends.begin(), ends.end(), better);
  // Of searches that have come to one place the one that has shown it to be an optimum speaks for it.
  std::vector<End> places;
  for (End& end : ends) {
    const auto found = std::ranges::find_if(
        places, [&](const End& place) { return same(place, end, combinations[end.combination].scale.f); });
    if (found == places.end()) {
      places.push_back(std::move(end));
      continue;
    }
    const int starts = found->local.optimum.starts + 1;
    if (end.local.optimum.converged && !found->local.optimum.converged) *found = std::move(end);
    found->local.optimum.starts = starts;
  }
  End& best = places.front();
  outcome.starts = static_cast<int>(tasks.size());
  outcome.starts_of_best = static_cast<int>(combinations[best.combination].starts.size());
  outcome.status = !best.local.optimum.feasible   ? OptimizeOutcome::Status::infeasible
                   : best.local.optimum.converged ? OptimizeOutcome::Status::optimal
                                                  : OptimizeOutcome::Status::stopped;
  outcome.contradiction = std::move(best.local.contradiction);
  for (std::size_t i = 1; i < places.size() && outcome.others.size() < kMostOthers; ++i)
    if (places[i].local.optimum.feasible) outcome.others.push_back(std::move(places[i].local.optimum));
  outcome.best = std::move(best.local.optimum);
  Evaluator whole(sharpened(study));  // with the metrics that are only listed
  whole.evaluate_at(outcome.best.axis_values, outcome.best.row);
  outcome.best.caution = whole.last_caution();
  return outcome;
}

}  // namespace study
