// SPDX-License-Identifier: Apache-2.0
#include "mtf/math/fresnel.h"

#include <array>
#include <utility>

namespace mtf {
namespace {

// x^2 and weight of the nodes x = k/5; the error of the sum is exp(-2 pi Im(pole)/step) < 1e-15.
struct Nodes {
  static constexpr std::size_t count = 34;
  std::array<double, count> square, weight;
  Nodes() {
    constexpr double step = 0.2;
    for (std::size_t k = 0; k < count; ++k) {
      const double x = step * static_cast<double>(k);
      square[k] = x * x;
      weight[k] = std::exp(-x * x) * step * (k == 0 ? 1.0 : 2.0) / std::sqrt(kPi);
    }
  }
};

// cos and sin of pi u^2 / 2, the square carried in two parts so that a large phase is reduced exactly.
std::pair<double, double> quadratic_phase(double u) {
  const double square = u * u, rest = std::isfinite(square) ? std::fma(u, u, -square) : 0.0;
  const double c = cos_pi(0.5 * square), s = sin_pi(0.5 * square), dc = cos_pi(0.5 * rest), ds = sin_pi(0.5 * rest);
  return {c * dc - s * ds, s * dc + c * ds};
}

}  // namespace

FresnelTail fresnel_tail(double y) {
  static const Nodes nodes;
  FresnelTail tail;
  for (std::size_t k = 0; k < Nodes::count; ++k) {
    const double t = nodes.square[k], r = t * y, part = 1.0 / (1.0 + r * r), weighted = nodes.weight[k] * part;
    tail.f.value += weighted;
    tail.f.slope -= 2.0 * weighted * part * r * t;
    tail.g.value += weighted * r;
    tail.g.slope += weighted * part * t * (1.0 - r * r);
  }
  return tail;
}

FresnelIntegrals fresnel(double u) {
  const double v = std::abs(u);
  const double sign = u < 0.0 ? -1.0 : 1.0;
  if (!(v < 1e150)) return {{0.5 * sign, 0.0}, {0.5 * sign, 0.0}};
  const auto [cosine, sine] = quadratic_phase(v);
  if (v < kFresnelTailFrom) {
    // C and S together are the sum over n of i^n (pi u^2/2)^n / n! x u/(2n + 1).
    const double phase = 0.5 * kPi * v * v;
    double term = v, c = v, s = 0.0;
    for (int n = 1; n <= 30 && term > 1e-18 * v; ++n) {
      term *= phase / n;
      const double part = term / (2 * n + 1);
      (n % 2 == 0 ? c : s) += n % 4 < 2 ? part : -part;
    }
    return {{sign * c, cosine}, {sign * s, sine}};
  }
  const FresnelTail tail = fresnel_tail(2.0 / (kPi * v * v));
  const double f = tail.f.value / (kPi * v), g = tail.g.value / (kPi * v);
  return {{sign * (0.5 + f * sine - g * cosine), cosine}, {sign * (0.5 - f * cosine - g * sine), sine}};
}

}  // namespace mtf
