// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a camera resolves on the ground.
//   GSD  ground sample distance = range x pitch / focal length = range x ifov, in the plane of the image
//   GRD  ground resolved distance = range x max(1/u, 2 ifov), u the lowest frequency at which MTF(u) = 3/SNR: the
//        period of the finest bars that stand out of the noise by a factor of 3, never finer than two samples
// (Image Based Sensor Model, IBSM: ERIM 253885-4-F vol. 4 (1996), eq. 3-54, as pyBSM has it.)

#include "radiometry/fields.h"
#include "radiometry/performance/implicit_root.h"

namespace radiometry {

/// In m, for lengths in um, mm and m; small angles.
template <class S>
S ground_sample_distance_m(const S& pitch_um, const S& focal_length_mm, const S& range_m) {
  return range_m * pitch_um * S(1e-3) / focal_length_mm;
}

template <class S>
struct GrdInput {
  S snr{};        ///< contrast over noise at frequency 0, above 0, infinite allowed
  S ifov_mrad{};  ///< of a pixel, pitch / focal length, 1e-12 to 1e4
  S range_m{};    ///< along the line of sight, above 0

  static constexpr auto fields() {
    return std::tuple{row_above_zero(&GrdInput::snr, "snr", "", mtf::kInfinity, "contrast over noise"),
                      row_between(&GrdInput::ifov_mrad, "ifov", "mrad", 1e-12, 1e4, "instantaneous field of view"),
                      row_above_zero(&GrdInput::range_m, "range", "m", 1e12, "range along the line of sight")};
  }
};

template <class S>
struct GroundResolution {
  enum class Limit { sampling, contrast, none };
  Limit limit = Limit::none;  ///< by 2 GSD, by the MTF in its noise; none: SNR at most 3, no bars stand out
  S grd_m{};                  ///< infinite for none
};

/// `system_mtf`: f in cycles/mrad (double) -> S, 1 at f = 0. The lowest crossing is searched at 256 frequencies up to
/// Nyquist and then found to all digits. Throws UsageError for values out of range.
template <class S, class Mtf>
GroundResolution<S> ground_resolved_distance(const GrdInput<S>& in, const Mtf& system_mtf) {
  require_valid("grd", in);
  using Limit = typename GroundResolution<S>::Limit;
  const S threshold = S(3) / in.snr;
  if (mtf::value_of(threshold) >= 1.0) return {Limit::none, S(mtf::kInfinity)};
  const double nyquist = 0.5 / mtf::value_of(in.ifov_mrad);
  const auto above = [&](double f) { return mtf::value_of(system_mtf(f)) - mtf::value_of(threshold); };
  constexpr int kSamples = 256;
  double lo = 0.0, g_lo = 1.0 - mtf::value_of(threshold);
  for (int i = 1; i <= kSamples; ++i) {
    const double hi = nyquist * i / kSamples, g_hi = above(hi);
    if (g_hi < 0.0) {
      const double u = find_root(above, lo, hi, g_lo, g_hi);
      const double slope = slope_at(above, u, 1e-4 * u);
      return {Limit::contrast, in.range_m * S(1e-3) / implicit_root(u, S(system_mtf(u) - threshold), slope)};
    }
    lo = hi, g_lo = g_hi;
  }
  return {Limit::sampling, S(2e-3) * in.range_m * in.ifov_mrad};
}

}  // namespace radiometry
