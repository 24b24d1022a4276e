// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/poisson.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace radiometry {
namespace {

/// (1 + d) log(1 + d) - d, which cancels where d is small.
double deviance(double d) {
  if (std::abs(d) > 0.1) return (1.0 + d) * std::log1p(d) - d;
  double sum = 0.0, power = d * d;
  for (int j = 2; j < 20; ++j, power *= -d) sum += power / (j * (j - 1));
  return sum;
}

/// P(N = n) as a saddle point with the rest of Stirling's series (Loader, Fast and Accurate Computation of Binomial
/// Probabilities, 2000), for small n as it is defined.
double probability(double n, double mean) {
  if (n < 16.0) {
    double p = std::exp(-mean);
    for (double k = 1.0; k <= n; ++k) p *= mean / k;
    return p;
  }
  const double n2 = n * n;
  const double stirling = (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - 1.0 / (1680.0 * n2)) / n2) / n2) / n;
  return std::exp(-mean * deviance((n - mean) / mean) - stirling) / std::sqrt(2.0 * std::numbers::pi * n);
}

/// True where P(N <= n) >= u, decided by the smaller tail.
bool reaches(double n, double mean, const Uniform& u) {
  return n <= mean ? poisson_tail(n, mean) >= u.u : poisson_tail(n, mean) <= u.rest;
}

}  // namespace

double poisson_tail(double n, double mean) {
  double term = 1.0, sum = 0.0;
  if (n <= mean) {
    for (double k = n; term > 1e-17 * sum; --k) {
      sum += term;
      if (k <= 0.0) break;
      term *= k / mean;
    }
    return probability(n, mean) * sum;
  }
  for (double k = n + 2.0; term > 1e-17 * sum; ++k) {
    sum += term;
    term *= mean / k;
  }
  return probability(n + 1.0, mean) * sum;
}

double normal_quantile(const Uniform& u) {
  const double p = std::min(u.u, u.rest);
  // A first guess to 5e-4 (Hastings, Approximations for Digital Computers, 1955), then Halley's iteration.
  const double t = std::sqrt(-2.0 * std::log(p));
  double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  for (int step = 0; step < 3; ++step) {
    const double tail = 0.5 * std::erfc(z * std::numbers::sqrt2 * 0.5);
    const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
    const double newton = (tail - p) / density;
    z += newton / (1.0 - 0.5 * z * newton);
  }
  return u.u < u.rest ? -z : z;
}

double poisson_exact(const Uniform& u, double mean) {
  if (std::isnan(mean)) return mean;
  if (!(mean > 0.0)) return 0.0;
  if (mean == std::numeric_limits<double>::infinity()) return mean;
  double n = 0.0;
  if (mean >= kSmallMean) {
    const double w = normal_quantile(u), root = std::sqrt(mean), guess = poisson_guess(mean, root, w);
    n = std::max(0.0, std::floor(guess));
    if (mean >= kLargeMean) return n;
    // In the far tails the terms left out grow with w^8; from 1e4 on they are small even there.
    const double w4 = w * w * w * w;
    const double error = poisson_guess_error(mean, root) + 1e-3 * w4 * w4 / (mean * mean * root);
    const double part = guess - n;
    if (mean >= 1e4 && part > error && part < 1.0 - error) return n;
  }
  while (!reaches(n, mean, u)) ++n;
  while (n > 0.0 && reaches(n - 1.0, mean, u)) --n;
  return n;
}

}  // namespace radiometry
