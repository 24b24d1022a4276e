// SPDX-License-Identifier: Apache-2.0
#pragma once

// The least contrast of a grating that an observer sees: CTF, by the eye alone and through a sensor with its display.
//   eye     CTF(u) = sqrt(2/eyes) / S(u), S the contrast sensitivity of mtf/components/eye_fits.h, u in cycles/degree
//           at the eye; the fits are for both eyes. Contrast is modulation, (bright - dark)/(bright + dark).
//   system  CTF_sys(f) = CTF(f/M)/(M_disp H(f)) sqrt(1 + alpha^2 Gamma^2 Q_along(f) Q_across / S_tmp^2)
//           Q_along = integral of |B(f'/f) H_post(f')|^2 df', B = exp(-2.2 ln^2(f'/f)); Q_across of the other axis,
//           without B; both over all f', negative ones too
//   MRT(f) = 2 S_tmp CTF_sys(f), of bars seen so
// f: cycles/mrad in object space; M: magnification, angle at the eye over angle in object space; M_disp: contrast that
// the display leaves; H: MTF of everything before the eye; H_post: what filters the noise, display and eye's MTF;
// Gamma: density of the noise, K mrad s^(1/2) (two-sided: variance = Gamma^2 x bandwidths); S_tmp: the temperature
// difference shown from dark to mean luminance, K; alpha: the observer, Hz^(1/2).
// Computed as 1/CTF, sensitivity, which is 0 where nothing is seen and finite everywhere.
// Codes differ in that, some take one side of the frequencies only, which halves Q_along Q_across twice; alpha goes
// with the convention. B has the natural logarithm: a channel of 1.6 octaves between its halves. log10, found in print
// and code, makes it 3.7. (Vollmerhausen and Jacobs, AMSEL-NV-TR-230 (2004): the NVThermIP family; alpha 862 there.
// observer_alpha: its successor, as in mitre/whale-ir-model. Barten: mtf/components/eye_fits.h. Variants have to be
// named with results.)

#include "mtf/components/eye_fits.h"
#include "radiometry/fields.h"
#include "radiometry/light/adaptive_integral.h"

namespace radiometry {

using mtf::ContrastModel;

inline constexpr double kDegreesPerMrad = 1e-3 * 180.0 / mtf::kPi;
inline constexpr double kAlphaNvThermIp = 862.0;  ///< Hz^(1/2)

/// The observer and the display.
template <class S>
struct Observer {
  ContrastModel model = ContrastModel::barten_short_squared;
  S luminance_cd_m2{34.26};  ///< mean of the display, 3.4e-4 to 3.5e3
  S field_deg{10};           ///< angular size of the picture at the eye, 0.1 to 180
  S magnification{1};        ///< angle at the eye / angle in object space, 1e-3 to 1e6
  S display_contrast{1};     ///< M_disp, contrast shown / contrast of the signal, above 0 to 1
  int eyes = 2;              ///< 1 or 2

