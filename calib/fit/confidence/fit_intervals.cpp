// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/fit_intervals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/fit/confidence/profile.h"
#include "mtf/units.h"

namespace calib {
namespace {

constexpr double kLikeNormal = 0.1;  // of a half interval: to within this the standard error agrees with it
constexpr double kOwnSd = 3.0;       // a first step of the profile, in sd of the parameter with the others fixed

/// Chi-square per degree of freedom of all data.
double noise_factor_of(const FitProblem& problem, const Solved& solved) {
  double factor = 0.0, weight = 0.0;
  const std::vector<std::size_t> counts = counts_of(problem);
  for (std::size_t b = 0; b < counts.size(); ++b) {
    factor += trusted_noise(solved.noise_factor[b]) * static_cast<double>(counts[b]);
    weight += static_cast<double>(counts[b]);
  }
  return factor / weight;
}

/// sd of x to begin the profile with. About a flat bound the covariance may be of any size.
double first_step(const Solved& solved, std::size_t i, std::span<const FlatBound> flat) {
  const auto index = static_cast<Eigen::Index>(i);
  const double sd = std::sqrt(solved.identified.covariance(index, index));
  if (flat.empty()) return sd;
  const double own = std::min(sd, kOwnSd / std::sqrt(solved.information.matrix(index, index)));
  const auto bound = std::find_if(flat.begin(), flat.end(), [&](const FlatBound& f) { return f.parameter == i; });
  return bound == flat.end() ? own : std::min(own, bound->off);
}

ProfiledInterval interval_of(const ProfileEnds& ends, const Variable& v, const FitParameter& parameter) {
  const auto open = [&](const char* side, double bound) {
    return "the data do not bound it from " + std::string(side) + ": chi-square rises too little up to the bound of " +
           mtf::format_double(bound) + (parameter.unit.empty() ? "" : " " + parameter.unit);
  };
  ProfiledInterval interval{ends.interval95[0], ends.interval95[1], ""};
  const bool size_from_zero = v.positive && !(parameter.min && *parameter.min > 0.0);
  if (ends.low_open && !size_from_zero) {
    interval.low.reset();
    interval.reason = open("below", ends.interval95[0]);
  }
  if (ends.high_open) {
    interval.high.reset();
    interval.reason += (interval.reason.empty() ? "" : "; ") + open("above", ends.interval95[1]);
  }
  return interval;
}

bool same_as(const std::array<double, 2>& interval, double value, double half) {
  return std::abs(interval[0] - (value - half)) < kLikeNormal * half &&
         std::abs(interval[1] - (value + half)) < kLikeNormal * half;
}

/// Whether chi-square is the parabola of the covariance as far as the ends, in the variable of the fit.
bool like_normal(const ProfileEnds& ends, const Variable& v, double x, double sd) {
  const auto [low, high] = std::minmax({v.x_of(ends.interval95[0]), v.x_of(ends.interval95[1])});
  return same_as({low, high}, x, k95_sd * sd);
}

/// The interval of the parameter, from intervals of its square that may extend beyond its range: such an end is open.
ProfileEnds ends_of_square(const Variable& v, double x, double sd) {
  const auto within = [&](double half) {
    const double at_low = x - half > v.lo ? v.value(x - half) : v.sign * v.step * std::sqrt(v.lo);
    const double at_high = v.value(std::min(v.hi, x + half));
    return std::array{std::min(at_low, at_high), std::max(at_low, at_high)};
  };
  const bool from_low = x - k95_sd * sd <= v.lo, from_high = x + k95_sd * sd >= v.hi, rises = v.sign > 0.0;
  return {.interval68 = within(sd),
          .interval95 = within(k95_sd * sd),
          .low_open = rises ? from_low : from_high,
          .high_open = rises ? from_high : from_low};
}

/// The verdict on a parameter that has a profile, a flat bound being near to it or to a partner.
void judge_by_profile(FittedParameter& p, const Variable& v, double best, bool normal, const FlatBound* own,
                      const ProfileEnds& ends) {
  if (own != nullptr && own->at_bound) {
    const bool from_low = own->inward > 0.0;
    const bool has_limit = from_low ? !ends.high_open : !ends.low_open;
    p.knowledge = has_limit ? Knowledge::at_bound : Knowledge::not_determined;
    p.limit95 = has_limit ? std::optional(ends.interval95[from_low ? 1 : 0]) : std::nullopt;
    p.limit_is_upper = from_low;
    p.value = v.squared && own->bound <= 1e-8 ? 0.0 : v.value(own->bound);
    p.stderr_value.reset();
    p.pressed_sd = 0.0;
    return;
  }
  const bool held = p.knowledge == Knowledge::at_bound;
  const bool still_held = held && own == nullptr && (p.limit_is_upper ? ends.low_open : ends.high_open);
  if ((held && !still_held) || (p.knowledge == Knowledge::determined && !normal)) {
    p.knowledge = Knowledge::interval;
    p.value = best;
    p.stderr_value.reset();
    p.limit95.reset();
    p.pressed_sd = 0.0;
  }
}

}  // namespace

bool leave_flat_bounds(FitProblem& problem, Solved& solved, std::span<const FlatBound> flat, Solution& solution,
                       const MinimiseOptions& options) {
  constexpr double kLower = 0.005;  // half of chi-square: minima within a tenth of a standard deviation are the same
  if (std::none_of(flat.begin(), flat.end(), [](const FlatBound& f) { return f.at_bound; })) return false;
  const std::vector<double> x = problem.x;
  const std::vector<std::vector<double>> own = problem.own;
  for (const FlatBound& f : flat) problem.x[f.parameter] = f.off_bound(problem.x[f.parameter]);
  Solution again = solve(problem, {.go_on = options.go_on});
  solution.stopped = solution.stopped || again.stopped;
  if (!again.converged || !(again.cost < solution.cost - kLower)) {
    problem.x = x;
    problem.own = own;
    problem.apply();
    return false;
  }
  again.iterations += solution.iterations;
  again.agreeing = 1;
  solution = finish(problem, solved, again, options);
  return true;
}

bool report_squares(FitProblem& problem, const Solved& solved, double cost, const std::function<bool()>& go_on,
                    FitResult& result) {
  const double factor = noise_factor_of(problem, solved);
  bool bent = false;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    FittedParameter& p = result.parameters[i];
    const Variable& v = problem.variables[i];
    if (!v.squared || (p.knowledge != Knowledge::determined && p.knowledge != Knowledge::at_bound)) continue;
    const auto index = static_cast<Eigen::Index>(i);
    const double x = problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
    const ProfileEnds ends = ends_of_square(v, x, sd);
    const bool holds_bound = x - v.lo < k95_sd * sd, determined = p.knowledge == Knowledge::determined;
    if (determined && (holds_bound || !same_as(ends.interval95, p.value, k95_sd * *p.stderr_value))) {
      p.interval68 = ends.interval68;
      p.interval95 = ends.interval95;
      p.interval = interval_of(ends, v, p.parameter);
    }
    if (!holds_bound) continue;
    if (determined) {
      p.knowledge = Knowledge::interval;
      p.stderr_value.reset();
    }
    const double far = std::min(v.hi, p.limit95 ? v.x_of(*p.limit95) : x + k95_sd * sd);
    const double rise = rise_at(problem, i, far, cost, factor * solved.variance_ratio[i], {}, go_on);
    bent = bent || std::abs(rise - k95_sd) > kLikeNormal * k95_sd;
  }
  return bent;
}

