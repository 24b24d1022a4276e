// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/tally.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace study {
namespace {

constexpr std::size_t kMostPatterns = 4096, kMostInPattern = 64, kMostContradictions = 10, kLargestSet = 4;

constexpr double kUnknown = 1000.0;  // counts for a constraint without a number: worse than any that has one

}  // namespace

bool meets(const TallyLimit& limit, ConstraintValues sides) {
  if (!sides.finite()) return false;
  if (!limit.less) std::swap(sides.left, sides.right);
  return limit.strict ? sides.left < sides.right : sides.left <= sides.right;
}

bool active(ConstraintValues sides, double share) {
  return std::abs(sides.left - sides.right) <= share * std::max(std::abs(sides.left), std::abs(sides.right));
}

double violation(const TallyLimit& limit, ConstraintValues sides) {
  if (!sides.finite()) return std::numeric_limits<double>::quiet_NaN();
  if (meets(limit, sides) || sides.left == sides.right) return 0.0;
  const double scale = std::max(std::abs(sides.left), std::abs(sides.right));
  return std::abs(sides.left - sides.right) / scale;
}

Tally::Tally(TallyJob job)
    : job_(std::move(job)), all_(nothing_of(job_)), front_(std::max<std::size_t>(1, job_.goals.size())) {}

Tally::Part Tally::nothing_of(const TallyJob& job) {
  const std::size_t goals = job.goals.size(), limits = job.limits.size();
  return {.invalid = {.by_goal = std::vector<std::int64_t>(goals), .by_limit = std::vector<std::int64_t>(limits)},
          .met = std::vector<std::int64_t>(limits),
          .missing = std::vector<std::int64_t>(job.columns),
          .best = std::vector<TallyDesign>(goals)};
}

void InvalidDesigns::add(const InvalidDesigns& others) {
  if (first < 0) first = others.first;
  designs += others.designs;
  impossible += others.impossible;
  for (std::size_t i = 0; i < by_goal.size(); ++i) by_goal[i] += others.by_goal[i];
  for (std::size_t i = 0; i < by_limit.size(); ++i) by_limit[i] += others.by_limit[i];
}

std::function<void()> Tally::count(RowRange range, std::span<const double> rows) {
  const auto shared = std::make_shared<Part>(nothing_of(job_));
  Part& part = *shared;
  part.designs = range.count;
  FrontPoints front{.objectives = std::max<std::size_t>(1, job_.goals.size())};
  std::vector<ConstraintValues> sides(job_.limits.size());
  std::vector<double> values(job_.goals.size());
  const auto take = [](TallyDesign& target, std::int64_t design, double value, std::span<const double> row) {
    target = {design, value, {row.begin(), row.end()}};
  };
  for (std::int64_t i = 0; i < range.count; ++i) {
    const std::int64_t design = range.first + i;
    const auto row = rows.subspan(static_cast<std::size_t>(i) * job_.columns, job_.columns);
    for (std::size_t c = 0; c < row.size(); ++c) part.missing[c] += std::isnan(row[c]) ? 1 : 0;
    const bool possible = !job_.error || !std::isnan(row[*job_.error]);  // a sensor has these values
    if (job_.error) part.worst_error = std::fmax(part.worst_error, row[*job_.error]);
    const double yield = job_.yield ? row[*job_.yield] : std::numeric_limits<double>::quiet_NaN();
    if (yield > part.highest_yield.value || (part.highest_yield.design < 0 && !std::isnan(yield)))
      take(part.highest_yield, design, yield, row);
    bool whole = true;  // every objective has a number
    for (std::size_t g = 0; g < job_.goals.size(); ++g) {
      const bool finite = std::isfinite(row[job_.goals[g].column]);
      whole = whole && finite;
      part.invalid.by_goal[g] += possible && !finite ? 1 : 0;
    }
    if (!sides.empty()) {
      job_.sides(row, sides);
      std::uint64_t pattern = 0;
      double distance = possible && whole ? 0.0 : kUnknown;
      for (std::size_t k = 0; k < sides.size(); ++k) {
        const bool good = meets(job_.limits[k], sides[k]);
        part.met[k] += good ? 1 : 0;
        if (good && k < kMostInPattern) pattern |= std::uint64_t{1} << k;
        const double by = violation(job_.limits[k], sides[k]);
        distance += std::isnan(by) ? kUnknown : by;
        part.invalid.by_limit[k] += possible && !sides[k].finite() ? 1 : 0;
      }
      if (part.patterns.size() <= kMostPatterns) part.patterns.insert(pattern);
      if (part.nearest.design < 0 || distance < part.nearest.value) take(part.nearest, design, distance, row);
    }
    const bool valid = possible && whole &&
                       std::all_of(sides.begin(), sides.end(), [](const ConstraintValues& s) { return s.finite(); });
    if (!valid) {
      if (part.invalid.first < 0) part.invalid.first = design;
      ++part.invalid.designs;
      part.invalid.impossible += possible ? 0 : 1;
      continue;
    }
    if (job_.feasible && row[*job_.feasible] != 1.0) continue;
    ++part.feasible;
    for (std::size_t g = 0; g < job_.goals.size(); ++g) {
      const TallyGoal& goal = job_.goals[g];
      const double value = row[goal.column];
      values[g] = goal.maximize ? value : -value;
      TallyDesign& best = part.best[g];
      if (best.design < 0 || (goal.maximize ? value > best.value : value < best.value)) take(best, design, value, row);
    }
    if (values.size() > 1) front.add(design, values);
  }
  return [this, shared, front = front_of(front)] { add(std::move(*shared), front); };
}

