// SPDX-License-Identifier: Apache-2.0
#include "mtf/math/turns.h"

#include <cassert>

#include "mtf/math/clones.h"

namespace mtf {

// Quarter turns are subtracted exactly; sin_cos_reduced takes the rest.
MTFKIT_CLONES
void sin_cos_turns(std::span<const double> turns, std::span<double> sine, std::span<double> cosine) {
  assert(sine.size() == turns.size() && cosine.size() == turns.size());
  const double* x = turns.data();
  double *s = sine.data(), *c = cosine.data();
  constexpr double kRound = 0x1.8p52;  // adding and subtracting it rounds to a whole number
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const double quarters = (4.0 * x[i] + kRound) - kRound;
    const double r = x[i] - 0.25 * quarters;
    const auto [a, b] = sin_cos_reduced(r);
    // quarters modulo 4 as 0, 1, -2 or 2, -1
    const double left = quarters - 4.0 * ((0.25 * quarters + kRound) - kRound);
    const bool odd = left * left == 1.0, back = left * left == 4.0;
    const double sine_of = odd ? b : a, cosine_of = odd ? a : b;
    s[i] = (back || left == -1.0) ? -sine_of : sine_of;
    c[i] = (back || left == 1.0) ? -cosine_of : cosine_of;
  }
}

}  // namespace mtf
