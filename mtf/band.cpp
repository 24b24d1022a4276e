// SPDX-License-Identifier: Apache-2.0
#include <cassert>
#include <cmath>

#include "mtf/special.h"
#include "mtf/system.h"

namespace mtf {

WavelengthNodes wavelength_nodes(const Band& band, int n) {
  assert(n >= 1 && n <= 512);
  WavelengthNodes nodes{std::vector<double>(static_cast<std::size_t>(n)),
                        std::vector<double>(static_cast<std::size_t>(n))};
  const double middle = 0.5 * (band.lo_um + band.hi_um), half = 0.5 * (band.hi_um - band.lo_um);
  for (int i = 0; i < n; ++i) {
    // Newton's iteration on the Legendre polynomial from Chebyshev's guess converges in a few steps for any n.
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5)), derivative = 1.0;
    for (int step = 0; step < 8; ++step) {
      double p = 1.0, previous = 0.0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * previous) / k;
        previous = p;
        p = next;
      }
      derivative = n * (x * p - previous) / (x * x - 1.0);
      const double change = p / derivative;
      x -= change;
      if (std::abs(change) < 1e-16) break;
    }
    nodes.wavelength_um[static_cast<std::size_t>(i)] = middle - half * x;
    nodes.weight[static_cast<std::size_t>(i)] = 1.0 / ((1.0 - x * x) * derivative * derivative);
  }
  return nodes;
}

}  // namespace mtf
