// SPDX-License-Identifier: Apache-2.0
#pragma once

// How likely an ensemble of observers succeeds at a task, by what is resolved on the target, and the longest range at
// which it still does.
//   P = x^E/(1 + x^E), x = V/V50 or N/N50: what is resolved over what half of the trials need
//   ttp_nvthermip  E = 1.51 + 0.24 x  (AMSEL-NV-TR-230, 2004)
//   ttp_nvipm      E = 1.5            (NV-IPM and after)
//   johnson        E = 2.7 + 0.7 x    (the target transfer probability function of Johnson's criteria; FLIR92, ACQUIRE)
// At x = 2 they give 0.80, 0.74 and 0.94, so that a result has to name its law.
// V50 for vehicles: detection 2.0, recognition 7.5, identification 13.0. N50, cycles over the least dimension: 1, 4, 8
// along one axis (Johnson 1958); 0.75, 3, 6 for a two-dimensional MRTD (Kennedy, Proc. SPIE 1488 (1991),
// doi 10.1117/12.45802). What is resolved at a range: target_at_range.h.

#include <array>
#include <string>
#include <string_view>

#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/fields.h"
#include "radiometry/performance/implicit_root.h"

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

/// The ranges at which the air between target and sensor is known.
struct Reach {
  double least_m = 0.0, most_m = mtf::kInfinity;
  std::string end{};  ///< what ends it: "the table path.csv ends"
};

/// How far a task succeeds.
enum class Reached {
  at_range,  ///< up to range_m
  beyond,    ///< at the last of the ranges that were asked about, range_m, and nothing is known of those beyond
  never      ///< at none of them
};

struct AcquisitionRange {
  Reached reached = Reached::never;
  double range_m = 0.0;  ///< 0 for never
};

/// The longest range at which a task succeeds. `margin`: range in m -> ln(what the target offers there / what the task
/// needs), above 0 where it succeeds, -infinity where nothing is offered; it has to fall with range and is never NaN.
/// From `guess` on the root is enclosed by steps as long as the margin, the first of which brackets it where the margin
/// falls at least as fast as 1/range does, and then found to the digits of a double. 0 < least_m <= most_m.
template <class Margin>
AcquisitionRange longest_range(const Margin& margin, double least_m, double most_m, double guess_m) {
  const auto at = [&](double log_range) { return margin(std::exp(log_range)); };
  const double least = std::log(least_m), most = std::log(most_m);
  double lo = std::clamp(std::log(guess_m), least, most), hi = lo, g_lo = at(lo), g_hi = g_lo;
  const auto step = [](double g, double before) {
    return std::max(2.0 * before, std::isfinite(g) ? std::abs(g) * (1.0 + 1e-9) + 1e-15 : 0.7);
  };
  for (double by = 0.0; g_hi > 0.0;) {
    if (hi == most) return {Reached::beyond, most_m};
    lo = hi, g_lo = g_hi, by = step(g_hi, by);
    hi = std::min(hi + by, most), g_hi = at(hi);
  }
  for (double by = 0.0; g_lo <= 0.0;) {
    if (lo == least) return {};
    hi = lo, g_hi = g_lo, by = step(g_lo, by);
    lo = std::max(lo - by, least), g_lo = at(lo);
  }
  return {Reached::at_range, std::exp(find_root(at, lo, hi, g_lo, g_hi))};
}

/// A root of the margin with its derivatives: `margin` there with those by the parameters, `slope` its derivative by
/// ln(range). One step of Newton's, so that a margin beside 0 moves the range too.
template <class S>
S range_with_slopes(double range_m, const S& margin, double slope) {
  return S(range_m) * (S(1) - margin / S(slope));
}

}  // namespace radiometry
