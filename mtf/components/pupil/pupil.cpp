// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/pupil.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mtf/math/special.h"

// Areas of overlapping annuli cancel: the rings of a narrow annulus are small differences of large discs. Three forms
// avoid it, so that the error stays a few ulp of 1 for any obscuration:
//   wide    2 nu <= 1 - e: both holes lie inside the other disc; 1 - M is a sum of positive terms
//   narrow  few common points are left (nu near or beyond e): sums of circle segments, each small and accurate
//   middle  differences of angles and of half chords, each from a difference of squares in closed form
// 1 - nu, e - nu, 1 - e are formed first; nothing near 1 is subtracted later.

namespace mtf {
namespace {

// x - sin x without cancellation.
double x_minus_sin(double x) {
  if (x > 1.0) return x - std::sin(x);
  const double q = x * x;
  double sum = 0.0;
  for (int n = 10; n >= 1; --n) sum = (1.0 - sum) * q / ((2.0 * n) * (2.0 * n + 1.0));
  return x * sum;
}

// Discs of radius 1 and e, centres d = 2 nu apart, and what the forms share.
struct Circles {
  double nu, e, gap, ring;         // gap = 1 - e, ring = 1 - e^2
  double from_inside, to_outside;  // d - (1 - e), (1 + e) - d, rounded once: signs say how a disc and a hole lie
  double outer_half_chord;         // common chord of the two outer circles, halved
  double inner_half_chord;         // of the two holes; 0 when they are apart
  double inner_angle;              // half angle of the holes' common arc

  Circles(double nu_in, double e_in)
      : nu(nu_in),
        e(e_in),
        gap(1.0 - e_in),
        ring((1.0 - e_in) * (1.0 + e_in)),
        // d - 1 is exact where a small hole touches the edge from either side, 1 - e where a large one does.
        from_inside(e_in < 0.5 ? (2.0 * nu_in - 1.0) + e_in : 2.0 * nu_in - (1.0 - e_in)),
        to_outside((1.0 - 2.0 * nu_in) + e_in),
        outer_half_chord(root_of_product(1.0 - nu_in, 1.0 + nu_in)),
        inner_half_chord(root_of_product(e_in - nu_in, e_in + nu_in)),
        inner_angle(nu_in < e_in ? std::atan2(inner_half_chord, nu_in) : 0.0) {}
};

// M = 1 - [area that both pupils lose to each other] / ring.
PupilMtf wide(const Circles& c) {
  const double turn = c.nu < c.e ? std::atan2(c.nu, c.inner_half_chord) : 0.5 * kPi;  // asin(nu/e), at most pi/2
  const double outer = std::asin(c.nu) + c.nu * c.outer_half_chord;
  const double inner = c.e * c.e * turn + std::min(c.nu, c.e) * c.inner_half_chord;
  const double lost = (2.0 / kPi) * (outer + inner) / c.ring;
  return {1.0 - lost, -(4.0 / kPi) * (c.outer_half_chord + c.inner_half_chord) / c.ring,
          -((4.0 / kPi) * c.e * turn + 2.0 * c.e * lost) / c.ring};
}

// Where an outer circle crosses the other hole's edge.
struct Crossing {
  double above, below;  // sqrt((1 + e - d)(1 + e + d)), sqrt((d - gap)(d + gap)); 0 when the circles do not cross
  double half_chord;
  double alpha, beta;  // half angles of the arcs: of the outer circle inside the hole, of the hole inside the disc

