// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/profile.h"

#include <algorithm>
#include <cmath>

namespace calib {

double Profiler::at(double x) {
  for (const FlatPoint& point : flat) problem.x[point.parameter] = point.off_point(problem.x[point.parameter]);
  problem.x[i] = x;
  // To a hundredth of a standard deviation.
  constexpr double kCost = 1e-3;
  const Solution solution =
      solve(problem, {.fixed = i, .go_on = go_on, .tolerance = std::clamp(kCost / cost, 1e-10, 1e-6)});
  stopped = stopped || solution.stopped;
  return std::sqrt(std::max(0.0, 2.0 * (solution.cost - cost) / noise_factor));
}

namespace {

/// x in the direction of `side` at which the root of the rise is that of `z` sd.
double end_of(Profiler& profiler, double from, double sd, double side, double z) {
  const Variable& v = profiler.problem.variables[profiler.i];
  const double bound = side > 0.0 ? v.hi : v.lo;
  const auto excess = [&](double x) { return profiler.at(x) - allowed_rise(z, std::min(x - v.lo, v.hi - x) / sd); };
  double low = from, low_value = -z, step = std::max(1e-12, sd * z);
  for (int grow = 0; grow < 40 && !profiler.stopped; ++grow) {
    const double high = side > 0.0 ? std::min(bound, low + step) : std::max(bound, low - step);
    const double high_value = excess(high);
    if (high_value < 0.0) {
      if (high == bound) return bound;
      low = high, low_value = high_value, step *= 1.5;
      continue;
    }
    // The root is nearly linear: false position, halved where it stalls.
    double a = low, fa = low_value, b = high, fb = high_value;
    for (int refine = 0; refine < 12 && !profiler.stopped; ++refine) {
      double x = b - fb * (b - a) / (fb - fa);
      if (refine % 4 == 3) x = 0.5 * (a + b);
      const double fx = excess(x);
      if (std::abs(fx) < 1e-3 * z) return x;
      (fx < 0.0 ? a : b) = x;
      (fx < 0.0 ? fa : fb) = fx;
    }
    return 0.5 * (a + b);
  }
  return bound;
}

}  // namespace

std::optional<XEnds> profile(FitProblem& problem, std::size_t i, double sd, double cost, double noise_factor,
                             std::span<const FlatPoint> flat, const std::function<bool()>& go_on) {
  const std::vector<double> x = problem.x;
  const std::vector<std::vector<double>> own = problem.own;
  Profiler profiler{problem, i, cost, noise_factor, flat, go_on};
  const auto end = [&](double side, double z) {
    problem.x = x;
    problem.own = own;
    return end_of(profiler, x[i], sd, side, z);
  };
  const XEnds ends{{end(-1.0, 1.0), end(1.0, 1.0)}, {end(-1.0, k95_sd), end(1.0, k95_sd)}};
  problem.x = x;
  problem.own = own;
  problem.apply();
  return profiler.stopped ? std::nullopt : std::optional(ends);
}

double rise_at(FitProblem& problem, std::size_t i, double x, double cost, double noise_factor,
               std::span<const FlatPoint> flat, const std::function<bool()>& go_on) {
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
