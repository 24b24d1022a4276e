// SPDX-License-Identifier: Apache-2.0
#pragma once

// How likely an ensemble of observers succeeds at a task, by what is resolved on the target, and the range at which it
// still does.
//   P = x^E/(1 + x^E), x = V/V50 or N/N50: what is resolved over what half of the trials need
//   ttp_nvthermip  E = 1.51 + 0.24 x  (AMSEL-NV-TR-230, 2004)
//   ttp_nvipm      E = 1.5            (NV-IPM and after)
//   johnson        E = 2.7 + 0.7 x    (the target transfer probability function of Johnson's criteria; FLIR92, ACQUIRE)
// At x = 2 they give 0.80, 0.74 and 0.94, so that a result has to name its law.
// V50 for vehicles: detection 2.0, recognition 7.5, identification 13.0. N50, cycles over the least dimension: 1, 4, 8
// along one axis (Johnson 1958); 0.75, 3, 6 for a two-dimensional MRTD (Kennedy, Proc. SPIE 1488 (1991),
// doi 10.1117/12.45802). Range by TTP: V(R) = TTP(C exp(-beta R)) sqrt(A)/R = V50 x(P). V falls with R, so there is one
// root, below that without extinction.

#include <array>
#include <string_view>

#include "radiometry/performance/ttp.h"
#include "radiometry/rows.h"

namespace radiometry {

enum class Psychometric { ttp_nvthermip, ttp_nvipm, johnson };
inline constexpr std::array<std::string_view, 3> kPsychometricNames{"ttp_nvthermip", "ttp_nvipm", "johnson"};

namespace detail {
/// E = constant + slope x.
struct Steepness {
  double constant, slope;
};
inline constexpr std::array<Steepness, 3> kSteepness{{{1.51, 0.24}, {1.5, 0.0}, {2.7, 0.7}}};
/// ln(P/(1 - P)) = E ln x.
inline mtf::ValueSlope log_odds(Psychometric model, double x) {
  const Steepness e = kSteepness[static_cast<std::size_t>(model)];
  const double exponent = e.constant + e.slope * x, l = std::log(x);
  return {exponent * l, e.slope * l + exponent / x};
}
}  // namespace detail

/// P for x >= 0; 1 at infinity. Throws UsageError for x below 0 or NaN.
template <class S>
S task_probability(Psychometric model, const S& x) {
  const double v = mtf::value_of(x);
  if (!(v >= 0.0))
    throw mtf::UsageError("task probability: " + mtf::format_double(v) +
                          " cycles over those needed; it has to be 0 or above");
  if (v == 0.0 || v == mtf::kInfinity) return S(v == 0.0 ? 0.0 : 1.0);
  const mtf::ValueSlope y = detail::log_odds(model, v);
  const double decay = std::exp(-std::abs(y.value)), p = (y.value > 0.0 ? 1.0 : decay) / (1.0 + decay);
  return mtf::lift<S>({p, decay / ((1.0 + decay) * (1.0 + decay)) * y.slope}, x);
}

/// x of a probability: 0 for 0, infinite for 1. Throws UsageError for others than 0 to 1.
inline double ratio_for_probability(Psychometric model, double probability) {
  if (!(probability >= 0.0 && probability <= 1.0))
    throw mtf::UsageError("task probability of " + mtf::format_double(probability) + "; it goes from 0 to 1");
  if (probability == 0.0) return 0.0;
  if (probability == 1.0) return mtf::kInfinity;
  const double odds = std::log(probability) - std::log1p(-probability);
  // In ln x, between 0 and a little beyond ln(odds) over the constant part of E, which is the least that E can be.
  const double furthest = 1.001 * odds / detail::kSteepness[static_cast<std::size_t>(model)].constant;
  const auto g = [&](double l) { return detail::log_odds(model, std::exp(l)).value - odds; };
  const double lo = std::min(furthest, 0.0), hi = std::max(furthest, 0.0);
  return std::exp(find_root(g, lo, hi, g(lo), g(hi)));
}

enum class Reached {
  at_range,  ///< up to range_m
  at_limit,  ///< up to range_m, where the highest frequency that counts ends it
  never,     ///< at no range: the contrast is below every threshold, or P = 1
  always     ///< at any: P = 0
};

template <class S>
struct AcquisitionRange {
  Reached reached = Reached::never;
  S range_m{};  ///< 0 for never, infinite for always
};

/// A target and what is to be done with it.
template <class S>
struct TtpTask {
  S size_m{};             ///< square root of the target's area, above 0 to 1e6
  S contrast{};           ///< C at range 0, dT/(2 S_tmp), 0 to 1e6
  S extinction_per_km{};  ///< beta of Beer's law over the band, 0 to 1e6
  S v50{};                ///< above 0 to 1e6
  double probability = 0.5;
  Psychometric model = Psychometric::ttp_nvthermip;

