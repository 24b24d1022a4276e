// SPDX-License-Identifier: Apache-2.0
#pragma once

// Diffraction and defocus of a circular or annular pupil in one, exact at any amount.
//   otf = 1/A integral over the pupil's overlap of cos(8 pi W020 nu x) dx dy,  nu = |f| lambda N
//   W020 = distance / (8 N^2 lambda)
// W020 = wavefront error at the edge of the pupil in waves, given, or from the distance between image plane and focus
// (paraxial; either sign, the OTF is the same); the rms wavefront error of a clear pupil is W020/sqrt(12). With
// `focus`, the range that is in focus, the distance is that of each sample of a scene (mtf/field/sample_ranges.h);
// anything but an image speaks of that range, where W020 = 0. The overlap is that of two pupils of radius 1 and area A
// with centres 2 nu apart along x, lambda = wavelength, N = f-number. Real (signed: contrast reverses), radial; a
// complete pupil OTF, zero from |f| = 1/(lambda N) on. Conditioning: nu and W020 carry 3 x 2^-53 each, times the slopes
// of the OTF. (Hopkins, Proc. R. Soc. A 231, 91 (1955); Goodman, Introduction to Fourier Optics, ch. 6.)

#include "mtf/components/field.h"
#include "mtf/components/pupil/defocus_pupil.h"
#include "mtf/components/pupil/pupil.h"

namespace mtf {

inline constexpr std::array<std::string_view, 1> kByRange{"range"};

template <class S>
struct Defocus {
  static constexpr std::string_view kind = "defocus";
  static constexpr std::string_view doc = "diffraction with defocus, exact at any amount";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;
  static constexpr bool is_pupil = true;

  std::optional<S> waves{};
  OptionalIn<S, micrometres> distance_um{};
  OptionalIn<S, metres> focus_m{};
  OptionalIn<S, micrometres> wavelength_reference_um{};
  std::optional<S> f_number{};
  std::optional<S> obscuration{};
  OptionalIn<S, micrometres> wavelength_um{};

  static constexpr auto fields() {
    constexpr auto distance = optional(&Defocus::distance_um, "distance", "um", -1e6, 1e6, "\"60 um\"",
                                       "image plane's distance from the focus, or \"range\" with focus; or give waves");
    return std::tuple{
        excluding("distance focus", optional(&Defocus::waves, "waves", -1e6, 1e6, "0.5",
                                             "wavefront error at the pupil's edge, W020; or give distance")),
        excluding("waves", with(distance, &FieldInfo::words, std::span<const std::string_view>(kByRange))),
        excluding("waves", optional(&Defocus::focus_m, "focus", "m", 1e-3, 1e12, "\"50 m\"",
                                    "range in focus: each sample of a scene is out of focus by its own "
                                    "range, channel Z")),
        Field{&Defocus::wavelength_reference_um, kWavelengthReferenceInfo},
        Field{&Defocus::f_number, kFNumberInfo},
        Field{&Defocus::obscuration, kQuadratureObscurationInfo},
        Field{&Defocus::wavelength_um, kWavelengthInfo}};
  }
  Traits traits(const Context<S>&) const {
    return {.radial = true, .even_x = true, .even_y = true, .chromatic = !wavelength_um};
  }
  S wavelength(const Context<S>& ctx) const { return wavelength_um.value_or(ctx.wavelength_um); }
  S nu(const S& f_cy_mm, const Context<S>& ctx) const {
    return relative_frequency(f_cy_mm, wavelength(ctx), f_number_of(f_number, ctx));
  }
  S w020(const Context<S>& ctx) const {
    if (waves) return waves_at(*waves, wavelength_reference_um, wavelength(ctx));
    const S n = f_number_of(f_number, ctx);
    return distance_um.value_or(S(0)) / (S(8) * n * n * wavelength(ctx));
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S v = nu(radius(f.x, f.y), ctx), e = obscuration_of(obscuration, ctx), w = w020(ctx);
    const DefocusOtf h = defocus_pupil_otf(value_of(v), value_of(e), value_of(w));
    return {lift(h.value, h.d_nu, v, h.d_obscuration, e) + lift({0.0, h.d_w020}, w), S(0)};
  }
  double cutoff_cy_mm(const Context<S>& ctx) const { return 1.0 / value_of(nu(S(1), ctx)); }
  std::vector<double> kinks_cy_mm(const Context<S>& ctx) const {
    return pupil_kinks(value_of(obscuration_of(obscuration, ctx)), cutoff_cy_mm(ctx));
  }
  /// 1 - otf = (1 - MTF in focus) + mean of 1 - cos(k x) over the overlap, |x| <= 1 - nu; k grows with f.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double v = value_of(nu(S(std::hypot(fx, fy)), ctx)), k = 8.0 * kPi * value_of(w020(ctx)) * v;
    const double in_focus = value_of(obscuration_of(obscuration, ctx)) > 0.0 ? 1.0 : 1.0 - circular_pupil_mtf(v).value;
    return std::min(2.0, in_focus + 0.5 * k * k);
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (waves.has_value() + distance_um.has_value() + focus_m.has_value() != 1)
      return {{.field = "waves", .text = "give exactly one of waves, distance, focus"}};
    if (!waves && wavelength_reference_um)
      return {{.field = "wavelength_reference", .text = "belongs to waves; a distance needs none"}};
    std::vector<Problem> problems = check_quadrature_obscuration(obscuration, ctx);
    constexpr double kSlowFrom = 20.0;
    if (const double w = std::abs(value_of(w020(ctx))); problems.empty() && w > kSlowFrom)
      problems.push_back({.error = false,
                          .text = format_double(w) +
                                  " waves of defocus are evaluated exactly, which can take minutes " +
                                  "for a large image, above all in a band"});
    return problems;
  }
};

}  // namespace mtf
