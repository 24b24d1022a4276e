// SPDX-License-Identifier: Apache-2.0
#pragma once

// MRTD, the temperature difference at which the four bars of a standard target are just resolved, as FLIR92 models it:
//   MRTD_x(f) = (pi^2/8) SNR_th sqrt(N_x(f)) / H(f)
//   N_x = tvh^2 E_t E_x E_y + vh^2 E_x E_y + th^2 E_t E_x + h^2 E_x      for bars that alternate along x
//   N_y = tvh^2 E_t E_x E_y + vh^2 E_x E_y + tv^2 E_t E_y + v^2 E_y      along y
// The components of 3-D noise are in K (noise_3d.h; h: columns, v: rows): noise that is the same along a bar is not
// averaged along it, and noise of rows does not resemble bars along x. That is the usual
// tvh k sqrt(E_t E_x E_y), k^2 = 1 + vh^2/(tvh^2 E_t) + th^2/(tvh^2 E_y) + h^2/(tvh^2 E_t E_y), without its divisions.
//   E_t = min(1, 1/(frame rate x t_eye))
//   E   = s x integral of sinc^2(w f') H_noise(f')^2 df' over |f'| <= the noise's band: what the eye leaves of the
//         variance of samples s apart when it averages over w mrad: w = 1/(2 f) across a bar, 7 times that along it
// H: system MTF, eye excluded; H_noise: MTF of the filters after the detector, which act on the noise. (pi^2/8 = the
// bars' fundamental, 4/pi, and the average over half a period of it, 2/pi.) 2-D: f = sqrt(f_x f_y) where MRTD_x(f_x) =
// MRTD_y(f_y); that value is MRTD_2D(f). (Scott and D'Agostino, Proc. SPIE 1689, 55 (1992); Driggers, Cox and Edwards,
// Introduction to Infrared and Electro-Optical Systems, ch. 11. SNR_th 2.5 to 3, t_eye 0.1 to 0.2 s.) Sampling, and so
// frequencies beyond the detector's Nyquist, is not in it. An H that rises again beyond a zero shows bars of the wrong
// contrast: let it end at the zero.

#include <complex>

#include "mtf/frame.h"
#include "radiometry/fields.h"
#include "radiometry/light/adaptive_integral.h"
#include "radiometry/performance/implicit_root.h"

namespace radiometry {

template <class S>
struct MrtdInput {
  S tvh_k{}, vh_k{}, th_k{}, tv_k{}, h_k{}, v_k{};   ///< 3-D noise, K rms, 0 to 1e6; NETD is close to tvh
  S spacing_x_mrad{}, spacing_y_mrad{};              ///< of samples, pitch / focal length, 1e-12 to 1e4
  S noise_band_x_cy_mrad{}, noise_band_y_cy_mrad{};  ///< highest frequency of the noise; 0: Nyquist, 1/(2 spacing)
  S snr_threshold{2.5};                              ///< SNR_th, above 0 to 1e3
  S eye_time_s{0.1};                                 ///< t_eye, above 0 to 1e3
  S frame_rate_hz{};                                 ///< above 0 to 1e9
  double bar_aspect = 7.0;                           ///< length of a bar over its width, 0.1 to 1e3

