// SPDX-License-Identifier: Apache-2.0
#pragma once

// Poisson numbers by inversion: the smallest n with P(N <= n) >= u. For the same u a larger mean never gives a smaller
// number. Between the integers the distribution function is Q(n + 1, mean), the incomplete gamma function; its
// inverse is expanded for large means in the normal quantile w of u (Cornish and Fisher, with the cumulants of a
// distribution that has been spread between the integers),
//   n + 1 = m + s w + (1/3 + w^2/6) - (w/36 + w^3/72)/s + ...      m the mean, s = sqrt(m)
// up to 1/s^4. What it leaves is below poisson_guess_error; a guess closer than that to an integer is decided by the
// distribution function itself, summed to the precision of a double.

#include "radiometry/stages/noise/random.h"

namespace radiometry {

/// Below this mean the distribution function is summed from 0 on.
inline constexpr double kSmallMean = 32.0;
/// From this mean on a float holds only every eighth number: guesses are taken as they are.
inline constexpr double kLargeMean = 1e8;

/// The expansion, as far as it is from the mean.
template <class T>
T poisson_shift(T root, T w) {
  const T r = T(1) / root, w2 = w * w;
  const T c2 = T(1.0 / 3.0) + w2 * T(1.0 / 6.0);
  const T c3 = -w * (T(1.0 / 36.0) + w2 * T(1.0 / 72.0));
  const T c4 = T(-8.0 / 405.0) + w2 * (T(7.0 / 810.0) + w2 * T(1.0 / 270.0));
  const T c5 = w * (T(671.0 / 38880.0) + w2 * (T(-137.0 / 38880.0) - w2 * T(23.0 / 17280.0)));
  const T c6 = T(-16.0 / 25515.0) + w2 * (T(-5189.0 / 408240.0) + w2 * (T(5.0 / 3024.0) + w2 * T(19.0 / 34020.0)));
  return root * w + (c2 + r * (c3 + r * (c4 + r * (c5 + r * c6))));
}
/// Its floor is the number, unless it lies next to an integer.
inline double poisson_guess(double mean, double root, double w) { return mean + poisson_shift(root, w); }

/// How far the expansion may be from the truth for |w| <= 4, mean >= kSmallMean: the next terms, the quantile's own
/// error, rounding.
inline double poisson_guess_error(double mean, double root) {
  return 12.0 / (mean * mean * root) + 1e-11 * root + 4e-16 * mean;
}

/// P(N <= n) for n <= mean, P(N > n) for n > mean: the smaller of the two tails, about. n >= 0.
double poisson_tail(double n, double mean);

/// The normal quantile of u, to 1e-14.
double normal_quantile(const Uniform& u);

/// The number for any mean: 0 for one of 0 or below, NaN for NaN, infinite for infinity. From kLargeMean on the floor
/// of the expansion.
double poisson_exact(const Uniform& u, double mean);

}  // namespace radiometry
