// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/edge_curve.h"

#include <algorithm>

namespace calib {
namespace {

struct Height {
  double value = 0.0, slope = 0.0, bend = 0.0;  // g, g', g''
};

// g and its derivatives; beyond the ends the tangent continues.
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

// The foot of a point: s with (s - s0) + g'(s) (g(s) - u0) = 0, by Newton's method, its derivative kept positive. The
// first steps come from the tangent, which is close where the curve is nearly straight; the error of the distance is
// the square of that of the foot.
CurveFoot foot_on_polynomial(const EdgeCurve& curve, double s0, double u0, double near, double small_step_px) {
  double s = near;
  Height g = polynomial(curve, s);
  for (int i = 0; i < 40; ++i) {
    const double pull = (s - s0) + g.slope * (g.value - u0);
    const double step = pull / std::max(1.0 + g.slope * g.slope + g.bend * (g.value - u0), 0.25);
    s -= step;
    g.value -= step * (g.slope - 0.5 * step * g.bend);
    g.slope -= step * g.bend;
    if (std::abs(step) < small_step_px) break;
    g = polynomial(curve, s);
  }
  const double away = u0 - g.value, along = s - s0;
  return {std::copysign(std::sqrt(along * along + away * away), away), s, g.value, g.slope};
}

CurveFoot foot_on_circle(double curvature_per_px, double s0, double u0) {
  const double k = curvature_per_px;
  const double square = s0 * s0 + u0 * u0;
  const double root = std::hypot(k * s0, 1.0 - k * u0);  // distance from the centre x k
  const double s = root > 0.0 ? s0 / root : 0.0, x = k * s, cosine = std::sqrt(std::max(1e-6, 1.0 - x * x));
  return {(2.0 * u0 - k * square) / (1.0 + root), s, x * s / (1.0 + cosine), x / cosine};
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
  return bend(curve, n.x * x + n.y * y, n.x * y - n.y * x);
}

EdgePoint bend(const EdgeCurve& curve, double u_px, double s_px, double small_step_px) {
  const CurveFoot foot = foot_near(curve, u_px, s_px, s_px, small_step_px);
  return {foot.distance_px, foot.along_px};
}

CurveFoot foot_near(const EdgeCurve& curve, double u_px, double s_px, double near_px, double small_step_px) {
  if (curve.shape == EdgeCurve::Shape::polynomial) return foot_on_polynomial(curve, s_px, u_px, near_px, small_step_px);
  if (curve.shape == EdgeCurve::Shape::circle) return foot_on_circle(curve.curvature_per_px, s_px, u_px);
  return {u_px, s_px, 0.0, 0.0};
}

}  // namespace calib
