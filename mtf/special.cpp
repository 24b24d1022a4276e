// SPDX-License-Identifier: Apache-2.0
#include "mtf/special.h"

namespace mtf {
namespace {

struct Reduced {
  double x;    // |x| <= 1/4
  int octant;  // x_original = octant / 2 + x, modulo 2
};

// remainder() is exact, so nothing is lost for any finite argument.
Reduced reduce(double x) {
  const double r = std::remainder(x, 2.0);  // [-1, 1]
  const int quarter = static_cast<int>(std::lround(2.0 * r));
  return {r - 0.5 * quarter, quarter & 3};
}

}  // namespace

double sin_pi(double x) {
  if (!std::isfinite(x)) return 0.0;
  const Reduced r = reduce(x);
  switch (r.octant) {
    case 0:
      return std::sin(kPi * r.x);
    case 1:
      return std::cos(kPi * r.x);
    case 2:
      return -std::sin(kPi * r.x);
    default:
      return -std::cos(kPi * r.x);
  }
}

double cos_pi(double x) {
  if (!std::isfinite(x)) return 1.0;
  const Reduced r = reduce(x);
  switch (r.octant) {
    case 0:
      return std::cos(kPi * r.x);
    case 1:
      return -std::sin(kPi * r.x);
    case 2:
      return -std::cos(kPi * r.x);
    default:
      return std::sin(kPi * r.x);
  }
}

ValueSlope sinc(double x) {
  const double ax = std::abs(x);
  if (!(ax < std::numeric_limits<double>::infinity())) return {0.0, 0.0};
  if (ax < 0.05) {  // series: the slope (cos - sinc)/x cancels here
    const double q = kPi * kPi * x * x;
    const double value = 1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0)));
    const double slope =
        -kPi * kPi * x / 3.0 * (1.0 - q / 10.0 * (1.0 - q / 28.0 * (1.0 - q / 54.0 * (1.0 - q / 88.0))));
    return {value, slope};
  }
  const double value = sin_pi(x) / (kPi * x);
  return {value, (cos_pi(x) - value) / x};
}

ValueSlope dirichlet(int n, double x) {
  if (n == 1) return {1.0, 0.0};
  if (!std::isfinite(x)) return {0.0, 0.0};
  // (-1)^((n-1) k) sinc(n r)/sinc(r), r = x - k the distance to the nearest whole number: sinc(r) >= 2/pi.
  const double wide = std::remainder(x, 2.0), r = std::remainder(wide, 1.0);
  const double sign = n % 2 == 0 && std::abs(wide) > 0.5 ? -1.0 : 1.0;
  const ValueSlope top = sinc(n * r), bottom = sinc(r);
  return {sign * top.value / bottom.value,
          sign * (n * top.slope - top.value * bottom.slope / bottom.value) / bottom.value};
}

ValueSlope gaussian(double x) {
  if (!(std::abs(x) < 7.0)) return {0.0, 0.0};  // below the smallest double from 6.2 on
  // exp turns the rounding of its argument into a relative error: the argument is kept in two parts.
  constexpr double c = 0x1.3bd3cc9be45dep+4, c_rest = 0x1.692b71366cc04p-50;  // 2 pi^2
  const double square = x * x, square_rest = std::fma(x, x, -square);
  const double exponent = c * square;
  const double rest = std::fma(c, square, -exponent) + (c * square_rest + c_rest * square);
  const double value = std::exp(-exponent) * (1.0 - rest);
  return {value, -4.0 * kPi * kPi * x * value};
}

}  // namespace mtf
