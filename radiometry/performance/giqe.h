// SPDX-License-Identifier: Apache-2.0
#pragma once

// NIIRS, the National Imagery Interpretability Rating Scale (0 to 9), by the General Image Quality Equation. GSD in
// inches, L = log10:
//   GIQE 3  11.81 + 3.32 L(RER/GSD) - 1.48 H - G/SNR
//   GIQE 4  10.251 - a L(GSD) + b L(RER) - 0.656 H - 0.344 G/SNR;  a = 3.32, b = 1.559 for RER >= 0.9,
//           a = 3.16, b = 2.817 below: with rising RER it falls there by 0.16 L(GSD) - 0.0576
//   GIQE 5  9.57 - 3.32 L(GSD) + 3.32 (1 - exp(-1.9/SNR)) L(RER) - 2 L(RER)^4 - 1.8/SNR
// GSD: ground sample distance, the geometric mean of both directions. GIQE 3 takes it as it is given; GIQE 4 in the
// plane of the ground, where one direction is stretched: GSD/sqrt(sin elevation); GIQE 5 the geometric mean of image
// plane and ground: GSD/sin(elevation)^(1/4). elevation: of the sensor seen from the target, 90 degrees overhead.
// RER: relative edge response, the rise of a normalised edge between -0.5 and +0.5 pixels; GIQE 3 and 4 the geometric
// mean of both directions, GIQE 5 (RER_most RER_least^2)^(1/3), of the image before sharpening.
// H: overshoot of the edge, geometric mean; G: gain of the noise by sharpening, root sum of squares of its taps; SNR:
// of the difference of two surfaces, contrast over noise. GIQE 5 has no H and G.
// Validity: regressions on the ratings of analysts. GIQE 3 and 4 for visible imagery, standard error 0.3 NIIRS; GIQE 5
// replaces both. Nothing stops them outside of the data they were made from, so neither do these functions.
// (GIQE 3: Image Based Sensor Model, ERIM 253885-4-F vol. 4 (1996), eq. 3-56. GIQE 4: Leachtenauer et al., Appl. Opt.
// 36, 8322 (1997); pyBSM has 0.334 there for 0.344. GIQE 5: NGA, General Image Quality Equation 5.0 (2015).)

#include "radiometry/fields.h"
#include "radiometry/performance/implicit_root.h"

namespace radiometry {

inline constexpr double kInch_m = 0.0254;

/// log10 with its derivative.
template <class S>
S log10_of(const S& x) {
  const double v = mtf::value_of(x);
  return mtf::lift<S>({std::log10(v), 1.0 / (v * 2.302585092994045684)}, x);
}

/// (sin elevation)^power, elevation in degrees.
template <class S>
S sin_power(const S& elevation_deg, double power) {
  const double angle = mtf::value_of(elevation_deg) / 180.0, sine = mtf::sin_pi(angle);
  const double value = std::pow(sine, power);
  return mtf::lift<S>({value, power * value / sine * mtf::cos_pi(angle) * mtf::kPi / 180.0}, elevation_deg);
}

/// What GIQE 3 and 4 take.
template <class S>
struct Giqe4Input {
  S gsd_m{};            ///< at the target, in the plane of the image, geometric mean of both directions; to 1e6
  S rer{};              ///< geometric mean of both directions, above 0
  S overshoot{1};       ///< H, geometric mean of both directions; 0 to 10
  S noise_gain{1};      ///< G; 1 without sharpening
  S snr{};              ///< of the contrast, above 0, infinite allowed
  S elevation_deg{90};  ///< above 0 to 90; GIQE 4 only

