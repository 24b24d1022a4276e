// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sines and cosines of many angles in turns, in loops that the compiler vectorises. All vector code of mtf takes its
// sines from sin_cos_reduced.

#include <span>

namespace mtf {

struct SinCos {
  double sin = 0.0, cos = 1.0;
};

/// sin(2 pi r) and cos(2 pi r) for r in [-1/8, 1/8], within 1.35e-16: Chebyshev fits of sin(2 pi r)/r and cos(2 pi r)
/// in r^2, of relative error 2e-21 and 2e-23. 2 pi is taken in two parts and what 1 - 2 (pi r)^2 rounds off is put
/// back, so that little more than the rounding of the last sums remains.
[[gnu::always_inline]] inline SinCos sin_cos_reduced(double r) {
  const double z = r * r;
  const double sine_rest =
      2.4492935982947064e-16 +
      z * (-41.341702240399760142 +
           z * (81.605249276074930668 +
                z * (-76.70585975299812673 +
                     z * (42.058693928988783438 +
                          z * (-15.094640403891545649 + z * (3.8197881201632114229 + z * -0.71163580907816659965))))));
  const double cosine_rest =
      z * z *
      (64.93939402266829122 +
       z * (-85.456817206693549861 +
            z * (60.244641371818104709 +
                 z * (-26.426256772545437796 +
                      z * (7.9035351947629579376 + z * (-1.7143161879285278382 + z * 0.27945867147528962291))))));
  const double fall = 19.739208802178717238 * z, cosine = 1.0 - fall;
  return {6.283185307179586232 * r + r * sine_rest, cosine + (((1.0 - cosine) - fall) + cosine_rest)};
}

/// sine[i] = sin(2 pi turns[i]), cosine[i] likewise, within 3e-16 for any |turns| up to 2^51; all of one size.
void sin_cos_turns(std::span<const double> turns, std::span<double> sine, std::span<double> cosine);

}  // namespace mtf
