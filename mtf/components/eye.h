// SPDX-License-Identifier: Apache-2.0
#pragma once

// The observer's eye at the display, by its MTF or by one of three models of its contrast sensitivity.
//   mtf:         otf = exp(-(43.69 u/f0)^i0) exp(-0.375 u^1.21) exp(-0.4441 u^2),  u in cycles/mrad
//   the others:  otf = S(u)/max S,  u in cycles/degree
//   barten_2003           S = 5200 exp(-0.0016 u^2 (1 + 100/L)^0.08)
//                             / sqrt((1 + 144/X^2 + 0.64 u^2) (63/L^0.83 + 1/(1 - exp(-0.02 u^2))))
//   barten_short          S = 540 u exp(-b u) sqrt(1 + 0.06 exp(b u)) (1 + 0.7/L)^-0.2 / (1 + 12/(X (1 + u/3))),
//                         b = 0.3 (1 + 100/L)^0.15
//   barten_short_squared  the same with (1 + u/3)^2
// u = frequency at the eye = frequency in object space / magnification, which is angle at the eye / angle in object
// space. mtf is optics x retina x tremor; f0 and i0 follow from the pupil, the pupil from the luminance L in cd/m^2
// (`mtf/components/eye_fits.h`). The others are filters of visibility, not of luminance: 0 at f = 0 (the mean is no
// contrast), 1 at their peak; X = angular size of the picture in degrees. Both short forms are in use under one name.
// Real, not negative, radial. All have a tip at f = 0, where the derivatives are taken as 0; the slope on its sides is
// that of the models, unbounded for mtf (u^i0 with i0 < 1). Fits for 3.4e-4 to 3.5e3 cd/m^2 (mtf), about 0.1 to 1000
// cd/m^2 and 0.5 to 60 degrees (the others). (Overington, Vision and Acquisition; Barten, Proc. SPIE 5294, 231 (2003);
// Barten, J. Opt. Soc. Am. A 7, 2024 (1990).)

#include "mtf/components/eye_fits.h"
#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Eye {
  static constexpr std::string_view kind = "eye";
  static constexpr std::string_view doc = "the observer's eye at the display";
  static constexpr Stages stages{.postsample = true};
  static constexpr SensorPart part = SensorPart::display;
  static constexpr bool is_reconstruction = true;

  static constexpr std::array<std::string_view, 4> kModelNames{"mtf", kContrastModelNames[0], kContrastModelNames[1],
                                                               kContrastModelNames[2]};
  static constexpr std::array<std::string_view, 4> kModelDocs{
      "eye: MTF of optics, retina and tremor", "eye: contrast sensitivity of Barten 2003 over its peak",
      "eye: contrast sensitivity of Barten's short form over its peak, field term (1 + u/3)",
      "eye: contrast sensitivity of Barten's short form over its peak, field term (1 + u/3)^2"};

  Choice model{0, kModelNames};
  S magnification{1.0};
  NumberIn<S, candelas_per_m2> luminance_cd_m2{candelas_per_m2(100.0)};
  int eyes = 2;
  OptionalIn<S, degrees> field_deg{};

  static constexpr auto fields() {
    return std::tuple{
        required(&Eye::model, "model", "\"barten_2003\"",
                 "mtf, or contrast sensitivity barten_2003, barten_short, barten_short_squared"),
        required(&Eye::magnification, "magnification", 0.01, 1e4, "10.0", "angle at the eye / angle in object space"),
        required(&Eye::luminance_cd_m2, "luminance", "cd/m^2", kLuminanceLo, kLuminanceHi, "\"34 cd/m^2\"",
                 "mean luminance of the display"),
        optional(&Eye::eyes, "eyes", 1.0, 2.0, "2", "number of eyes, for the pupil of model = \"mtf\""),
        optional(&Eye::field_deg, "field", "deg", 0.1, 180.0, "\"10 deg\"",
                 "angular size of the picture at the eye, for the contrast sensitivities; 10 deg unless given")};
  }
  std::string_view variant_doc() const { return kModelDocs[static_cast<std::size_t>(model.index)]; }
  bool is_mtf() const { return model.index == 0; }
  ContrastModel contrast_model() const { return static_cast<ContrastModel>(model.index - 1); }
  Traits traits(const Context<S>&) const {
    return {.radial = true, .even_x = true, .even_y = true, .gain = !is_mtf(), .dc = is_mtf() ? 1.0 : 0.0};
  }

  /// The OTF for many frequencies, with what does not depend on them done once.
  auto evaluator(const Context<S>& ctx) const {
    const S pupil = lift(pupil_diameter_mm(value_of(luminance_cd_m2.value), eyes), luminance_cd_m2.value);
    const S field = field_deg.value_or(S(10.0));
    const double luminance = value_of(luminance_cd_m2.value);
    const double u_peak = is_mtf() ? 1.0 : peak_frequency_cy_deg(contrast_model(), luminance, value_of(field));
    // The derivative of a largest value by a parameter is that at its fixed place.
    const ContrastSensitivity peak =
        is_mtf() ? ContrastSensitivity{} : contrast_sensitivity(contrast_model(), u_peak, luminance, value_of(field));
    return [*this, &ctx, pupil, field, luminance, peak](const Freq<S>& f) -> Complex<S> {
      const S f_cy_mrad = ctx.frame.cy_per_mrad(radius(f.x, f.y)) / magnification;
      if (is_mtf()) {
        const EyeMtf h = eye_mtf(value_of(f_cy_mrad), value_of(pupil));
        return {lift(h.value, h.by_frequency, f_cy_mrad, h.by_pupil, pupil), S(0)};
      }
      const S u = f_cy_mrad * S(1e3 * kPi / 180.0);
      const ContrastSensitivity s = contrast_sensitivity(contrast_model(), value_of(u), luminance, value_of(field));
      const double h = s.value / peak.value;
      return {lift(h, s.by_frequency / peak.value, u, (s.by_luminance - h * peak.by_luminance) / peak.value,
                   luminance_cd_m2.value) +
                  lift({0.0, (s.by_field - h * peak.by_field) / peak.value}, field),
              S(0)};
    };
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return evaluator(ctx)(f); }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    if (!is_mtf()) return 1.0;
    return 1.0 - value_of(otf({S(fx), S(fy)}, ctx).re);
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (is_mtf() && field_deg)
      return {{.field = "field", .text = "belongs to the contrast sensitivities; model = \"mtf\" has no use for it"}};
    if (is_mtf()) return {};
    std::vector<Problem> problems;
    const auto outside = [&](const char* name, double value, const char* unit, double lo, double hi) {
      if (value >= lo && value <= hi) return;
      problems.push_back({.error = false,
                          .field = name,
                          .text = three_digits(value) + unit + " is beyond the data of the fit, " + three_digits(lo) +
                                  " to " + three_digits(hi) + unit});
    };
    outside("luminance", value_of(luminance_cd_m2.value), " cd/m^2", 0.1, 1000.0);
    outside("field", value_of(field_deg.value_or(S(10.0))), " deg", 0.5, 60.0);
    return problems;
  }
};

}  // namespace mtf
