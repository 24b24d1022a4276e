// SPDX-License-Identifier: Apache-2.0
#pragma once

// An OTF split by scale, so that tiles need a short halo. The point spread of any aperture falls off slowly (its OTF
// has a kink at f = 0: shares of light beyond d fall as 1/d only), but slow tails are smooth: a coarse image of the
// whole scene carries them.
//   far   H(f) G(f),        G = (1 + q) exp(-q), q = 2 (pi sigma |f|)^2
//   near  H(f) (1 - G(f)),  1 - G = q^2/2 at small q: the kink at f = 0 is multiplied by f^4, and its tails are short
// near + far = H. The Gaussian exp(-q) of the far part is what making the coarse image and interpolating in it do.

#include <cmath>

namespace mtf {

struct ScaleSplit {
  enum class Part { whole, fine, coarse };
  Part part = Part::whole;
  double sigma_um = 0.0;

  bool operator==(const ScaleSplit&) const = default;
  bool is_whole() const { return part == Part::whole; }

  /// What the part multiplies the OTF by at |f| in cycles/mm; of `far` without its Gaussian, so it grows.
  double factor(double f_cy_mm) const {
    if (part == Part::whole) return 1.0;
    const double a = 3.14159265358979323846 * sigma_um * 1e-3 * f_cy_mm;
    const double q = 2.0 * a * a;
    return part == Part::coarse ? 1.0 + q : -std::expm1(-q) - q * std::exp(-q);
  }
};

}  // namespace mtf
