// SPDX-License-Identifier: Apache-2.0
#pragma once

// Kolmogorov turbulence of the path, Fried parameter r0, u = frequency in cycles/rad of object angle:
//   long exposure:  otf = exp(-c (lambda u / r0)^(5/3))
//   short exposure: otf = exp(-c (lambda u / r0)^(5/3) [1 - alpha (lambda u / D)^(1/3)])   (image motion taken out)
// c = (24/5 Gamma(6/5))^(5/6) = 3.44193859..., or the usual 3.44 by name. alpha = 1: near field, 0.5: far field, 0: the
// long exposure. D = aperture. Real, radial; multiplies `diffraction`. Short exposure is a formula for lambda u < D;
// beyond, where the aperture passes nothing, the bracket keeps its value 1 - alpha, so the otf never grows above 1.
// r0 is stated at wavelength_reference and scales as lambda^(6/5); without a reference it holds at every wavelength.
// Valid within the inertial range (outer scale far above D, inner scale far below r0). Conditioning: the exponent E
// makes a relative rounding of E x 2^-52. (Fried, J. Opt. Soc. Am. 56, 1372 (1966).)

#include "mtf/components/field.h"

namespace mtf {

/// Exponent (lambda u/r0)^(5/3) [1 - alpha min(lambda u/D, 1)^(1/3)] and its derivatives, v = lambda u/r0,
/// w = lambda u/D. Infinite v: an infinite value without derivatives.
struct KolmogorovExponent {
  double value = 0.0, d_v = 0.0, d_w = 0.0, d_alpha = 0.0;
};
inline KolmogorovExponent kolmogorov_exponent(double v, double w, double alpha) {
  if (v == 0.0) return {};
  constexpr double kLargest = 1e150;  // alpha = 1 beyond D: no exponent, but one derivative grows without limit
  const double power = std::pow(v, 5.0 / 3.0), root = w < 1.0 ? std::cbrt(w) : 1.0, bracket = 1.0 - alpha * root;
  if (bracket == 0.0) return {0.0, 0.0, w < 1.0 ? -power / 3.0 : 0.0, -std::min(power, kLargest)};
  if (!(power < kLargest)) return {kInfinity, 0.0, 0.0, 0.0};
  const bool falling = w > 0.0 && w < 1.0;
  return {power * bracket, 5.0 / 3.0 * (power / v) * bracket, falling ? -alpha / 3.0 * power * (root / w) : 0.0,
          -power * root};
}

inline constexpr std::array<std::string_view, 2> kExposureNames{"long", "short"};
inline constexpr std::array<std::string_view, 2> kKolmogorovNames{"exact", "3.44"};

template <class S>
struct Turbulence {
  static constexpr std::string_view kind = "turbulence";
  static constexpr std::string_view doc = "atmospheric turbulence, long or short exposure";
  static constexpr Stages stages{.presample = true};
  static constexpr double kExact = 3.441938591146905807646779;

  std::optional<S> fried_parameter_mm;
  std::optional<S> wavelength_reference_um;
  Choice exposure{0, kExposureNames};
  std::optional<S> alpha;
  std::optional<S> aperture_mm;
  Choice constant{0, kKolmogorovNames};
  std::optional<S> wavelength_um;

