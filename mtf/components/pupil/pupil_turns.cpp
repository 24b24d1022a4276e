// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/pupil_turns.h"

#include "mtf/math/clones.h"
#include "mtf/math/turns.h"

namespace mtf {

MTFKIT_CLONES void weighted_turns(const double* coefficient, int degree, const double* w, const double* weight,
                                  std::size_t n, double* __restrict re, double* __restrict im) {
  for (std::size_t k = 0; k < n; ++k) re[k] = coefficient[degree];
  for (int j = degree - 1; j >= 0; --j)
    for (std::size_t k = 0; k < n; ++k) re[k] = re[k] * w[k] + coefficient[j];
  constexpr double kRound = 0x1.8p+52;  // adding and subtracting it rounds to whole cycles
  for (std::size_t k = 0; k < n; ++k) {
    // With a = pi r, exp(2 i a) - 1 = 2 i sin a exp(i a); sin a and cos a come from the sine and cosine of a / 2.
    const double r = re[k] - ((re[k] + kRound) - kRound);
    const auto [s, c] = sin_cos_reduced(0.25 * r);
    const double sine = 2.0 * s * c, cosine = 1.0 - 2.0 * s * s;
    re[k] = -2.0 * weight[k] * sine * sine;
    im[k] = 2.0 * weight[k] * sine * cosine;
  }
}

}  // namespace mtf
