// SPDX-License-Identifier: Apache-2.0
#pragma once

// Kolmogorov turbulence of the path, seen in a long or a short exposure (image motion taken out).
//   long:   otf = exp(-c (lambda u / r0)^(5/3))
//   short:  otf = exp(-c (lambda u / r0)^(5/3) [1 - alpha (lambda u / D)^(1/3)])
// u = |f| x focal length in cycles/rad, lambda = wavelength, r0 = Fried parameter, D = aperture. c = (24/5
// Gamma(6/5))^(5/6) = 3.44193859..., or the usual 3.44 by name. alpha = 1: near field, 0.5: far field, 0: the long
// exposure. Real, positive, radial; multiplies `diffraction`. r0 is given, scaled as lambda^(6/5) from
// wavelength_reference where that is stated; or it follows from a path (`mtf/components/fried.h`): profile "constant"
// with cn2 and path_length, or "hufnagel_valley" with wind, ground_cn2, the altitudes of target and sensor, and
// path_length or zenith_angle (flat Earth: up to 80 degrees). A constant path without a length is as long as the
// line of [atmosphere]. Valid within the inertial range (outer scale far above D,
// inner scale far below r0). The short exposure is a formula for lambda u < D; beyond, where the aperture passes
// nothing, the bracket keeps its value 1 - alpha, so the otf never grows above 1. Conditioning: with E the exponent of
// the long exposure, the relative error is within (4 + 2 E) 2^-52, and what the rounding of lambda u / r0 adds; a path
// integral adds some 1e-14 E. (Fried, J. Opt. Soc. Am. 56, 1372 (1966).)

#include "mtf/components/field.h"
#include "mtf/components/fried.h"

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
inline constexpr std::array<std::string_view, 2> kProfileNames{"constant", "hufnagel_valley"};
inline constexpr std::array<std::string_view, 2> kWaveNames{"spherical", "plane"};

template <class S>
struct Turbulence {
  static constexpr std::string_view kind = "turbulence";
  static constexpr std::string_view doc = "atmospheric turbulence, long or short exposure";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::path;
  static constexpr double kExact = 3.441938591146905807646779;

  OptionalIn<S, millimetres> fried_parameter_mm{};
  OptionalIn<S, micrometres> wavelength_reference_um{};
  Choice exposure{0, kExposureNames};
  std::optional<S> alpha{};
  OptionalIn<S, millimetres> aperture_mm{};
  Choice constant{0, kKolmogorovNames};
  OptionalIn<S, micrometres> wavelength_um{};
  Choice profile{0, kProfileNames};
  Choice wave{0, kWaveNames};
  std::optional<S> cn2{};
  OptionalIn<S, metres> path_length_m{};
  std::optional<S> wind_m_s{};
  std::optional<S> ground_cn2{};
  OptionalIn<S, metres> target_altitude_m{};
  OptionalIn<S, metres> sensor_altitude_m{};
  OptionalIn<S, degrees> zenith_angle_deg{};