void Tally::add(Part part, const FrontPoints& front) {
  all_.designs += part.designs;
  all_.feasible += part.feasible;
  all_.invalid.add(part.invalid);
  all_.worst_error = std::fmax(all_.worst_error, part.worst_error);
  for (std::size_t k = 0; k < all_.met.size(); ++k) all_.met[k] += part.met[k];
  for (std::size_t c = 0; c < all_.missing.size(); ++c) all_.missing[c] += part.missing[c];
  for (std::size_t g = 0; g < all_.best.size(); ++g) {
    TallyDesign& best = all_.best[g];
    const double value = part.best[g].value;
    if (part.best[g].design >= 0 &&
        (best.design < 0 || (job_.goals[g].maximize ? value > best.value : value < best.value)))
      best = std::move(part.best[g]);
  }
  if (part.highest_yield.design >= 0 &&
      (all_.highest_yield.design < 0 || part.highest_yield.value > all_.highest_yield.value))
    all_.highest_yield = std::move(part.highest_yield);
  if (part.nearest.design >= 0 && (all_.nearest.design < 0 || part.nearest.value < all_.nearest.value))
    all_.nearest = std::move(part.nearest);
  front_.add(front);
  all_.patterns.insert(part.patterns.begin(), part.patterns.end());
  too_many_ = too_many_ || part.patterns.size() > kMostPatterns;
  if (all_.patterns.size() > kMostPatterns) {
    too_many_ = true;
    all_.patterns.clear();
  }
}

FrontPoints Tally::front() const {
  return job_.goals.size() > 1 ? front_.result()
                               : FrontPoints{.objectives = std::max<std::size_t>(1, job_.goals.size())};
}

std::vector<std::vector<std::size_t>> Tally::contradictions() const {
  std::vector<std::vector<std::size_t>> found;
  for (std::size_t k = 0; k < all_.met.size(); ++k)
    if (all_.met[k] == 0) found.push_back({k});
  const std::size_t count = all_.met.size();
  if (!found.empty() || too_many_ || count > kMostInPattern) {
    found.resize(std::min(found.size(), kMostContradictions));
    return found;
  }
  const auto together = [&](std::uint64_t set) {
    return std::any_of(all_.patterns.begin(), all_.patterns.end(),
                       [&](std::uint64_t met) { return (met & set) == set; });
  };
  // Sets of a size in the order of their members: each is the one before with its last members moved on.
  for (std::size_t size = 2; size <= std::min(count, kLargestSet) && found.empty(); ++size) {
    std::vector<std::size_t> set(size);
    for (std::size_t i = 0; i < size; ++i) set[i] = i;
    for (bool more = true; more && found.size() < kMostContradictions;) {
      std::uint64_t bits = 0;
      for (const std::size_t k : set) bits |= std::uint64_t{1} << k;
      if (!together(bits)) found.push_back(set);
      std::size_t at = size;
      while (at > 0 && set[at - 1] == count - size + at - 1) --at;
      more = at > 0;
      if (!more) break;
      ++set[at - 1];
      for (std::size_t i = at; i < size; ++i) set[i] = set[i - 1] + 1;
    }
  }
  return found;
}

}  // namespace study
