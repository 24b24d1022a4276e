// SPDX-License-Identifier: Apache-2.0
#include "calib/edge_curve.h"

#include <algorithm>

namespace calib {
namespace {

struct Height {
  double value = 0.0, slope = 0.0, bend = 0.0;  // g, g', g''
};

// g and its derivatives; the tangent goes on beyond the ends.
Height polynomial(const EdgeCurve& curve, double s) {
  const double t = std::clamp(s / curve.half_length_px, -1.0, 1.0);
  double value = 0.0, slope = 0.0, bend = 0.0;
  for (std::size_t k = curve.coefficient.size(); k-- > 0;) {  // Horner of sum c_k t^k, the factor t^2 follows
    bend = bend * t + 2.0 * slope;
    slope = slope * t + value;
    value = value * t + curve.coefficient[k];
  }
  bend = (bend * t + 4.0 * slope) * t + 2.0 * value;
  slope = (slope * t + 2.0 * value) * t;
  value *= t * t;
  const double per_px = 1.0 / curve.half_length_px;
  const double beyond = s - t * curve.half_length_px;
  return {value + slope * per_px * beyond, slope * per_px, beyond == 0.0 ? bend * per_px * per_px : 0.0};
}

// The foot of a point: s with (s - s0) + g'(s) (g(s) - u0) = 0, by Newton's method on the half of the derivative that
// stays positive where the curve bends less than a circle through the point.
EdgePoint locate_polynomial(const EdgeCurve& curve, double s0, double u0) {
  double s = s0;
  Height g = polynomial(curve, s);
  for (int i = 0; i < 30; ++i) {
    const double pull = (s - s0) + g.slope * (g.value - u0);
    const double stiffness = 1.0 + g.slope * g.slope + g.bend * (g.value - u0);
    const double step = pull / std::max(stiffness, 0.25);
    s -= step;
    g = polynomial(curve, s);
    if (std::abs(step) < 1e-4) break;  // the next would be its square, the error of the distance the square of that
  }
  const double away = u0 - g.value;
  return {std::copysign(std::sqrt((s - s0) * (s - s0) + away * away), away), s};
}

EdgePoint locate_circle(double curvature_per_px, double s0, double u0) {
  const double k = curvature_per_px;
  const double square = s0 * s0 + u0 * u0;
  const double root = std::sqrt(std::max(0.0, 1.0 - 2.0 * k * u0 + k * k * square));  // distance from the centre x k
  return {(2.0 * u0 - k * square) / (1.0 + root), root > 0.0 ? s0 / root : 0.0};
}

}  // namespace

double offset_at(const EdgeCurve& curve, double along_px) {
  if (curve.shape == EdgeCurve::Shape::line) return 0.0;
  if (curve.shape == EdgeCurve::Shape::polynomial) return polynomial(curve, along_px).value;
  const double turn = curve.curvature_per_px * along_px;
  return turn * along_px / (1.0 + std::sqrt(std::max(0.0, 1.0 - turn * turn)));
}

EdgePoint locate(const EdgeCurve& curve, Point p) {
  const Point n = curve.normal();
  const double x = p.x - curve.origin.x, y = p.y - curve.origin.y;
  const double u = n.x * x + n.y * y, s = n.x * y - n.y * x;
  switch (curve.shape) {
    case EdgeCurve::Shape::polynomial:
      return locate_polynomial(curve, s, u);
    case EdgeCurve::Shape::circle:
      return locate_circle(curve.curvature_per_px, s, u);
    case EdgeCurve::Shape::line:
      break;
  }
  return {u, s};
}

}  // namespace calib
