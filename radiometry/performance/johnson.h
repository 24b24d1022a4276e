// SPDX-License-Identifier: Apache-2.0
#pragma once

// Range by Johnson's criteria: the target is replaced by bars of the same contrast, N of them over its least dimension;
// the task succeeds up to the range where their contrast at the aperture has fallen to the MRTD,
//   MRTD(N R/h) = dT exp(-beta R),  N = N50 x(P).
// P and N50: acquisition.h. MRTD rises with frequency, the contrast falls with range: one root. (Johnson, Image
// Intensifier Symposium, 249 (1958); Ratches, Opt. Eng. 15, 525 (1976); Kennedy, Proc. SPIE 1488 (1991),
// doi 10.1117/12.45802.)

#include "radiometry/performance/acquisition.h"

namespace radiometry {

template <class S>
struct JohnsonTask {
  S size_m{};             ///< h, least dimension (one axis) or square root of the area (2-D MRTD), above 0 to 1e6
  S contrast_k{};         ///< dT to the background at range 0, 0 to 1e6
  S extinction_per_km{};  ///< beta, 0 to 1e6
  S n50{};                ///< cycles that half of the trials need, above 0 to 1e6
  double probability = 0.5;
  Psychometric model = Psychometric::johnson;

  static constexpr auto fields() {
    return std::tuple{
        row_above_zero("size", "m", 1e6, "least dimension of the target", &JohnsonTask::size_m),
        row_between("contrast", "K", 0.0, 1e6, "to the background at range 0", &JohnsonTask::contrast_k),
        row_between("extinction", "/km", 0.0, 1e6, "of the contrast with range", &JohnsonTask::extinction_per_km),
        row_above_zero("n50", "", 1e6, "cycles that half of the trials need", &JohnsonTask::n50),
        row_between("probability", "", 0.0, 1.0, "of the task", &JohnsonTask::probability)};
  }
};

/// `mrtd`: f in cycles/mrad (double) -> S in K, rising, infinite where nothing is resolved. `limit_cy_mrad`: the
/// highest frequency that counts (Nyquist, or the cutoff); a target seen beyond gives Reached::at_limit. Throws
/// UsageError for values out of range.
template <class S, class Mrtd>
AcquisitionRange<S> johnson_range(const JohnsonTask<S>& task, const Mrtd& mrtd, const S& limit_cy_mrad) {
  using std::exp;
  require_valid("johnson", task);
  const double limit = mtf::value_of(limit_cy_mrad);
  if (!(limit > 0.0 && limit < mtf::kInfinity))
    throw mtf::UsageError("johnson: " + mtf::format_double(limit) +
                          " cycles/mrad as the highest frequency; it has to be above 0");
  const double ratio = ratio_for_probability(task.model, task.probability);
  if (ratio == 0.0) return {Reached::always, S(mtf::kInfinity)};
  if (ratio == mtf::kInfinity) return {};
  const S range_of_one = S(1e3 / ratio) * task.size_m / task.n50;  // m for one cycle/mrad
  const double scale = mtf::value_of(range_of_one);
  const double beta = 1e-3 * mtf::value_of(task.extinction_per_km), contrast = mtf::value_of(task.contrast_k);
  const auto surplus = [&](double f) { return contrast * std::exp(-beta * scale * f) - mtf::value_of(mrtd(f)); };
  const double lowest = 1e-9 * limit, g_lo = surplus(lowest), g_hi = surplus(limit);
  if (!(g_lo > 0.0)) return {};
  if (g_hi >= 0.0) return {Reached::at_limit, range_of_one * limit_cy_mrad};
  const double f = find_root(surplus, lowest, limit, g_lo, g_hi);
  // f depends on the parameters by both sides of the equation, the range also by its scale.
  const S g = task.contrast_k * exp(S(-1e-3 * f) * task.extinction_per_km * range_of_one) - mrtd(f);
  return {Reached::at_range, range_of_one * implicit_root(f, g, slope_at(surplus, f, 1e-4 * f))};
}

}  // namespace radiometry