  static constexpr auto fields() {
    using T = MrtdInput;
    return std::tuple{
        row_between(&T::tvh_k, "tvh", "K", 0.0, 1e6, "temporal noise of pixels"),
        row_between(&T::vh_k, "vh", "K", 0.0, 1e6, "fixed noise of pixels"),
        row_between(&T::th_k, "th", "K", 0.0, 1e6, "temporal noise of columns"),
        row_between(&T::tv_k, "tv", "K", 0.0, 1e6, "temporal noise of rows"),
        row_between(&T::h_k, "h", "K", 0.0, 1e6, "fixed noise of columns"),
        row_between(&T::v_k, "v", "K", 0.0, 1e6, "fixed noise of rows"),
        row_between(&T::spacing_x_mrad, "spacing_x", "mrad", 1e-12, 1e4, "of samples along x"),
        row_between(&T::spacing_y_mrad, "spacing_y", "mrad", 1e-12, 1e4, "of samples along y"),
        row_between(&T::noise_band_x_cy_mrad, "noise_band_x", "cy/mrad", 0.0, 1e9, "highest frequency of the noise"),
        row_between(&T::noise_band_y_cy_mrad, "noise_band_y", "cy/mrad", 0.0, 1e9, "highest frequency of the noise"),
        row_above_zero(&T::snr_threshold, "snr_threshold", "", 1e3, "that the observer needs"),
        row_above_zero(&T::eye_time_s, "eye_time", "s", 1e3, "integration of the eye"),
        row_above_zero(&T::frame_rate_hz, "frame_rate", "Hz", 1e9, "of the sensor"),
        row_between(&T::bar_aspect, "bar_aspect", "", 0.1, 1e3, "length of a bar over its width")};
  }
};

/// Integral of sinc^2(w f) P(f) df over |f| <= band, cycles/mrad; `spectrum`: P, double -> S. w in mrad, above 0.
/// The lobes of sinc^2 are integrated one by one; of more than 64 those beyond the 32nd are taken by their mean and the
/// terms of their ends, so that the cost has a bound. The relative error is below 1e-9 where P changes little over a
/// 32nd of the band.
template <class S, class Spectrum>
S averaged_over(double w_mrad, const S& band_cy_mrad, const Spectrum& spectrum) {
  const double band = mtf::value_of(band_cy_mrad), end = w_mrad * band;  // in lobes
  const auto power = [&](double lobes) { return S(spectrum(lobes / w_mrad)); };
  const auto window = [](double x) {
    const double sinc = mtf::sinc_value(x);
    return sinc * sinc;
  };
  const double direct = end > 64.0 ? 32.0 : end;
  const auto windowed = [&](double x) { return S(S(window(x)) * power(x)); };
  S sum = integrate<S>(windowed, 0.0, direct, std::max(1, static_cast<int>(std::ceil(direct)))).value;
  if (end > direct) {
    // sinc^2 = (1 - cos 2 pi x)/(2 pi^2 x^2): the first part is smooth, the second goes by parts.
    constexpr double kPi = mtf::kPi;
    const auto smooth = [&](double l) { return power(std::exp(l)) * S(std::exp(-l) / (2.0 * kPi * kPi)); };
    sum += integrate<S>(smooth, std::log(direct), std::log(end), 2).value;
    const auto at_end = [&](double x) {
      const double step = 1e-3 * x;
      const S g = power(x) / S(2.0 * kPi * kPi * x * x);
      const S slope = (power(x + step) - power(x - step)) / S(4.0 * kPi * kPi * step * x * x) - S(2.0 / x) * g;
      return S(mtf::sin_pi(2.0 * x) / (2.0 * kPi)) * g + S(mtf::cos_pi(2.0 * x) / (4.0 * kPi * kPi)) * slope;
    };
    sum -= at_end(end) - at_end(direct);
  }
  // The derivative by the band is the integrand at its end.
  return S(2.0 / w_mrad) * (sum + S(window(end)) * power(end) * S(w_mrad) * (band_cy_mrad - S(band)));
}

/// Integral of sinc^2 from 0 to x >= 0: Si(2 pi x)/pi - sin^2(pi x)/(pi^2 x), Si(z) by its series, beyond z = 4 as
/// pi/2 + Im E1(i z) with the continued fraction of E1 (Abramowitz and Stegun, 5.1.22, by Lentz's method).
inline double sinc_square_integral(double x) {
  if (x == 0.0) return 0.0;
  const double z = 2.0 * mtf::kPi * x, sine = mtf::sin_pi(x);
  double si = 0.0;
  if (z <= 4.0) {
    double term = z;
    for (int k = 1; std::abs(term) > 1e-18 * z; k += 2) {
      si += term / k;
      term *= -z * z / ((k + 1.0) * (k + 2.0));
    }
  } else {
    std::complex<double> b(1.0, z), c(1e300, 0.0), d = 1.0 / b, h = d;
    for (int i = 1; i < 200; ++i) {
      const double a = -static_cast<double>(i) * i;
      b += 2.0;
      d = 1.0 / (a * d + b);
      c = b + a / c;
      const std::complex<double> step = c * d;
      h *= step;
      if (std::abs(step.real() - 1.0) + std::abs(step.imag()) < 1e-16) break;
    }
    si = 0.5 * mtf::kPi + (h * std::complex<double>(mtf::cos_pi(2.0 * x), -mtf::sin_pi(2.0 * x))).imag();
  }
  return si / mtf::kPi - sine * sine / (mtf::kPi * mtf::kPi * x);
}

/// Where nothing filters the noise.
struct Unfiltered {
  double operator()(double) const { return 1.0; }
};

/// What the eye leaves of the variance of white noise after filters of that MTF, as a bandwidth: averaged_over() of its
/// square.
template <class S, class Mtf>
S averaged_bandwidth(double w_mrad, const S& band_cy_mrad, const Mtf& noise_mtf) {
  if constexpr (std::is_same_v<Mtf, Unfiltered>) {
    const S lobes = S(w_mrad) * band_cy_mrad;
    const double x = mtf::value_of(lobes), sinc = mtf::sinc_value(x);
    return S(2.0 / w_mrad) * mtf::lift<S>({sinc_square_integral(x), sinc * sinc}, lobes);
  } else
    return averaged_over(w_mrad, band_cy_mrad, [&](double f) {
      const S h = noise_mtf(f);
      return S(h * h);
    });
}

/// E_t: the part of the variance of temporal noise that the integration time of the eye leaves.
template <class S>
S kept_by_eye(const MrtdInput<S>& in) {
  const S frames = in.frame_rate_hz * in.eye_time_s;
  return mtf::value_of(frames) > 1.0 ? S(S(1) / frames) : S(1);
}

/// MRTD in K along an axis at f >= 0 cycles/mrad; the MTFs are callables double -> S. 0 at f = 0 and without noise,
/// infinite where the system's MTF is not above 0. Throws UsageError for values out of range.
template <class S, class SystemMtf, class NoiseMtfX, class NoiseMtfY>
S mrtd_k(const MrtdInput<S>& in, mtf::Axis axis, double f_cy_mrad, const SystemMtf& system_mtf,
         const NoiseMtfX& noise_x, const NoiseMtfY& noise_y) {
  using std::sqrt;
  require_valid("mrtd", in);
  if (!(f_cy_mrad >= 0.0 && f_cy_mrad < mtf::kInfinity))
    throw mtf::UsageError("mrtd: a frequency of " + mtf::format_double(f_cy_mrad) +
                          " cycles/mrad; it has to be 0 or above, and finite");
  if (f_cy_mrad == 0.0) return S(0);
  const S h = system_mtf(f_cy_mrad);
  if (!(mtf::value_of(h) > 0.0)) return S(mtf::kInfinity);
  const bool along_x = axis == mtf::Axis::x;
  const double across = 0.5 / f_cy_mrad, along = in.bar_aspect * across;
  const auto band = [](const S& given, const S& spacing) {
    return mtf::value_of(given) > 0.0 ? given : S(S(0.5) / spacing);
  };
  const S e_x = in.spacing_x_mrad *
                averaged_bandwidth(along_x ? across : along, band(in.noise_band_x_cy_mrad, in.spacing_x_mrad), noise_x);
  const S e_y = in.spacing_y_mrad *
                averaged_bandwidth(along_x ? along : across, band(in.noise_band_y_cy_mrad, in.spacing_y_mrad), noise_y);
  const S e_t = kept_by_eye(in);
  const S both = (in.tvh_k * in.tvh_k * e_t + in.vh_k * in.vh_k) * e_x * e_y;
  const S one = along_x ? S((in.th_k * in.th_k * e_t + in.h_k * in.h_k) * e_x)
                        : S((in.tv_k * in.tv_k * e_t + in.v_k * in.v_k) * e_y);
  const S variance = both + one;
  if (!(mtf::value_of(variance) > 0.0)) return S(0);
  return S(mtf::kPi * mtf::kPi / 8.0) * in.snr_threshold * sqrt(variance) / h;
}

/// MRTD_2D in K at f > 0 from those along the axes, callables double -> S that rise and may be infinite; infinite where
/// both never meet below infinity. f is to be above 0 (UsageError).
template <class S, class MrtdX, class MrtdY>
S mrtd_2d_k(double f_cy_mrad, const MrtdX& mrtd_x, const MrtdY& mrtd_y) {
  if (!(f_cy_mrad > 0.0 && f_cy_mrad < mtf::kInfinity))
    throw mtf::UsageError("mrtd: a frequency of " + mtf::format_double(f_cy_mrad) +
                          " cycles/mrad; it has to be above 0, and finite");
  // f_x = f t, f_y = f/t: ln of the ratio rises with ln t. Where one is infinite, its sign is all that counts.
  const auto difference = [&](double log_t) {
    const double x = mtf::value_of(mrtd_x(f_cy_mrad * std::exp(log_t)));
    const double y = mtf::value_of(mrtd_y(f_cy_mrad * std::exp(-log_t)));
    if (x == y) return 0.0;  // also 0 and 0, infinite and infinite
    return std::log(x / y);
  };
  const double here = difference(0.0);
  double lo = 0.0, hi = 0.0, g_lo = here, g_hi = here;
  constexpr double kStep = 0.25, kFurthest = 14.0;  // a factor of 1e6 up and down
  while (g_lo > 0.0 && lo > -kFurthest) hi = lo, g_hi = g_lo, lo -= kStep, g_lo = difference(lo);
  while (g_hi < 0.0 && hi < kFurthest) lo = hi, g_lo = g_hi, hi += kStep, g_hi = difference(hi);
  if (g_lo > 0.0 || g_hi < 0.0) return S(mtf::kInfinity);
  const double t = std::exp(find_root(difference, lo, hi, g_lo, g_hi));
  const S x = mrtd_x(f_cy_mrad * t), y = mrtd_y(f_cy_mrad / t);
  if (!(mtf::value_of(x) < mtf::kInfinity) || !(mtf::value_of(y) < mtf::kInfinity)) return S(mtf::kInfinity);
  if constexpr (requires { x.a; }) {  // the root's derivative: the one weighs with the slope of the other
    const double by_x = std::abs(slope_at([&](double l) { return mrtd_x(f_cy_mrad * t * std::exp(l)); }, 0.0, 1e-4));
    const double by_y = std::abs(slope_at([&](double l) { return mrtd_y(f_cy_mrad / t * std::exp(l)); }, 0.0, 1e-4));
    if (!(by_x + by_y > 0.0) || !std::isfinite(by_x + by_y)) return x;
    return (S(by_y) * x + S(by_x) * y) / S(by_x + by_y);
  } else {
    return x;
  }
}

}  // namespace radiometry
