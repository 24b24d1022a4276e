// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/correction/step_changes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calib {
namespace {

using Kind = StepChange::Kind;
constexpr double kPi = std::numbers::pi;

// The cubic B-spline of unit knots and its slope.
double spline(double x) {
  const double a = std::abs(x);
  if (a >= 2.0) return 0.0;
  const double b = 2.0 - a;
  return a < 1.0 ? 2.0 / 3.0 - a * a * (1.0 - 0.5 * a) : b * b * b / 6.0;
}
double spline_slope(double x) {
  const double a = std::abs(x), b = 2.0 - a;
  if (a >= 2.0) return 0.0;
  return (x < 0.0 ? -1.0 : 1.0) * (a < 1.0 ? a * (1.5 * a - 2.0) : -0.5 * b * b);
}

// A pair: of the splines at x and at -x, the second with the sign of its kind. At 0 they are one.
template <class Function>
double pair_of(const StepChange& pair, double d_px, const Function& function) {
  const double own = function((d_px - pair.x_px) / pair.h_px);
  if (pair.x_px == 0.0) return own;
  const double mirrored = function((d_px + pair.x_px) / pair.h_px);
  return pair.kind == Kind::odd ? own - mirrored : own + mirrored;
}

double phi(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }
double density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi); }

}  // namespace

double change_value(const StepChange& change, double d_px) {
  if (!change.wide()) return pair_of(change, d_px, spline);
  const double x = d_px / change.h_px, narrow = phi(d_px / change.x_px);
  return (change.kind == Kind::lorentzian ? 0.5 + std::atan(x) / kPi : phi(x)) - narrow;
}

double change_slope(const StepChange& change, double d_px) {
  if (!change.wide()) return pair_of(change, d_px, spline_slope) / change.h_px;
  const double x = d_px / change.h_px, narrow = density(d_px / change.x_px) / change.x_px;
  return (change.kind == Kind::lorentzian ? 1.0 / (kPi * (1.0 + x * x)) : density(x)) / change.h_px - narrow;
}

double wide_otf(const StepChange& change, double f_cy_px) {
  const double turn = 2.0 * kPi * f_cy_px, wide = turn * change.h_px, narrow = turn * change.x_px;
  return std::exp(change.kind == Kind::lorentzian ? -wide : -0.5 * wide * wide) - std::exp(-0.5 * narrow * narrow);
}

std::vector<StepChange> place_changes(double width_px, double extent_px, Detail detail) {
  const bool fine = detail == Detail::fine;
  std::vector<StepChange> changes;
  const double end =
      std::min(extent_px, fine ? std::clamp(6.0 * width_px, 16.0, 32.0) : std::clamp(4.0 * width_px, 8.0, 24.0));
  const auto place_splines = [&](Kind kind) {
    double h = std::clamp(width_px / 8.0, 0.25, 1.5),
           zone_end = fine ? std::max(4.0, 2.0 * width_px) : std::max(2.5, 1.25 * width_px);
    double x = kind == Kind::odd ? h : 0.0;
    while (detail != Detail::none && x + 2.0 * h < end) {
      const double away = x / (1.0 + width_px);
      changes.push_back({kind, x, h, 1.0 / (1.0 + away * away)});
      if (x + h > zone_end) {
        x += 0.5 * h;  // the mean of the steps of both zones
        h *= 2.0;
        zone_end *= 2.0;
      }
      x += h;
    }
  };
  place_splines(Kind::odd);
  // Of a Gaussian blur the width is 2.5 standard deviations. Light scattered further than the pixels extend can hardly
  // be told from their plateaus.
  constexpr double kNarrow = 0.4, kGaussians = 1.5, kLorentzians = 5.0, kBeyond = 2.5;
  const double narrow_px = kNarrow * width_px;
  for (const double px : {2.0, 4.0, 8.0, 16.0, 32.0})
    if (px >= kGaussians * narrow_px && px < extent_px) changes.push_back({Kind::gaussian, narrow_px, px});
  for (const double px : {6.0, 12.0, 24.0, 48.0, 96.0})
    if (px >= kLorentzians * narrow_px && px < kBeyond * extent_px)
      changes.push_back({Kind::lorentzian, narrow_px, px});
  place_splines(Kind::even);
  return changes;
}

}  // namespace calib