  static constexpr auto fields() {
    using T = Observer;
    return std::tuple{
        row_between(&T::luminance_cd_m2, "luminance", "cd/m^2", mtf::kLuminanceLo, mtf::kLuminanceHi, "of the display"),
        row_between(&T::field_deg, "field", "deg", 0.1, 180.0, "size of the picture"),
        row_between(&T::magnification, "magnification", "", 1e-3, 1e6, "angle at the eye / angle in object space"),
        row_between(&T::display_contrast, "display_contrast", "", 1e-6, 1.0, "contrast that the display leaves"),
        row_between(&T::eyes, "eyes", "", 1.0, 2.0, "number of eyes")};
  }
};

/// Contrast sensitivity with all derivatives, u >= 0 in cycles/degree at the eye.
template <class S>
S eye_sensitivity(const Observer<S>& o, const S& u_cy_deg) {
  const mtf::ContrastSensitivity s = mtf::contrast_sensitivity(
      o.model, mtf::value_of(u_cy_deg), mtf::value_of(o.luminance_cd_m2), mtf::value_of(o.field_deg));
  const double eyes = std::sqrt(0.5 * o.eyes);
  return mtf::lift(eyes * s.value, eyes * s.by_frequency, u_cy_deg, eyes * s.by_luminance, o.luminance_cd_m2) +
         mtf::lift<S>({0.0, eyes * s.by_field}, o.field_deg);
}

/// CTF of the eye; infinite at u = 0 and where the sensitivity underflows. Throws UsageError for values out of range.
template <class S>
S eye_contrast_threshold(const Observer<S>& o, const S& u_cy_deg) {
  require_valid("observer", o);
  if (!(mtf::value_of(u_cy_deg) >= 0.0))
    throw mtf::UsageError("contrast threshold: a frequency of " + mtf::format_double(mtf::value_of(u_cy_deg)) +
                          " cycles/degree; it has to be 0 or above");
  const S s = eye_sensitivity(o, u_cy_deg);
  return mtf::value_of(s) > 0.0 ? S(1) / s : S(mtf::kInfinity);
}

/// MTF of optics, retina and tremor at an object's frequency, with all derivatives (mtf/components/eye_fits.h).
template <class S>
S eye_mtf_at(const Observer<S>& o, const S& f_cy_mrad) {
  const S pupil = mtf::lift(mtf::pupil_diameter_mm(mtf::value_of(o.luminance_cd_m2), o.eyes), o.luminance_cd_m2);
  const S at_eye = f_cy_mrad / o.magnification;
  const mtf::EyeMtf h = mtf::eye_mtf(mtf::value_of(at_eye), mtf::value_of(pupil));
  return mtf::lift(h.value, h.by_frequency, at_eye, h.by_pupil, pupil);
}

/// B(f'/f), the channel of the eye about the frequency of the grating; ratio >= 0.
inline double eye_channel(double ratio) {
  const double l = std::log(ratio);
  return ratio > 0.0 ? std::exp(-2.2 * l * l) : 0.0;
}

namespace detail {
inline void require_frequency(const std::string& where, double f_cy_mrad) {
  if (!(f_cy_mrad >= 0.0 && f_cy_mrad <= 1e100))
    throw mtf::UsageError(where + ": a frequency of " + mtf::format_double(f_cy_mrad) +
                          " cycles/mrad; it has to be 0 to 1e100");
}
}  // namespace detail

/// Q_along in cycles/mrad at f >= 0; `post` is H_post(double) -> S. Relative error about 1e-9: over ln f' the integrand
/// is a bell, on which the trapezoidal rule converges exponentially; where halving its step shows otherwise, at a kink,
/// the adaptive one takes over. What lies beyond 3.2 in |ln(f'/f)| is below 1e-19 of 2 f and left out.
template <class S, class Post>
S channel_bandwidth(double f_cy_mrad, const Post& post) {
  detail::require_frequency("channel bandwidth", f_cy_mrad);
  const auto integrand = [&](double l) {
    const S h = post(f_cy_mrad * std::exp(l));
    return S(S(2.0 * f_cy_mrad * std::exp(l - 4.4 * l * l)) * h * h);
  };
  constexpr int kHalf = 32;
  constexpr double kStep = 0.1;
  S even(0), odd(0);
  for (int i = -kHalf; i <= kHalf; ++i) (i % 2 == 0 ? even : odd) += integrand(kStep * i);
  const S fine = S(kStep) * (even + odd);
  const double change = std::abs(mtf::value_of(fine) - 2.0 * kStep * mtf::value_of(even));
  if (!(change > 1e-9 * mtf::value_of(fine))) return fine;
  return integrate<S>(integrand, -3.2, 3.2, 8).value;
}

/// Q_across in cycles/mrad: up to `limit`, where H_post ends.
template <class S, class Post>
S bandwidth(double limit_cy_mrad, const Post& post) {
  detail::require_frequency("bandwidth", limit_cy_mrad);
  const auto integrand = [&](double f) {
    const S h = post(f);
    return S(2) * h * h;
  };
  return integrate<S>(integrand, 0.0, limit_cy_mrad, 8).value;
}

/// Gamma of white noise of one number a pixel and frame: rms x sqrt(pitch_x pitch_y / frame rate), K mrad s^(1/2) for
/// an rms in K, pitches in mrad (pitch / focal length), Hz.
template <class S>
S noise_density(const S& rms_k, const S& pitch_x_mrad, const S& pitch_y_mrad, const S& frame_rate_hz) {
  using std::sqrt;
  return rms_k * sqrt(pitch_x_mrad * pitch_y_mrad / frame_rate_hz);
}

/// alpha of the model after NVThermIP: sqrt(eyes 240^2 Q_t/(1 + 4.9^2 Q_e/E)), Q_t = 3.538 Hz, Q_e = 4.75 Hz, E the
/// retinal illuminance in trolands, cd/m^2 x mm^2 of pupil (the unit that the 4.9 is given in).
template <class S>
S observer_alpha(const Observer<S>& o) {
  using std::sqrt;
  const S pupil = mtf::lift(mtf::pupil_diameter_mm(mtf::value_of(o.luminance_cd_m2), o.eyes), o.luminance_cd_m2);
  const S trolands = o.luminance_cd_m2 * S(mtf::kPi / 4.0) * pupil * pupil;
  return S(240) * sqrt(S(o.eyes * 3.538) / (S(1) + S(4.9 * 4.9 * 4.75) / trolands));
}

/// sqrt(1 + alpha^2 Gamma^2 Q_along Q_across / S_tmp^2): by what noise raises the threshold.
template <class S>
S noise_factor(const S& alpha, const S& density, const S& q_along, const S& q_across, const S& scene_k) {
  using std::sqrt;
  const S ratio = alpha * density / scene_k;
  return sqrt(S(1) + ratio * ratio * q_along * q_across);
}

/// 1/CTF_sys at f for the system's MTF there; 0 where that is not above 0.
template <class S>
S system_sensitivity(const Observer<S>& o, double f_cy_mrad, const S& system_mtf, const S& noise_factor) {
  if (!(mtf::value_of(system_mtf) > 0.0)) return S(0);
  const S u = S(f_cy_mrad / kDegreesPerMrad) / o.magnification;
  return o.display_contrast * system_mtf * eye_sensitivity(o, u) / noise_factor;
}

/// MRT in K of the NVTherm family.
template <class S>
S minimum_resolvable_k(const S& scene_k, const S& sensitivity) {
  return mtf::value_of(sensitivity) > 0.0 ? S(2) * scene_k / sensitivity : S(mtf::kInfinity);
}

}  // namespace radiometry