  static constexpr auto fields() {
    return std::tuple{
        row_above_zero(&Giqe4Input::gsd_m, "gsd", "m", 1e6, "ground sample distance"),
        row_above_zero(&Giqe4Input::rer, "rer", "", 10.0, "relative edge response"),
        row_between(&Giqe4Input::overshoot, "overshoot", "", 0.0, 10.0, "height of the edge's overshoot"),
        row_between(&Giqe4Input::noise_gain, "noise_gain", "", 0.0, 1e6, "gain of the noise by sharpening"),
        row_above_zero(&Giqe4Input::snr, "snr", "", mtf::kInfinity, "contrast over noise"),
        row_above_zero(&Giqe4Input::elevation_deg, "elevation", "deg", 90.0, "of the sensor seen from the target")};
  }
};

/// What GIQE 5 takes.
template <class S>
struct Giqe5Input {
  S gsd_m{};            ///< as Giqe4Input::gsd_m; it is projected here
  S rer_x{}, rer_y{};   ///< along both directions, above 0
  S snr{};              ///< as Giqe4Input::snr
  S elevation_deg{90};  ///< above 0 to 90

  static constexpr auto fields() {
    return std::tuple{
        row_above_zero(&Giqe5Input::gsd_m, "gsd", "m", 1e6, "ground sample distance"),
        row_above_zero(&Giqe5Input::rer_x, "rer_x", "", 10.0, "relative edge response along x"),
        row_above_zero(&Giqe5Input::rer_y, "rer_y", "", 10.0, "relative edge response along y"),
        row_above_zero(&Giqe5Input::snr, "snr", "", mtf::kInfinity, "contrast over noise"),
        row_above_zero(&Giqe5Input::elevation_deg, "elevation", "deg", 90.0, "of the sensor seen from the target")};
  }
};

/// Throws UsageError for values out of range, as all of these.
template <class S>
S niirs_giqe3(const Giqe4Input<S>& in) {
  require_valid("giqe3", in);
  return S(11.81) + S(3.32) * log10_of(S(in.rer * S(kInch_m) / in.gsd_m)) - S(1.48) * in.overshoot -
         in.noise_gain / in.snr;
}

template <class S>
S niirs_giqe4(const Giqe4Input<S>& in) {
  require_valid("giqe4", in);
  const bool sharp = mtf::value_of(in.rer) >= 0.9;
  const S gsd_in = in.gsd_m / sin_power(in.elevation_deg, 0.5) / S(kInch_m);
  return S(10.251) - S(sharp ? 3.32 : 3.16) * log10_of(gsd_in) + S(sharp ? 1.559 : 2.817) * log10_of(in.rer) -
         S(0.656) * in.overshoot - S(0.344) * in.noise_gain / in.snr;
}

template <class S>
S niirs_giqe5(const Giqe5Input<S>& in) {
  require_valid("giqe5", in);
  const bool x_most = mtf::value_of(in.rer_x) > mtf::value_of(in.rer_y);
  const S& most = x_most ? in.rer_x : in.rer_y;
  const S& least = x_most ? in.rer_y : in.rer_x;
  const S log_rer = (log10_of(most) + S(2) * log10_of(least)) / S(3);
  const S gsd_in = in.gsd_m / sin_power(in.elevation_deg, 0.25) / S(kInch_m);
  const S exponent = S(-1.9) / in.snr;
  const double e = mtf::value_of(exponent);
  const S weight = mtf::lift<S>({-std::expm1(e), -std::exp(e)}, exponent);
  return S(9.57) - S(3.32) * log10_of(gsd_in) + S(3.32) * weight * log_rer -
         S(2) * log_rer * log_rer * log_rer * log_rer - S(1.8) / in.snr;
}

// What a camera resolves on the ground.
//   GSD  ground sample distance = range x pitch / focal length = range x ifov, in the plane of the image
//   GRD  ground resolved distance = range x max(1/u, 2 ifov), u the lowest frequency at which MTF(u) = 3/SNR: the
//        period of the finest bars that stand out of the noise by a factor of 3, never finer than two samples
// (Image Based Sensor Model, IBSM: ERIM 253885-4-F vol. 4 (1996), eq. 3-54, as pyBSM has it.)

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
