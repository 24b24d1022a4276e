// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/edge_distances.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/math/clones.h"

namespace calib {
namespace {

constexpr double kNear_px = 16.0, kNearStep_px = 0.01, kFarStep_px = 0.5;
constexpr std::size_t kPowers = 4;  // t^2 .. t^5
constexpr std::size_t kTogether = 128;

MTFKIT_CLONES void bend_circle(double k, double* u, double* s, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double square = s[i] * s[i] + u[i] * u[i], away = 1.0 - k * u[i], turn = k * s[i];
    const double root = std::sqrt(turn * turn + away * away);  // distance from the centre x k
    u[i] = (2.0 * u[i] - k * square) / (1.0 + root);
    s[i] = root > 0.0 ? s[i] / root : 0.0;
  }
}

struct Polynomial {
  std::array<double, kPowers> c{};
  double half_length_px = 1.0;
};

// One step of Newton's method for the feet s of the points (u, start), with (s - start) + g'(s) (g(s) - u) = 0, its
// derivative kept positive; `height` becomes g at the new feet. Returns whether a step was longer than the search may
// end with.
MTFKIT_CLONES bool step_feet(const Polynomial& curve, const double* u, const double* start, double* s, double* height,
                             std::size_t n) {
  const double half = curve.half_length_px, per_px = 1.0 / half;
  const auto [c2, c3, c4, c5] = curve.c;
  int longer = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double inside = std::min(std::max(s[i], -half), half), beyond = s[i] - inside, t = inside * per_px;
    const double slope = t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5))) * per_px;
    const double g = t * t * (c2 + t * (c3 + t * (c4 + t * c5))) + slope * beyond;  // beyond the ends a tangent
    const double curved = (2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))) * per_px * per_px;
    const double bend = beyond == 0.0 ? curved : 0.0;
    const double pull = (s[i] - start[i]) + slope * (g - u[i]);
    const double step = pull / std::max(1.0 + slope * slope + bend * (g - u[i]), 0.25);
    s[i] -= step;
    height[i] = g - step * (slope - 0.5 * step * bend);
    longer |= std::abs(step) > (std::abs(u[i]) < kNear_px ? kNearStep_px : kFarStep_px) ? 1 : 0;
  }
  return longer != 0;
}

MTFKIT_CLONES void measure_feet(const double* start, const double* height, const double* s, double* u, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double away = u[i] - height[i], along = s[i] - start[i];
    u[i] = std::copysign(std::sqrt(along * along + away * away), away);
  }
}

}  // namespace

void bend_all(const EdgeCurve& curve, std::span<double> u_px, std::span<double> s_px) {
  if (curve.shape == EdgeCurve::Shape::line) return;
  if (curve.shape == EdgeCurve::Shape::circle) {
    bend_circle(curve.curvature_per_px, u_px.data(), s_px.data(), u_px.size());
    return;
  }
  Polynomial polynomial{.half_length_px = curve.half_length_px};
  std::copy_n(curve.coefficient.begin(), std::min(kPowers, curve.coefficient.size()), polynomial.c.begin());
  std::array<double, kTogether> start, height;
  for (std::size_t first = 0; first < u_px.size(); first += kTogether) {
    const std::size_t n = std::min(kTogether, u_px.size() - first);
    double *const u = u_px.data() + first, *const s = s_px.data() + first;
    std::copy_n(s, n, start.begin());
    constexpr int kMostSteps = 40;
    for (int k = 0; k < kMostSteps; ++k)
      if (!step_feet(polynomial, u, start.data(), s, height.data(), n)) break;
    measure_feet(start.data(), height.data(), s, u, n);
  }
}

}  // namespace calib
