// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil.h"

#include <algorithm>
#include <cmath>

#include "mtf/special.h"

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

// Angle acos(nu) for 0 <= nu <= 1; acos itself loses its relative accuracy near 1.
double half_angle(double nu) { return nu < 0.5 ? std::acos(nu) : 2.0 * std::asin(std::sqrt(0.5 * (1.0 - nu))); }

struct Lens {
  double area = 0.0;
  double beta = 0.0;   // half angle of the arc of the small circle that lies inside the large one
  double chord = 0.0;  // common chord
};

// Overlap of the unit circle and one of radius e <= 1 with centres d apart.
Lens unequal_lens(double e, double d) {
  if (d <= 1.0 - e) return {kPi * e * e, kPi, 0.0};
  if (d >= 1.0 + e) return {};
  const double alpha_cos = (d * d + (1.0 - e) * (1.0 + e)) / (2.0 * d);
  const double beta_cos = (d * d - (1.0 - e) * (1.0 + e)) / (2.0 * d * e);
  const double product = (1.0 + e - d) * (d + 1.0 - e) * (d - (1.0 - e)) * (d + 1.0 + e);
  const double kite = std::sqrt(std::max(product, 0.0));  // = chord x d
  // atan2 keeps both angles accurate where a cosine is next to +-1.
  const double alpha = std::atan2(kite, 2.0 * d * alpha_cos);
  const double beta = std::atan2(kite, 2.0 * d * e * beta_cos);
  return {alpha + e * e * beta - 0.5 * kite, beta, kite / d};
}

}  // namespace

ValueSlope circular_pupil_mtf(double nu) {
  if (!(nu < 1.0)) return {};
  const double theta = half_angle(nu);
  const double value =
      theta < 0.5 ? x_minus_sin(2.0 * theta) / kPi : (2.0 / kPi) * (theta - nu * std::sqrt((1.0 - nu) * (1.0 + nu)));
  return {value, -(4.0 / kPi) * std::sqrt((1.0 - nu) * (1.0 + nu))};
}

PupilMtf annular_pupil_mtf(double nu, double obscuration) {
  const double e = obscuration;
  const ValueSlope outer = circular_pupil_mtf(nu);
  if (e == 0.0) return {outer.value, outer.slope, 0.0};
  if (!(nu < 1.0)) return {};
  const double ring = (1.0 - e) * (1.0 + e);
  const ValueSlope inner = circular_pupil_mtf(nu / e);  // of the obscuration, on its own scale
  const Lens cross = unequal_lens(e, 2.0 * nu);
  const double inner_angle = nu < e ? half_angle(nu / e) : 0.0;
  const double value = (outer.value - 2.0 * cross.area / kPi + e * e * inner.value) / ring;
  const double d_nu = (outer.slope + 4.0 * cross.chord / kPi + e * inner.slope) / ring;
  // An area grows with a radius by the arc that lies inside the other circle.
  const double d_areas = (-4.0 * e * cross.beta + 4.0 * e * inner_angle) / kPi;
  return {std::max(value, 0.0), d_nu, d_areas / ring + 2.0 * e * value / ring};
}

}  // namespace mtf
