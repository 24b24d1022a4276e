// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where an edge runs, and how far a pixel is from it.
// Pixel (i, j) has its centre at (i + 0.5, j + 0.5), in pixels, x right, y down, of the whole image. Around the
// reference point p0 with the unit normal n, which points to the brighter side, and the tangent t = (-n.y, n.x), a
// point p has the coordinates
//   s = t.(p - p0) along the edge,  u = n.(p - p0) across it.
// The edge is the curve u = g(s). Straight: g = 0. Polynomial: g = sum of c_k (s / half_length)^k for k = 2 .. 5, in
// pixels (offset and slope are in p0 and n); beyond |s| = half_length it continues along its tangents. Circle:
// curvature kappa in 1/px, positive when the centre lies on the brighter side. The edge spread function is a function
// of the signed distance to the curve, positive on the brighter side, as long as the blur is small against the radius
// of curvature.

#include <cmath>
#include <cstdint>
#include <vector>

namespace calib {

/// A rectangle of pixels.
struct Roi {
  bool operator==(const Roi&) const = default;
  std::int64_t x = 0, y = 0;
  std::int64_t width = 0, height = 0;
};

struct Point {
  double x = 0.0, y = 0.0;
};

struct EdgeCurve {
  enum class Shape { line, polynomial, circle };

  Shape shape = Shape::line;
  Point origin;                     ///< p0, pixels of the whole image
  double angle_rad = 0.0;           ///< of n, from +x towards +y, in (-pi, pi]
  double half_length_px = 1.0;      ///< scale of s in the polynomial
  std::vector<double> coefficient;  ///< c_2 .. c_order in px; empty unless a polynomial
  double curvature_per_px = 0.0;    ///< of the circle

  Point normal() const { return {std::cos(angle_rad), std::sin(angle_rad)}; }
  int order() const { return shape == Shape::polynomial ? static_cast<int>(coefficient.size()) + 1 : 1; }
};

/// A point in the coordinates of the edge.
struct EdgePoint {
  double distance_px = 0.0;  ///< signed, to the curve, positive on the brighter side
  double along_px = 0.0;     ///< s of its foot on the curve
};

/// u of the curve at s.
double offset_at(const EdgeCurve& curve, double along_px);

/// The coordinates of a point of the image. The error of the foot point of a polynomial is below 1e-9 px where the
/// radius of curvature is above twice the distance.
EdgePoint locate(const EdgeCurve& curve, Point p);
/// The same from u across and s along the tangent at p0. The search for the foot ends with a step below
/// `small_step_px`, which leaves an error of the distance of third order in it.
EdgePoint bend(const EdgeCurve& curve, double u_px, double s_px, double small_step_px = 1e-4);

/// The foot of a point on the curve, and the curve there.
struct CurveFoot {
  double distance_px = 0.0;  ///< of the point, as in EdgePoint
  double along_px = 0.0;     ///< s of the foot
  double height_px = 0.0;    ///< g(s)
  double slope = 0.0;        ///< g'(s)
};
/// As bend(), with a search that starts from `near_px` along: one step is enough there if that is the foot on nearly
/// the same curve.
CurveFoot foot_near(const EdgeCurve& curve, double u_px, double s_px, double near_px, double small_step_px);

}  // namespace calib
