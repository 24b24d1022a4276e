// SPDX-License-Identifier: Apache-2.0
#pragma once

// Scalar functions with value and slope right at their limits, for double, float and ceres::Jet.
// Each is a pair (value, slope) of doubles; `lift` carries it to S by the chain rule, so no derivative of sqrt(0) or
// acos(1) is ever formed. Branches depend on values only.
// Of the Bessel functions POSIX j0 and j1 of the C library keep 4 ulp of max(|J|, sqrt(2/(pi x))) up to
// 1e15 (tested against the reference table); std::cyl_bessel_j loses all digits from about 1e4 on.
// Sines and cosines of many angles in turns are in loops that the compiler vectorises. All vector code of mtf takes its
// sines from sin_cos_reduced.

#include <cmath>
#include <numbers>
#include <span>

#include "mtf/component.h"

namespace mtf {

inline constexpr double kPi = std::numbers::pi;

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

/// The value part of a scalar of any kind.
template <class S>
double value_of(const S& s) {
  if constexpr (requires { s.a; })
    return s.a;
  else
    return static_cast<double>(s);
}

/// f(x) with the derivative carried: x - value(x) is zero with the derivative part of x alone. A slope of 0 ends it,
/// also where x is infinite.
template <class S>
S lift(const ValueSlope& f, const S& x) {
  if constexpr (requires { x.a; })
    return f.slope == 0.0 ? S(f.value) : S(f.value) + S(f.slope) * (x - S(value_of(x)));
  else
    return static_cast<S>(f.value);
}

/// f(x, y) with both derivatives.
template <class S>
S lift(double value, double slope_x, const S& x, double slope_y, const S& y) {
  if constexpr (requires { x.a; })
    return S(value) + S(slope_x) * (x - S(value_of(x))) + S(slope_y) * (y - S(value_of(y)));
  else
    return static_cast<S>(value);
}

/// sin(pi x) and cos(pi x), the argument reduced exactly: zeros are exact, any finite x.
double sin_pi(double x);
double cos_pi(double x);
SinCos sin_cos_pi(double x);

/// sin(pi x)/(pi x); 0 at infinity. The value alone: the same bits.
ValueSlope sinc(double x);
double sinc_value(double x);

/// sin(n pi x)/(n sin(pi x)), n >= 1: the mean of n phases 2 pi x apart, measured from their middle. Exact where the
/// denominator is zero; 1 at infinity, as for every double beyond 2^54, a whole, even number.
ValueSlope dirichlet(int n, double x);
double dirichlet_value(int n, double x);

/// Bound of |1 - dirichlet| up to x: it falls monotonically to its first zero, at x = 1/n.
double dirichlet_deviation(int n, double x);

/// exp(-2 pi^2 x^2), x = sigma f; 0 at infinity.
ValueSlope gaussian(double x);

template <class S>
S sinc_of(const S& x) {
  if constexpr (requires { x.a; })
    return lift(sinc(value_of(x)), x);
  else
    return static_cast<S>(sinc_value(value_of(x)));
}

template <class S>
S dirichlet_of(int n, const S& x) {
  if constexpr (requires { x.a; })
    return lift(dirichlet(n, value_of(x)), x);
  else
    return static_cast<S>(dirichlet_value(n, value_of(x)));
}

template <class S>
S gaussian_of(const S& x) {
  return lift(gaussian(value_of(x)), x);
}

/// sqrt(x^2 + y^2) without overflow; at the origin its derivative is taken as 0 (OTFs are even there).
template <class S>
S radius(const S& x, const S& y) {
  const double r = std::hypot(value_of(x), value_of(y));
  if (r == 0.0) return S(0);
  return lift(r, value_of(x) / r, x, value_of(y) / r, y);
}

/// exp(-i pi x) as a complex number: the phase of a shift, argument reduced exactly.
template <class S>
Complex<S> phase_of(const S& x) {
  const auto [s, c] = sin_cos_pi(value_of(x));
  return {lift({c, -kPi * s}, x), lift({-s, -kPi * c}, x)};
}

/// J0(x); 0 at infinity.
inline ValueSlope bessel_j0(double x) {
  if (!std::isfinite(x)) return {0.0, 0.0};
  return {::j0(x), -::j1(x)};
}

/// 2 J1(x)/x, 1 at x = 0; 0 at infinity. Slope -2 J2(x)/x.
inline ValueSlope jinc(double x) {
  if (!std::isfinite(x)) return {0.0, 0.0};
  if (std::abs(x) < 0.1) {  // series: J2 by recurrence cancels here
    const double q = 0.25 * x * x;
    return {1.0 - q / 2.0 * (1.0 - q / 6.0 * (1.0 - q / 12.0 * (1.0 - q / 20.0))),
            -0.25 * x * (1.0 - q / 3.0 * (1.0 - q / 8.0 * (1.0 - q / 15.0 * (1.0 - q / 24.0))))};
  }
  const double value = 2.0 * ::j1(x) / x;
  return {value, 2.0 * (::j0(x) - value) / x};
}

}  // namespace mtf