  explicit Crossing(const Circles& c)
      : above(root_of_product(c.to_outside, 1.0 + c.e + 2.0 * c.nu)),
        below(root_of_product(c.from_inside, 2.0 * c.nu + c.gap)),
        half_chord(above * below / (4.0 * c.nu)),
        alpha(std::atan2(half_chord, c.nu + c.ring / (4.0 * c.nu))),
        beta(std::atan2(half_chord, c.nu - c.ring / (4.0 * c.nu))) {}
};

double d_obscuration(const Circles& c, double hole_arc, double value) {
  // An area grows with a radius by the arc that lies inside the other circle.
  return (-(4.0 / kPi) * c.e * hole_arc + 2.0 * c.e * value) / c.ring;
}

PupilMtf narrow(const Circles& c, double outer_angle) {
  const Crossing x(c);
  const double e2 = c.e * c.e;
  const double area = x_minus_sin(2.0 * outer_angle) - x_minus_sin(2.0 * x.alpha) - e2 * x_minus_sin(2.0 * x.beta) +
                      e2 * x_minus_sin(2.0 * c.inner_angle);
  const double value = std::max(area / (kPi * c.ring), 0.0);
  const double slope = (4.0 / kPi) * (2.0 * x.half_chord - c.outer_half_chord - c.inner_half_chord) / c.ring;
  return {value, slope, d_obscuration(c, x.beta - c.inner_angle, value)};
}

// With A = asin nu, B = asin(nu/e), C = asin(nu/sqrt e), g half the angle between the radii to a crossing point, and
// o, h, i the half chords (two outer circles, outer circle and hole, two holes):
//   M = (2/pi) [(2g - A - B)/ring + q - nu (u - v)],  q = beta - inner_angle, u = (o - h)/ring, v = (h - i)/ring,
//   2g - A - B = -2 (C - g) + [(C - A) - (B - C)].
// In a narrow ring every term is of the order of its width, the order of M itself. Each comes with that factor in
// front: from differences of squares, o^2 - i^2 = ring, and sin(x - y) = (sin^2 x - sin^2 y)/sin(x + y).
PupilMtf middle(const Circles& c) {
  const Crossing x(c);
  const double o = c.outer_half_chord, h = x.half_chord, i = c.inner_half_chord;
  const double root_e = std::sqrt(c.e);
  const double leg = std::sqrt(c.e * c.gap + (c.e - c.nu) * (c.e + c.nu));  // sqrt(e - nu^2)
  const double c_g = std::asin(std::min(1.0, c.gap * c.gap / (2.0 * (c.nu * x.above + leg * x.below))));
  const double sin_ca = std::min(1.0, c.nu * c.gap / (root_e * (o + leg)));
  const double sin_bc = std::min(1.0, c.nu * c.gap / (root_e * (i + leg)));
  const double over_ring = -sin_ca / ((i + o) * (i + leg));  // (sin_ca - sin_bc)/ring
  const double second = std::asin(
      c.ring * over_ring * (sin_ca + sin_bc) /
      (sin_ca * root_of_product(1.0 - sin_bc, 1.0 + sin_bc) + sin_bc * root_of_product(1.0 - sin_ca, 1.0 + sin_ca)));
  const double quarter = 1.0 / (16.0 * c.nu * c.nu);
  const double v = (0.5 - c.ring * quarter) / (i + h);
  const double u_v = c.ring * (quarter * (1.0 / (o + h) + 1.0 / (i + h)) - 0.5 / ((i + o) * (o + h) * (i + h)));
  const double lag = c.ring / (4.0 * c.nu);
  const double q = std::atan2(c.nu * (c.ring * v) + lag * i, (c.nu - lag) * c.nu + h * i);
  const double value = (2.0 / kPi) * ((-2.0 * c_g + second) / c.ring + (q - c.nu * u_v));
  return {std::max(value, 0.0), -(4.0 / kPi) * u_v, d_obscuration(c, q, value)};
}

}  // namespace

ValueSlope circular_pupil_mtf(double nu) {
  if (!(nu < 1.0)) return {};
  const double half_chord = std::sqrt((1.0 - nu) * (1.0 + nu));
  const double theta = std::atan2(half_chord, nu);
  const double value = theta < 0.5 ? x_minus_sin(2.0 * theta) / kPi : (2.0 / kPi) * (theta - nu * half_chord);
  return {value, -(4.0 / kPi) * half_chord};
}

PupilMtf annular_pupil_mtf(double nu, double obscuration) {
  if (obscuration == 0.0) {
    const ValueSlope clear = circular_pupil_mtf(nu);
    return {clear.value, clear.slope, 0.0};
  }
  if (!(nu < 1.0)) return {};
  // A float rounds the largest obscurations to 1, where no pupil is left.
  const Circles c(nu, std::min(obscuration, 1.0 - 0x1p-53));
  if (c.from_inside <= 0.0) return wide(c);
  const double outer_angle = std::atan2(c.outer_half_chord, nu);
  // Relative to M ~ gap/angle the error of `narrow` grows as angle^4/gap^2, that of `middle` as 1/angle^2.
  const bool few_points = nu >= c.e || outer_angle * outer_angle < 4.0 * c.gap;
  return few_points ? narrow(c, outer_angle) : middle(c);
}

std::vector<double> pupil_kinks(double obscuration, double cutoff) {
  std::vector<double> kinks{cutoff};
  if (obscuration > 0.0)
    kinks.insert(kinks.end(),
                 {0.5 * (1.0 - obscuration) * cutoff, obscuration * cutoff, 0.5 * (1.0 + obscuration) * cutoff});
  std::sort(kinks.begin(), kinks.end());
  return kinks;
}

double root_of_product(double a, double b) { return std::sqrt(std::max(a * b, 0.0)); }

PupilCaps pupil_caps(double nu, double obscuration) {
  PupilCaps caps;
  const auto add = [&](double sign, double side, double radius, double angle, bool hole) {
    if (angle > 0.0) caps.cap[static_cast<std::size_t>(caps.count++)] = {sign, -side * nu, side, radius, angle, hole};
  };
  const double e = obscuration;
  // Angles from legs, so that neither end of acos loses digits; differences like 1 - nu are formed first.
  const double outer = std::atan2(root_of_product(1.0 - nu, 1.0 + nu), nu);
  for (const double side : {1.0, -1.0}) add(1.0, side, 1.0, outer, false);
  if (e == 0.0) return caps;
  if (nu < e)
    for (const double side : {1.0, -1.0}) add(1.0, side, e, std::atan2(root_of_product(e - nu, e + nu), nu), true);
  // d - (1 - e) and (1 + e) - d, rounded once: d - 1 is exact where a small hole touches the edge from either side,
  // 1 - e where a large one does. The slopes there go with the roots of these.
  const double gap = 1.0 - e;
  const double from_inside = e < 0.5 ? (2.0 * nu - 1.0) + e : 2.0 * nu - gap, to_outside = (1.0 - 2.0 * nu) + e;
  if (from_inside <= 0.0) {  // a hole lies inside the other disc
    for (const double side : {1.0, -1.0}) add(-1.0, side, e, std::numbers::pi, true);
    return caps;
  }
  if (to_outside <= 0.0) return caps;
  const double ring = gap * (1.0 + e);
  const double half_chord = root_of_product(to_outside, 1.0 + e + 2.0 * nu);
  const double crossing = half_chord * root_of_product(from_inside, 2.0 * nu + gap) / (4.0 * nu);
  for (const double side : {1.0, -1.0}) {
    add(-1.0, side, 1.0, std::atan2(crossing, nu + ring / (4.0 * nu)), false);
    add(-1.0, -side, e, std::atan2(crossing, nu - ring / (4.0 * nu)), true);
  }
  return caps;
}

}  // namespace mtf