  static constexpr auto fields() {
    return std::tuple{
        optional(&Turbulence::fried_parameter_mm, "fried_parameter", "mm", 1e-3, 1e6, "\"50 mm\"",
                 "Fried parameter r0 of the path"),
        optional(&Turbulence::wavelength_reference_um, "wavelength_reference", "um", 0.01, 1e5, "\"0.55 um\"",
                 "wavelength at which fried_parameter is stated; r0 scales as wavelength^(6/5)"),
        optional(&Turbulence::exposure, "exposure", "\"short\"", "long, or short (image motion taken out)"),
        optional(&Turbulence::alpha, "alpha", 0.0, 1.0, "0.5",
                 "short exposure: 1 near field, 0.5 far field (the default), 0 as long exposure"),
        shared(&Turbulence::aperture_mm, "aperture", "mm", 1e-3, 1e6, "\"100 mm\"",
               "short exposure: entrance pupil diameter; otherwise focal length / f_number"),
        optional(&Turbulence::constant, "constant", "\"exact\"", "exact (3.44193859) or the usual rounded 3.44"),
        Field{&Turbulence::wavelength_um, kWavelengthInfo},
        optional(&Turbulence::profile, "profile", "\"hufnagel_valley\"",
                 "Cn2 along the path, instead of fried_parameter: constant or hufnagel_valley"),
        optional(&Turbulence::wave, "wave", "\"plane\"",
                 "path: spherical (a target at the end of the path) or plane (a star)"),
        optional(&Turbulence::cn2, "cn2", 1e-25, 1e-5, "1e-14", "constant profile: Cn2 in m^(-2/3), a plain number"),
        excluding("zenith_angle", optional(&Turbulence::path_length_m, "path_length", "m", 1e-3, 1e12, "\"4 km\"",
                                           "length of the path from target to sensor")),
        optional(&Turbulence::wind_m_s, "wind", 0.0, 1e3, "21.0",
                 "hufnagel_valley: wind of the upper atmosphere in m/s, a plain number; 21 when absent"),
        optional(&Turbulence::ground_cn2, "ground_cn2", 0.0, 1e-5, "1.7e-14",
                 "hufnagel_valley: its ground term A in m^(-2/3); 1.7e-14 when absent"),
        optional(&Turbulence::target_altitude_m, "target_altitude", "m", 0.0, 1e9, "\"2 km\"",
                 "hufnagel_valley: altitude of the target"),
        optional(&Turbulence::sensor_altitude_m, "sensor_altitude", "m", 0.0, 1e9, "\"20 m\"",
                 "hufnagel_valley: altitude of the sensor; 0 when absent"),
        excluding("path_length",
                  optional(&Turbulence::zenith_angle_deg, "zenith_angle", "deg", 0.0, 80.0, "\"60 deg\"",
                           "hufnagel_valley: angle of the path from the vertical, instead of path_length"))};
  }
  double c() const { return constant.index == 0 ? kExact : 3.44; }
  bool is_short() const { return exposure.index == 1; }
  Traits traits(const Context<S>&) const {
    return {.radial = true, .even_x = true, .even_y = true, .chromatic = !wavelength_um};
  }
  /// M of mtf/components/fried.h, in m^(1/3).
  S path(const Context<S>& ctx) const {
    const Wave kind_of_wave = wave.index == 0 ? Wave::spherical : Wave::plane;
    if (profile.index == 0) return cn2.value_or(S(0)) * length_m(ctx) * S(constant_path_weight(kind_of_wave));
    const S wind = wind_m_s.value_or(S(21)), ground = ground_cn2.value_or(S(1.7e-14));
    const S target = target_altitude_m.value_or(S(0)), sensor = sensor_altitude_m.value_or(S(0));
    const PathMean mean =
        path_mean({value_of(wind), value_of(ground)}, value_of(target), value_of(sensor), kind_of_wave);
    const S per_length = lift({mean.value, mean.by_wind}, wind) + lift({0.0, mean.by_ground}, ground) +
                         lift({0.0, mean.by_target}, target) + lift({0.0, mean.by_sensor}, sensor);
    return per_length * length_m(ctx);
  }
  S length_m(const Context<S>& ctx) const {
    if (path_length_m) return *path_length_m;
    if (profile.index == 0) return ctx.air.path_length_m.value_or(S(0));
    const S rise = sensor_altitude_m.value_or(S(0)) - target_altitude_m.value_or(S(0));
    return (value_of(rise) < 0.0 ? S(-rise) : rise) / unit_vector(zenith_angle_deg.value_or(S(0))).x;
  }
  S inverse_r0_1_mm(const S& wavelength, const Context<S>& ctx) const {
    if (!fried_parameter_mm) {
      const S m = path(ctx);
      const InverseFried r = inverse_fried(value_of(m), value_of(wavelength));
      return lift({r.value_1_mm, r.by_path}, m) + lift({0.0, r.by_wavelength}, wavelength);
    }
    if (!wavelength_reference_um) return S(1) / *fried_parameter_mm;
    const S ratio = *wavelength_reference_um / wavelength;
    const double root = std::pow(value_of(ratio), 0.2);
    return lift({root * value_of(ratio), 1.2 * root}, ratio) / *fried_parameter_mm;
  }
  /// What does not depend on the frequency is done once: for many frequencies at one context.
  auto evaluator(const Context<S>& ctx) const {
    const S wavelength = wavelength_um.value_or(ctx.wavelength_um);
    // cycles/mm x focal length = cycles/rad; x wavelength = a length in the aperture.
    return
        [scale_mm2 = S(ctx.frame.focal_length_mm * wavelength * S(1e-3)), inverse_r0 = inverse_r0_1_mm(wavelength, ctx),
         inverse_d = is_short() ? S(S(1) / aperture_of(aperture_mm, ctx)) : S(0),
         a = is_short() ? alpha.value_or(S(0.5)) : S(0), c = c()](const Freq<S>& f) {
          const S span_mm = radius(f.x, f.y) * scale_mm2;
          const S v = span_mm * inverse_r0, w = span_mm * inverse_d;
          const KolmogorovExponent e = kolmogorov_exponent(value_of(v), value_of(w), value_of(a));
          const double h = std::exp(-c * e.value), slope = -c * h;
          if (h == 0.0) return Complex<S>{S(0), S(0)};
          return Complex<S>{
              lift({h, slope * e.d_v}, v) + lift({0.0, slope * e.d_w}, w) + lift({0.0, slope * e.d_alpha}, a), S(0)};
        };
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return evaluator(ctx)(f); }
  /// Of the short exposure where the bracket begins to keep its value, lambda u = D.
  std::vector<double> kinks_cy_mm(const Context<S>& ctx) const {
    if (!is_short()) return {};
    const double scale = value_of(ctx.frame.focal_length_mm) * value_of(wavelength_um.value_or(ctx.wavelength_um));
    return {1e3 * value_of(aperture_of(aperture_mm, ctx)) / scale};
  }
  /// The short exposure is never below the long one, which falls monotonically.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const S wavelength = wavelength_um.value_or(ctx.wavelength_um);
    const double v = std::hypot(fx, fy) * value_of(ctx.frame.focal_length_mm) * value_of(wavelength) * 1e-3 *
                     value_of(inverse_r0_1_mm(wavelength, ctx));
    return -std::expm1(-c() * kolmogorov_exponent(v, 0.0, 0.0).value);
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (std::vector<Problem> path_problems = check_path(ctx); !path_problems.empty()) return path_problems;
    if (!is_short()) {
      if (!alpha) return {};
      return {{.error = false, .field = "alpha", .text = "has no effect on exposure = \"long\""}};
    }
    if (!(value_of(aperture_of(aperture_mm, ctx)) > 0.0))
      return {{.field = "aperture", .text = "missing; exposure = \"short\" needs it here or in [optics]"}};
    return {};
  }

 private:
  /// Exactly one way to r0, and nothing that belongs to another.
  std::vector<Problem> check_path(const Context<S>& ctx) const {
    const auto stray = [](bool given, const char* name, const char* owner) {
      return given ? std::vector<Problem>{{.field = name, .text = std::string("belongs to ") + owner}}
                   : std::vector<Problem>{};
    };
    const bool is_path = !fried_parameter_mm, layered = profile.index == 1;
    std::vector<Problem> problems;
    const auto add = [&](std::vector<Problem> more) { problems.insert(problems.end(), more.begin(), more.end()); };
    const char* const a_path = "a path, which fried_parameter replaces: give one of them";
    add(stray(!is_path && layered, "profile", a_path));
    add(stray(!is_path && wave.index != 0, "wave", a_path));
    add(stray(!is_path && path_length_m, "path_length", a_path));
    add(stray(is_path && wavelength_reference_um.has_value(), "wavelength_reference", "fried_parameter"));
    add(stray(cn2 && (!is_path || layered), "cn2", is_path ? "profile = \"constant\"" : a_path));
    for (const auto& [value, name] : {std::pair{&wind_m_s, "wind"},
                                      {&ground_cn2, "ground_cn2"},
                                      {&target_altitude_m, "target_altitude"},
                                      {&sensor_altitude_m, "sensor_altitude"},
                                      {&zenith_angle_deg, "zenith_angle"}})
      add(stray(value->has_value() && !(is_path && layered), name, "profile = \"hufnagel_valley\""));
    if (!problems.empty() || !is_path) return problems;
    if (!layered) {
      if (!cn2 && !path_length_m)
        return {{.field = "fried_parameter",
                 .text = "missing; give it, or cn2 and path_length, or profile = \"hufnagel_valley\""}};
      if (!cn2) return {{.field = "cn2", .text = "missing beside path_length"}};
      if (!path_length_m && !ctx.air.path_length_m)
        return {{.field = "path_length", .text = "missing beside cn2; give it, or [atmosphere] with a line of sight"}};
      return {};
    }
    if (!target_altitude_m) return {{.field = "target_altitude", .text = "missing for hufnagel_valley"}};
    if (path_length_m.has_value() == zenith_angle_deg.has_value())
      return {{.field = "path_length", .text = "hufnagel_valley needs either path_length or zenith_angle"}};
    const double rise = std::abs(value_of(sensor_altitude_m.value_or(S(0))) - value_of(*target_altitude_m));
    if (path_length_m && value_of(length_m(ctx)) < rise * (1.0 - 1e-6))
      return {{.field = "path_length",
               .text = format_double(value_of(length_m(ctx))) + " m is shorter than the difference of altitudes, " +
                       format_double(rise) + " m"}};
    if (zenith_angle_deg && rise == 0.0)
      return {{.field = "zenith_angle", .text = "target and sensor at one altitude: give path_length"}};
    return {};
  }
};

}  // namespace mtf