  static constexpr auto fields() {
    return std::tuple{
        Field{FieldInfo{.name = "fried_parameter",
                        .dimension = Dimension::length,
                        .unit = "mm",
                        .lo = 1e-3,
                        .hi = 1e6,
                        .example = "\"50 mm\"",
                        .doc = "Fried parameter r0 of the path"},
              &Turbulence::fried_parameter_mm},
        Field{FieldInfo{.name = "wavelength_reference",
                        .dimension = Dimension::length,
                        .unit = "um",
                        .lo = 0.01,
                        .hi = 1e5,
                        .presence = Presence::optional,
                        .example = "\"0.55 um\"",
                        .doc = "wavelength at which fried_parameter is stated; r0 scales as wavelength^(6/5)"},
              &Turbulence::wavelength_reference_um},
        Field{FieldInfo{.name = "exposure",
                        .presence = Presence::optional,
                        .example = "\"short\"",
                        .doc = "long, or short (image motion taken out)"},
              &Turbulence::exposure},
        Field{FieldInfo{.name = "alpha",
                        .lo = 0.0,
                        .hi = 1.0,
                        .presence = Presence::optional,
                        .example = "0.5",
                        .doc = "short exposure: 1 near field, 0.5 far field (the default), 0 as long exposure"},
              &Turbulence::alpha},
        Field{FieldInfo{.name = "aperture",
                        .dimension = Dimension::length,
                        .unit = "mm",
                        .lo = 1e-3,
                        .hi = 1e6,
                        .presence = Presence::shared,
                        .example = "\"100 mm\"",
                        .doc = "short exposure: entrance pupil diameter; otherwise focal length / f_number"},
              &Turbulence::aperture_mm},
        Field{FieldInfo{.name = "constant",
                        .presence = Presence::optional,
                        .example = "\"exact\"",
                        .doc = "exact (3.44193859) or the usual rounded 3.44"},
              &Turbulence::constant},
        Field{kWavelengthInfo, &Turbulence::wavelength_um}};
  }
  double c() const { return constant.index == 0 ? kExact : 3.44; }
  bool is_short() const { return exposure.index == 1; }
  Traits traits(const Context<S>&) const {
    return {.radial = true, .even_x = true, .even_y = true, .chromatic = !wavelength_um};
  }
  S aperture(const Context<S>& ctx) const {
    if (aperture_mm) return *aperture_mm;
    if (ctx.optics.aperture_mm) return *ctx.optics.aperture_mm;
    return ctx.optics.f_number ? S(ctx.frame.focal_length_mm / *ctx.optics.f_number) : S(0);
  }
  S r0_mm(const S& wavelength) const {
    const S r0 = fried_parameter_mm.value_or(S(1));
    if (!wavelength_reference_um) return r0;
    const S ratio = wavelength / *wavelength_reference_um;
    const double root = std::pow(value_of(ratio), 0.2);
    return r0 * lift({root * value_of(ratio), 1.2 * root}, ratio);
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S wavelength = wavelength_um.value_or(ctx.wavelength_um);
    // cycles/mm x focal length = cycles/rad; x wavelength = a length in the aperture.
    const S span_mm = radius(f.x, f.y) * (ctx.frame.focal_length_mm * wavelength * S(1e-3));
    const S v = span_mm / r0_mm(wavelength);
    const S w = is_short() ? S(span_mm / aperture(ctx)) : S(0);
    const S a = is_short() ? alpha.value_or(S(0.5)) : S(0);
    const KolmogorovExponent e = kolmogorov_exponent(value_of(v), value_of(w), value_of(a));
    const double h = std::exp(-c() * e.value), slope = -c() * h;
    if (h == 0.0) return {S(0), S(0)};
    return {lift({h, slope * e.d_v}, v) + lift({0.0, slope * e.d_w}, w) + lift({0.0, slope * e.d_alpha}, a), S(0)};
  }
  double cutoff_cy_mm(const Context<S>&) const { return kInfinity; }
  /// The short exposure is never below the long one, which falls monotonically.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const S wavelength = wavelength_um.value_or(ctx.wavelength_um);
    const double v = std::hypot(fx, fy) * value_of(ctx.frame.focal_length_mm) * value_of(wavelength) * 1e-3 /
                     value_of(r0_mm(wavelength));
    return -std::expm1(-c() * kolmogorov_exponent(v, 0.0, 0.0).value);
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (!is_short()) {
      if (!alpha) return {};
      return {{.error = false, .field = "alpha", .text = "has no effect on exposure = \"long\""}};
    }
    if (!aperture_mm && !ctx.optics.aperture_mm && !ctx.optics.f_number)
      return {{.field = "aperture", .text = "missing; exposure = \"short\" needs it here or in [optics]"}};
    return {};
  }
};

}  // namespace mtf