void report_intervals(FitProblem& problem, const Solved& solved, std::span<const FlatBound> flat, bool judge,
                      double cost, const std::function<bool()>& go_on, FitResult& result) {
  const double factor = noise_factor_of(problem, solved);
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    FittedParameter& p = result.parameters[i];
    const Variable& v = problem.variables[i];
    if (p.knowledge == Knowledge::not_determined && (flat.empty() || v.period > 0.0)) continue;
    const auto ends =
        profile(problem, i, first_step(solved, i, flat), cost, factor * solved.variance_ratio[i], flat, go_on);
    if (!ends) return;
    p.interval68 = ends->interval68;
    p.interval95 = ends->interval95;
    p.interval = interval_of(*ends, v, p.parameter);
    if (p.limit95) p.limit95 = ends->interval95[p.limit_is_upper ? 1 : 0];
    if (!judge) continue;
    const auto own = std::find_if(flat.begin(), flat.end(), [&](const FlatBound& f) { return f.parameter == i; });
    const auto index = static_cast<Eigen::Index>(i);
    const double x = problem.x[i], sd = std::sqrt(solved.identified.covariance(index, index));
    judge_by_profile(p, v, v.value(x), like_normal(*ends, v, x, sd), own == flat.end() ? nullptr : &*own, *ends);
  }
  for (const FlatBound& f : flat) {
    if (!f.at_bound) continue;
    for (std::size_t k = 0; k < result.correlation.size(); ++k)
      result.correlation[f.parameter][k] = result.correlation[k][f.parameter] =
          std::numeric_limits<double>::quiet_NaN();
    if (result.parameters[f.parameter].knowledge != Knowledge::at_bound) continue;
    std::erase_if(result.not_separable,
                  [&](const NullDirection& direction) { return direction.parameters == std::vector{f.parameter}; });
  }
}

}  // namespace calib
