// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/nonlinearity.h"

#include <algorithm>
#include <cmath>

#include "radiometry/light/pixel_rules.h"

namespace radiometry {

Response::Response(const Nonlinearity& nonlinearity, double full_well_e)
    : a2_(nonlinearity.a2),
      a3_(nonlinearity.a3),
      a4_(nonlinearity.a4),
      full_well_e_(full_well_e),
      at_full_(1.0 + a2_ + a3_ + a4_),
      slope_at_full_(1.0 + 2.0 * a2_ + 3.0 * a3_ + 4.0 * a4_) {
  require_valid("nonlinearity", nonlinearity);
  if (!(full_well_e > 0.0 && std::isfinite(full_well_e)))
    throw mtf::UsageError("nonlinearity: a full well of " + mtf::format_double(full_well_e) +
                          " electrons; it is relative to one above 0 and finite");
  // The slope over [0, 1]: at its ends, and where its own slope 2 a2 + 6 a3 u + 12 a4 u^2 is 0, in a form that holds
  // for a4 of 0 too.
  double lowest = std::min(1.0, slope_at_full_);
  const double root = std::sqrt(std::max(0.0, 9.0 * a3_ * a3_ - 24.0 * a2_ * a4_));
  const double q = -(3.0 * a3_ + std::copysign(root, a3_));
  for (const double u : {q / (12.0 * a4_), 2.0 * a2_ / q})
    if (u > 0.0 && u < 1.0) lowest = std::min(lowest, slope(u));
  if (!(lowest > 0.0))
    throw mtf::UsageError("nonlinearity: with a2 = " + mtf::format_double(a2_) + ", a3 = " + mtf::format_double(a3_) +
                          ", a4 = " + mtf::format_double(a4_) +
                          " the response does not rise everywhere up to the full well; keep 1 + 2 a2 u + 3 a3 u^2 + "
                          "4 a4 u^3 above 0 for u from 0 to 1");
}

double Response::operator()(double electrons) const {
  const double u = electrons / full_well_e_;
  if (!(u > 0.0)) return electrons;
  if (u > 1.0) return full_well_e_ * at_full_ + (electrons - full_well_e_) * slope_at_full_;
  return electrons * (1.0 + u * (a2_ + u * (a3_ + u * a4_)));
}

double Response::inverse(double response_e) const {
  const double v = response_e / full_well_e_;
  if (!(v > 0.0)) return response_e;
  if (v >= at_full_) return full_well_e_ + (response_e - full_well_e_ * at_full_) / slope_at_full_;
  // Newton's method between ends that always hold the root.
  double low = 0.0, high = 1.0, u = std::min(v, 1.0);
  for (int i = 0; i < 100; ++i) {
    const double miss = u * (1.0 + u * (a2_ + u * (a3_ + u * a4_))) - v;
    (miss > 0.0 ? high : low) = u;
    double next = u - miss / slope(u);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const bool done = std::abs(next - u) <= 1e-15 * u;
    u = next;
    if (done) break;
  }
  return u * full_well_e_;
}

void apply_response(mtf::ImageView<float> image, const Response& response, int threads) {
  for_each_pixel(image, threads, [&](double electrons) { return static_cast<float>(response(electrons)); });
}

void linearise(mtf::ImageView<float> image, const Response& response, int threads) {
  for_each_pixel(image, threads, [&](double electrons) { return static_cast<float>(response.inverse(electrons)); });
}

}  // namespace radiometry
