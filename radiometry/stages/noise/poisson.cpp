// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/poisson.h"

#include <cmath>
#include <limits>

namespace radiometry {
namespace text {
#define FUNCTION inline
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"  // the only casts of C
#include "mtf/device/poisson.cl"
#pragma GCC diagnostic pop
#undef FUNCTION
}  // namespace text

double poisson_tail(double n, double mean) { return text::smaller_tail(n, mean); }
double normal_quantile(const Uniform& u) { return text::quantile_of_normal(u.u, u.rest); }

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
  while (!text::reaches(n, mean, u.u, u.rest) != 0) ++n;
  while (n > 0.0 && text::reaches(n - 1.0, mean, u.u, u.rest) != 0) --n;
  return n;
}

}  // namespace radiometry
