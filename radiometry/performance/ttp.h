// SPDX-License-Identifier: Apache-2.0
#pragma once

// Targeting task performance: how much of a target's contrast is above threshold, summed over frequencies.
//   TTP_axis = integral of sqrt(C/CTF(f)) df over the band where CTF(f) < C, cycles/mrad
//   TTP      = sqrt(TTP_x TTP_y)
//   V        = TTP sqrt(A)/R, cycles on the target (A: its area, R: range)
// C: contrast of the target at the aperture on the scale of the CTF, dT/(2 S_tmp) for a temperature difference dT
// (contrast_threshold.h). The band is the one about the frequency of the least threshold: contrast that comes back
// beyond a zero of the MTF has the wrong sign and helps nobody.
// Where the band ends the integrand is 1, not 0: the ends are found to the digits of a double and their derivatives
// carried by the implicit function CTF(f) = C.
// (Vollmerhausen and Jacobs, AMSEL-NV-TR-230 (2004); Vollmerhausen, Jacobs and Driggers, Opt. Eng. 43, 2806 (2004).)

#include <algorithm>
#include <vector>

#include "radiometry/fields.h"
#include "radiometry/light/adaptive_integral.h"
#include "radiometry/performance/implicit_root.h"

namespace radiometry {

/// The course of 1/CTF along one axis, from samples of it: what finding bands for many contrasts shares.
struct SensitivityCourse {
  std::vector<double> f_cy_mrad, value;  ///< 0, then rising geometrically; the largest is among them
  std::size_t peak = 0;
};

inline constexpr int kCourseSamples = 240;  ///< 12 an octave over a factor of 2^20

/// `sensitivity`: f in cycles/mrad (double) -> 1/CTF as S, >= 0, 0 from `limit_cy_mrad` on (UsageError if that is not
/// above 0 and finite). It should have one maximum in the band; maxima and gaps narrower than a twelfth of an octave
/// may be missed.
template <class Sensitivity>
SensitivityCourse sensitivity_course(const Sensitivity& sensitivity, double limit_cy_mrad) {
  if (!(limit_cy_mrad > 0.0 && limit_cy_mrad < mtf::kInfinity))
    throw mtf::UsageError("ttp: " + mtf::format_double(limit_cy_mrad) +
                          " cycles/mrad as the end of the sensitivity; it has to be above 0");
  const auto at = [&](double f) { return mtf::value_of(sensitivity(f)); };
  SensitivityCourse course;
  course.f_cy_mrad.push_back(0.0);
  for (int i = 0; i <= kCourseSamples; ++i)
    course.f_cy_mrad.push_back(limit_cy_mrad * std::exp2((i - kCourseSamples) / 12.0));
  for (const double f : course.f_cy_mrad) course.value.push_back(at(f));
  const auto most = std::max_element(course.value.begin(), course.value.end());
  const auto i = static_cast<std::size_t>(most - course.value.begin());
  course.peak = i;
  if (i == 0 || i + 1 == course.value.size()) return course;
  // The maximum itself, by golden sections: a contrast just above the least threshold has a band there.
  double lo = course.f_cy_mrad[i - 1], hi = course.f_cy_mrad[i + 1];
  constexpr double kGolden = 0.6180339887498949;
  double a = hi - kGolden * (hi - lo), b = lo + kGolden * (hi - lo), va = at(a), vb = at(b);
  for (int step = 0; step < 40; ++step) {
    if (va >= vb)
      hi = b, b = a, vb = va, a = hi - kGolden * (hi - lo), va = at(a);
    else
      lo = a, a = b, va = vb, b = lo + kGolden * (hi - lo), vb = at(b);
  }
  const double top = va >= vb ? a : b, value = std::max(va, vb);
  if (value > *most) {
    const std::size_t place = top > course.f_cy_mrad[i] ? i + 1 : i;
    course.f_cy_mrad.insert(course.f_cy_mrad.begin() + static_cast<std::ptrdiff_t>(place), top);
    course.value.insert(course.value.begin() + static_cast<std::ptrdiff_t>(place), value);
    course.peak = place;
  }
  return course;
}

/// TTP along one axis.
template <class S>
struct AxisTtp {
  S value{};                ///< cycles/mrad; 0 where the contrast is nowhere above the threshold
  double by_contrast = 0;   ///< its slope by C
  double lo = 0.0, hi = 0;  ///< the band, cycles/mrad
  double error = 0.0;       ///< of the integral, estimated
};

template <class S, class Sensitivity>
AxisTtp<S> axis_ttp(const SensitivityCourse& course, const Sensitivity& sensitivity, const S& contrast) {
  using std::sqrt;
  const double c = mtf::value_of(contrast);
  if (!(c >= 0.0 && c < mtf::kInfinity))
    throw mtf::UsageError("ttp: a contrast of " + mtf::format_double(c) + "; it has to be 0 or above, and finite");
  const std::vector<double>& f = course.f_cy_mrad;
  AxisTtp<S> ttp;
  if (std::isnan(course.value[course.peak])) throw mtf::UsageError("ttp: a sensitivity that is not a number");
  if (!(c * course.value[course.peak] > 1.0)) return ttp;
  const auto above = [&](double x) { return c * mtf::value_of(sensitivity(x)) - 1.0; };
  const auto g = [&](std::size_t i) { return c * course.value[i] - 1.0; };
  std::size_t last = course.peak, first = course.peak;
  while (first > 0 && g(first - 1) > 0.0) --first;
  while (last + 1 < f.size() && g(last + 1) > 0.0) ++last;
  ttp.lo = first == 0 ? 0.0 : find_root(above, f[first - 1], f[first], g(first - 1), g(first));
  ttp.hi = last + 1 == f.size() ? f[last] : find_root(above, f[last], f[last + 1], g(last), g(last + 1));

  const auto root = [&](double x) {
    const S ratio = contrast * sensitivity(x);
    return mtf::value_of(ratio) > 0.0 ? S(sqrt(ratio)) : S(0);
  };
  // In ln f, where a sensitivity that rises like f is smooth down to the lower end.
  const double low = std::max(ttp.lo, std::min(f[1], ttp.hi));
  const auto root_in_log = [&](double l) { return S(std::exp(l)) * root(std::exp(l)); };
  const Integral<S> band = integrate<S>(root_in_log, std::log(low), std::log(ttp.hi), 4);
  const Integral<S> start = integrate<S>(root, ttp.lo, low);
  ttp.value = band.value + start.value;
  ttp.error = band.error + start.error;
  ttp.by_contrast = 0.5 * mtf::value_of(ttp.value) / c;
  const auto end = [&](double x, double sign) {
    const double slope = slope_at(above, x, 1e-4 * x);
    if (!(std::abs(slope) > 0.0)) return;
    ttp.value += S(sign) * (implicit_root(x, S(contrast * sensitivity(x)), slope) - S(x));
    ttp.by_contrast -= sign / (c * slope);
  };
  if (first > 0) end(ttp.lo, -1.0);
  if (last + 1 < f.size()) end(ttp.hi, 1.0);
  return ttp;
}

/// sqrt(TTP_x TTP_y) in cycles/mrad; 0 if either is.
template <class S>
S ttp_of(const AxisTtp<S>& x, const AxisTtp<S>& y) {
  using std::sqrt;
  const S product = x.value * y.value;
  return mtf::value_of(product) > 0.0 ? S(sqrt(product)) : S(0);
}

/// V, cycles on a target of that size, the root of its area.
template <class S>
S cycles_on_target(const S& ttp_cy_mrad, const S& size_m, const S& range_m) {
  return S(1e3) * ttp_cy_mrad * size_m / range_m;
}

}  // namespace radiometry
