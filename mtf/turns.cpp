// SPDX-License-Identifier: Apache-2.0
#include "mtf/turns.h"

#include <cassert>
#include <cmath>

#include "mtf/engines/clones.h"

namespace mtf {

// Quarter turns are taken off exactly; what is left, r in [-1/8, 1/8], goes into Chebyshev fits of sin(2 pi r)/r and
// cos(2 pi r) in r^2, of relative error 2e-21 and 2e-23.
MTFKIT_CLONES
void sin_cos_turns(std::span<const double> turns, std::span<double> sine, std::span<double> cosine) {
  assert(sine.size() == turns.size() && cosine.size() == turns.size());
  const double* x = turns.data();
  double *s = sine.data(), *c = cosine.data();
  constexpr double kRound = 0x1.8p52;  // adding and taking it off rounds to a whole number
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const double quarters = (4.0 * x[i] + kRound) - kRound;
    const double r = x[i] - 0.25 * quarters, z = r * r;
    const double a = r * (6.2831853071795864769 +
                          z * (-41.341702240399760142 +
                               z * (81.605249276074930668 +
                                    z * (-76.70585975299812673 +
                                         z * (42.058693928988783438 +
                                              z * (-15.094640403891545649 +
                                                   z * (3.8197881201632114229 + z * -0.71163580907816659965)))))));
    const double b = 1.0 + z * (-19.739208802178717238 +
                                z * (64.93939402266829122 +
                                     z * (-85.456817206693549861 +
                                          z * (60.244641371818104709 +
                                               z * (-26.426256772545437796 +
                                                    z * (7.9035351947629579376 + z * (-1.7143161879285278382 +
                                                                                      z * 0.27945867147528962291)))))));
    // quarters modulo 4 as 0, 1, -2 or 2, -1
    const double left = quarters - 4.0 * ((0.25 * quarters + kRound) - kRound);
    const bool odd = left * left == 1.0, back = left * left == 4.0;
    const double sine_of = odd ? b : a, cosine_of = odd ? a : b;
    s[i] = (back || left == -1.0) ? -sine_of : sine_of;
    c[i] = (back || left == 1.0) ? -cosine_of : cosine_of;
  }
}

}  // namespace mtf