  static constexpr auto fields() {
    return std::tuple{
        row_above_zero("size", "m", 1e6, "square root of the target's area", &TtpTask::size_m),
        row_between("contrast", "", 0.0, 1e6, "of the target at range 0", &TtpTask::contrast),
        row_between("extinction", "/km", 0.0, 1e6, "of the contrast with range", &TtpTask::extinction_per_km),
        row_above_zero("v50", "", 1e6, "cycles that half of the trials need", &TtpTask::v50),
        row_between("probability", "", 0.0, 1.0, "of the task", &TtpTask::probability)};
  }
};

/// The longest range at which the task succeeds with that probability, with its derivatives by everything. The courses
/// are those of the sensitivities (ttp.h). Throws UsageError for values out of range.
template <class S, class SensitivityX, class SensitivityY>
AcquisitionRange<S> ttp_range(const TtpTask<S>& task, const SensitivityCourse& course_x, const SensitivityX& x,
                              const SensitivityCourse& course_y, const SensitivityY& y) {
  using std::exp;
  require_valid("ttp", task);
  const double ratio = ratio_for_probability(task.model, task.probability);
  if (ratio == 0.0) return {Reached::always, S(mtf::kInfinity)};
  const double v = mtf::value_of(task.v50) * ratio, size = mtf::value_of(task.size_m);
  const double beta = 1e-3 * mtf::value_of(task.extinction_per_km);
  const auto contrast_at = [&](double range) { return task.contrast * exp(S(-1e-3 * range) * task.extinction_per_km); };
  const auto plain_ttp = [&](double range) {
    const double c = mtf::value_of(task.contrast) * std::exp(-beta * range);
    return ttp_of(axis_ttp(
                      course_x, [&](double f) { return mtf::value_of(x(f)); }, c),
                  axis_ttp(
                      course_y, [&](double f) { return mtf::value_of(y(f)); }, c));
  };
  const double at_zero = plain_ttp(0.0), far = 1e3 * size * at_zero / v;
  if (!(at_zero > 0.0) || !(far > 0.0)) return {};
  // V R - V50 x R: finite at range 0.
  const auto surplus = [&](double range) { return 1e3 * size * plain_ttp(range) - v * range; };
  const double range = beta > 0.0 ? find_root(surplus, 0.0, far, 1e3 * size * at_zero, surplus(far)) : far;
  if (!(range > 0.0)) return {};

  const S c = contrast_at(range);
  const AxisTtp<S> on_x = axis_ttp(course_x, x, c), on_y = axis_ttp(course_y, y, c);
  const S ttp = ttp_of(on_x, on_y);
  const double by_contrast =
      0.5 * mtf::value_of(ttp) *
      (on_x.by_contrast / mtf::value_of(on_x.value) + on_y.by_contrast / mtf::value_of(on_y.value));
  const double slope = -1e3 * size * by_contrast * beta * mtf::value_of(c) - v;
  const S g = S(1e3) * task.size_m * ttp - task.v50 * S(ratio * range);
  return {Reached::at_range, implicit_root(range, g, slope)};
}

}  // namespace radiometry
