// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/pupil_turns.h"

#include "mtf/engines/clones.h"

namespace mtf {

MTFKIT_CLONES void weighted_turns(const double* coefficient, int degree, const double* w, const double* weight,
                                  std::size_t n, double* __restrict re, double* __restrict im) {
  for (std::size_t k = 0; k < n; ++k) re[k] = coefficient[degree];
  for (int j = degree - 1; j >= 0; --j)
    for (std::size_t k = 0; k < n; ++k) re[k] = re[k] * w[k] + coefficient[j];
  // Taylor's series of sin(pi r) and cos(pi r) for |r| <= 1/2, the first term left out below 1e-17.
  constexpr double kSine[]{0x1.921fb54442d18p+1,  -0x1.4abbce625be53p+2,  0x1.466bc6775aae2p+1,  -0x1.32d2cce62bd86p-1,
                           0x1.50783487ee782p-4,  -0x1.e3074fde8871fp-8,  0x1.e8f434d018d63p-12, -0x1.6fadb9f155744p-16,
                           0x1.aaec32af93359p-21, -0x1.8a404211f9547p-26, 0x1.2877020d52cf0p-31};
  constexpr double kCosine[]{1.0,
                             -0x1.3bd3cc9be45dep+2,
                             0x1.03c1f081b5ac4p+2,
                             -0x1.55d3c7e3cbffap+0,
                             0x1.e1f506891babbp-3,
                             -0x1.a6d1f2a204a8cp-6,
                             0x1.f9d38a3763cc3p-10,
                             -0x1.b6e24f44b128fp-14,
                             0x1.20c62c2f2d7f5p-18,
                             -0x1.2a0c591af8314p-23,
                             0x1.ef6e308d6d1c4p-29};
  constexpr int kTerms = 11;
  constexpr double kRound = 0x1.8p+52;  // adding and taking it away rounds to whole cycles
  for (std::size_t k = 0; k < n; ++k) {
    const double r = re[k] - ((re[k] + kRound) - kRound), q = r * r;
    double s = kSine[kTerms - 1], c = kCosine[kTerms - 1];
    for (int j = kTerms - 2; j >= 0; --j) {
      s = s * q + kSine[j];
      c = c * q + kCosine[j];
    }
    s *= r;
    re[k] = -2.0 * weight[k] * s * s;  // exp(2 i a) - 1 = 2 i sin a exp(i a)
    im[k] = 2.0 * weight[k] * s * c;
  }
}

}  // namespace mtf
