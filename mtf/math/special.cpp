// SPDX-License-Identifier: Apache-2.0
#include "mtf/math/special.h"

#include <cassert>
#include <limits>

#include "mtf/math/clones.h"

namespace mtf {
namespace {

struct Reduced {
  double x;     // |x| <= 1/4
  int quarter;  // x_original = quarter / 2 + x, modulo 2
};

// Both differences are exact for any finite argument: multiples of its last place, and small.
inline Reduced reduce(double x) {
  const double r = x - 2.0 * std::rint(0.5 * x);  // [-1, 1]
  const double n = std::rint(2.0 * r);
  return {r - 0.5 * n, static_cast<int>(n) & 3};
}

// Bodies that inline into one another, in the instructions of each machine: the same bits from all.

[[gnu::always_inline]] inline SinCos turned(double x) {
  if (x == 0.0) return {x, 1.0};  // along an axis, every time
  if (!std::isfinite(x)) return {0.0, 1.0};
  const Reduced r = reduce(x);
  const auto [s, c] = sin_cos_reduced(0.5 * r.x);
  switch (r.quarter) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

[[gnu::always_inline]] inline ValueSlope sinc_at(double x) {
  if (x == 0.0) return {1.0, 0.0};  // along an axis, every time
  const double ax = std::abs(x);
  if (!(ax < std::numeric_limits<double>::infinity())) return {0.0, 0.0};
  if (ax < 0.05) {  // series: the slope (cos - sinc)/x cancels here
    const double q = kPi * kPi * x * x;
    const double value =
        1.0 - q * (1.0 / 6.0) * (1.0 - q * (1.0 / 20.0) * (1.0 - q * (1.0 / 42.0) * (1.0 - q * (1.0 / 72.0))));
    const double slope =
        -kPi * kPi * x / 3.0 *
        (1.0 - q * (1.0 / 10.0) * (1.0 - q * (1.0 / 28.0) * (1.0 - q * (1.0 / 54.0) * (1.0 - q * (1.0 / 88.0)))));
    return {value, slope};
  }
  const SinCos turn = turned(x);
  const double value = turn.sin / (kPi * x);
  return {value, (turn.cos - value) / x};
}

[[gnu::always_inline]] inline ValueSlope dirichlet_at(int n, double x) {
  if (n == 1 || !std::isfinite(x)) return {1.0, 0.0};
  // (-1)^((n-1) k) sinc(n r)/sinc(r), r = x - k the distance to the nearest whole number: sinc(r) >= 2/pi.
  const double wide = x - 2.0 * std::rint(0.5 * x), r = wide - std::rint(wide);  // exact
  const double sign = n % 2 == 0 && std::abs(wide) > 0.5 ? -1.0 : 1.0;
  const ValueSlope top = sinc_at(n * r), bottom = sinc_at(r);
  return {sign * top.value / bottom.value,
          sign * (n * top.slope - top.value * bottom.slope / bottom.value) / bottom.value};
}

}  // namespace

MTFKIT_CLONES
SinCos sin_cos_pi(double x) { return turned(x); }
MTFKIT_CLONES
ValueSlope sinc(double x) { return sinc_at(x); }
MTFKIT_CLONES
double sinc_value(double x) { return sinc_at(x).value; }
MTFKIT_CLONES
ValueSlope dirichlet(int n, double x) { return dirichlet_at(n, x); }
MTFKIT_CLONES
double dirichlet_value(int n, double x) { return dirichlet_at(n, x).value; }

double sin_pi(double x) { return sin_cos_pi(x).sin; }
double cos_pi(double x) { return sin_cos_pi(x).cos; }

double dirichlet_deviation(int n, double x) {
  if (n == 1) return 0.0;
  return x * n < 1.0 ? 1.0 - dirichlet(n, x).value : 2.0;
}

MTFKIT_CLONES
ValueSlope gaussian(double x) {
  if (x == 0.0) return {1.0, 0.0};              // along an axis, every time
  if (!(std::abs(x) < 7.0)) return {0.0, 0.0};  // below the smallest double from 6.2 on
  // exp turns the rounding of its argument into a relative error: the argument is kept in two parts.
  constexpr double c = 0x1.3bd3cc9be45dep+4, c_rest = 0x1.692b71366cc04p-50;  // 2 pi^2
  const double square = x * x, square_rest = std::fma(x, x, -square);
  const double exponent = c * square;
  const double rest = std::fma(c, square, -exponent) + (c * square_rest + c_rest * square);
  const double value = std::exp(-exponent) * (1.0 - rest);
  return {value, -4.0 * kPi * kPi * x * value};
}

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
