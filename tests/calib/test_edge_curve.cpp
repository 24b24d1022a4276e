// SPDX-License-Identifier: Apache-2.0
// Distances from lines, polynomials and circles against a search along the curve.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/edge/edge_curve.h"

namespace {

using calib::EdgeCurve;

double height(const EdgeCurve& curve, double s) {
  if (curve.shape == EdgeCurve::Shape::circle) {
    const double k = curve.curvature_per_px;
    return k * s * s / (1.0 + std::sqrt(1.0 - k * k * s * s));
  }
  const double t = std::clamp(s / curve.half_length_px, -1.0, 1.0);
  double g = 0.0, slope = 0.0;
  for (std::size_t i = 0; i < curve.coefficient.size(); ++i) {
    const double k = static_cast<double>(i) + 2.0;
    g += curve.coefficient[i] * std::pow(t, k);
    slope += k * curve.coefficient[i] * std::pow(t, k - 1.0);
  }
  return g + slope / curve.half_length_px * (s - t * curve.half_length_px);
}

// Golden section around the nearest of many points of the curve.
double searched_distance(const EdgeCurve& curve, double s0, double u0) {
  const auto away = [&](double s) { return std::hypot(s - s0, height(curve, s) - u0); };
  double best = s0;
  for (double s = s0 - 30.0; s <= s0 + 30.0; s += 0.01)
    if (away(s) < away(best)) best = s;
  double low = best - 0.02, high = best + 0.02;
  for (int i = 0; i < 80; ++i) {
    const double a = high - 0.618 * (high - low), b = low + 0.618 * (high - low);
    (away(a) < away(b) ? high : low) = away(a) < away(b) ? b : a;
  }
  return std::copysign(away(0.5 * (low + high)), u0 - height(curve, s0));
}

void compare(const EdgeCurve& curve) {
  const calib::Point n = curve.normal(), t{-n.y, n.x};
  for (double s = -70.0; s <= 70.0; s += 11.3) {
    for (double u = -12.0; u <= 12.0; u += 3.1) {
      const calib::Point p{curve.origin.x + s * t.x + u * n.x, curve.origin.y + s * t.y + u * n.y};
      EXPECT_NEAR(calib::locate(curve, p).distance_px, searched_distance(curve, s, u), 2e-8) << s << ' ' << u;
    }
  }
}

}  // namespace

TEST(EdgeCurve, ALineIsTheNormalForm) {
  const EdgeCurve line{.origin = {10.0, 20.0}, .angle_rad = 0.3, .coefficient = {}};
  const calib::EdgePoint at = calib::locate(line, {13.0, 24.0});
  EXPECT_NEAR(at.distance_px, 3.0 * std::cos(0.3) + 4.0 * std::sin(0.3), 1e-13);
  EXPECT_NEAR(at.along_px, 4.0 * std::cos(0.3) - 3.0 * std::sin(0.3), 1e-13);
  EXPECT_EQ(line.order(), 1);
}

TEST(EdgeCurve, PolynomialsAndTheirTangents) {
  compare({.shape = EdgeCurve::Shape::polynomial,
           .origin = {50.0, 40.0},
           .angle_rad = 2.0,
           .half_length_px = 50.0,
           .coefficient = {3.0, -1.0, 0.5, 0.8}});
}

TEST(EdgeCurve, Circles) {
  for (const double curvature : {1.0 / 150.0, -1.0 / 400.0})
    compare({.shape = EdgeCurve::Shape::circle,
             .origin = {-5.0, 7.0},
             .angle_rad = -1.1,
             .half_length_px = 50.0,
             .coefficient = {},
             .curvature_per_px = curvature});
  // The centre itself is one radius away, on the brighter side.
  const EdgeCurve circle{
      .shape = EdgeCurve::Shape::circle, .origin = {0.0, 0.0}, .coefficient = {}, .curvature_per_px = 0.1};
  EXPECT_NEAR(calib::locate(circle, {10.0, 0.0}).distance_px, 10.0, 1e-12);
  EXPECT_NEAR(calib::locate(circle, {25.0, 0.0}).distance_px, -5.0, 1e-12);
}
