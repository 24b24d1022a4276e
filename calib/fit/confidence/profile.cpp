// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/profile.h"

#include <algorithm>
#include <cmath>

namespace calib {
namespace {

/// sqrt of the rise of chi-square, in sd of the noise: nearly linear in x.
struct Profiler {
  FitProblem& problem;
  std::size_t i;
  double cost, noise_factor;
  std::span<const FlatBound> flat;
  const std::function<bool()>& go_on;
  bool stopped = false;

  double at(double x) {
    for (const FlatBound& bound : flat) problem.x[bound.parameter] = bound.off_bound(problem.x[bound.parameter]);
    problem.x[i] = x;
    const Solution solution = solve(problem, {.fixed = i, .go_on = go_on});
    stopped = stopped || solution.stopped;
    return std::sqrt(std::max(0.0, 2.0 * (solution.cost - cost) / noise_factor));
  }

  /// x in the direction of `side` at which the root of the rise is `target`.
  double end(double from, double sd, double side, double target) {
    const Variable& v = problem.variables[i];
    const double bound = side > 0.0 ? v.hi : v.lo;
    double low = from, low_value = 0.0, step = std::max(1e-12, sd * target);
    for (int grow = 0; grow < 40 && !stopped; ++grow) {
      const double high = side > 0.0 ? std::min(bound, low + step) : std::max(bound, low - step);
      double high_value = at(high);
      if (high_value < target) {
        if (high == bound) return bound;
        low = high, low_value = high_value, step *= 1.5;
        continue;
      }
      // The root is nearly linear: false position, halved where it stalls.
      double a = low, fa = low_value - target, b = high, fb = high_value - target;
      for (int refine = 0; refine < 12 && !stopped; ++refine) {
        double x = b - fb * (b - a) / (fb - fa);
        if (refine % 4 == 3) x = 0.5 * (a + b);
        const double fx = at(x) - target;
        if (std::abs(fx) < 1e-3 * target) return x;
        (fx < 0.0 ? a : b) = x;
        (fx < 0.0 ? fa : fb) = fx;
      }
      return 0.5 * (a + b);
    }
    return bound;
  }
};

}  // namespace

std::optional<ProfileEnds> profile(FitProblem& problem, std::size_t i, double sd, double cost, double noise_factor,
                                   std::span<const FlatBound> flat, const std::function<bool()>& go_on) {
  const std::vector<double> x = problem.x;
  const std::vector<std::vector<double>> own = problem.own;
  Profiler profiler{problem, i, cost, noise_factor, flat, go_on};
  const Variable& v = problem.variables[i];
  bool open = false;  // the last end
  const auto value_at_end = [&](double side, double target) {
    problem.x = x;
    problem.own = own;
    const double end = profiler.end(x[i], sd, side, target);
    open = end == (side > 0.0 ? v.hi : v.lo);
    return v.squared && end <= 1e-8 ? 0.0 : v.value(end);
  };
  const double lower68 = value_at_end(-1.0, 1.0), upper68 = value_at_end(1.0, 1.0);
  const double lower95 = value_at_end(-1.0, k95_sd);
  const bool lower_open = open;
  const double upper95 = value_at_end(1.0, k95_sd);
  const bool upper_open = open, rises = lower95 <= upper95;
  ProfileEnds ends{.interval68 = {std::min(lower68, upper68), std::max(lower68, upper68)},
                   .interval95 = {std::min(lower95, upper95), std::max(lower95, upper95)},
                   .low_open = rises ? lower_open : upper_open,
                   .high_open = rises ? upper_open : lower_open};
  problem.x = x;
  problem.own = own;
  problem.apply();
  return profiler.stopped ? std::nullopt : std::optional(ends);
}

double rise_at(FitProblem& problem, std::size_t i, double x, double cost, double noise_factor,
               std::span<const FlatBound> flat, const std::function<bool()>& go_on) {
  const std::vector<double> minimum = problem.x;
  const std::vector<std::vector<double>> own = problem.own;
  Profiler profiler{problem, i, cost, noise_factor, flat, go_on};
  const double rise = profiler.at(x);
  problem.x = minimum;
  problem.own = own;
  problem.apply();
  return rise;
}

}  // namespace calib
