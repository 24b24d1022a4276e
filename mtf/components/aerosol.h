// SPDX-License-Identifier: Apache-2.0
#pragma once

// Light scattered by aerosol over a path of length R.
//   contrast: otf = 1 at f = 0,  exp(-s R) everywhere else
//   blur:     otf = exp(-s R (u/uc)^2) for u < uc,  exp(-s R) beyond
// s = scattering coefficient, s R = optical depth of scattering, u = |f| x focal length in cycles/rad, uc = a/lambda
// for particles of radius a, or given. Contrast, the default, takes scattered light for a veil without detail, blur for
// a halo of finite width. Real, positive, radial. The mean of the image is kept (otf(0) = 1): what is lost to
// absorption, exp(-A R), belongs to the path transmission of the radiometry and never here. Count scattering once: with
// this component the path transmission holds absorption alone; with a transmission exp(-(A + s) R) and its path
// radiance in the radiometry, leave this component out. Without `scattering`, s R is that of the haze and the line of
// [atmosphere], whose transmission then holds absorption alone; without `path_length`, R is the length of that line.
// Monte-Carlo work finds a contrast loss nearly independent of frequency and hardly any blur, hence the default.
// (Kopeika, A System Engineering Approach to Imaging, with exp(-A R) taken out of its aerosol MTF.)

#include "mtf/components/field.h"

namespace mtf {

inline constexpr std::array<std::string_view, 2> kAerosolNames{"contrast", "blur"};

template <class S>
struct Aerosol {
  static constexpr std::string_view kind = "aerosol";
  static constexpr std::string_view doc = "aerosol scattering of the path: contrast loss, or blur";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::path;

  std::optional<S> scattering_1_km{};
  OptionalIn<S, kilometres> path_length_km{};
  Choice mode{0, kAerosolNames};
  SpatialFrequency<S> cutoff{};
  OptionalIn<S, micrometres> particle_radius_um{};
  OptionalIn<S, micrometres> wavelength_um{};

  static constexpr auto fields() {
    return std::tuple{optional(&Aerosol::scattering_1_km, "scattering", 0.0, 1e3, "0.1",
                               "scattering coefficient per km, a plain number; else that of [atmosphere]"),
                      optional(&Aerosol::path_length_km, "path_length", "km", 0.0, 1e6, "\"5 km\"",
                               "length of the path; else that of [atmosphere]"),
                      optional(&Aerosol::mode, "mode", "\"blur\"", "contrast (a veil) or blur (a halo)"),
                      excluding("particle_radius", optional(&Aerosol::cutoff, "cutoff", 1e-9, 1e9, "\"2 cy/mrad\"",
                                                            "blur: frequency uc from which the loss is constant")),
                      excluding("cutoff", optional(&Aerosol::particle_radius_um, "particle_radius", "um", 1e-3, 1e5,
                                                   "\"100 um\"", "blur: uc = radius / wavelength, instead of cutoff")),
                      Field{&Aerosol::wavelength_um, kWavelengthInfo}};
  }
  bool is_blur() const { return mode.index == 1; }
  /// s R.
  S optical_depth(const Context<S>& ctx) const {
    if (!scattering_1_km) return ctx.air.scattering.value_or(S(0));
    if (path_length_km) return *scattering_1_km * *path_length_km;
    return *scattering_1_km * ctx.air.path_length_m.value_or(S(0)) * S(1e-3);
  }
  Traits traits(const Context<S>&) const {
    // The step of the contrast at f = 0 keeps it out of tables over |f|, the pitch a cutoff in cy/px off the circle.
    const bool round = cutoff.unit == nullptr || cutoff.unit->name != "cy/px";
    return {.radial = is_blur() && round,
            .even_x = true,
            .even_y = true,
            .chromatic = is_blur() && particle_radius_um && !wavelength_um};
  }
  /// u/uc.
  S relative(const Freq<S>& f, const Context<S>& ctx) const {
    if (cutoff.unit != nullptr)
      return radius(S(f.x / cutoff.cy_mm(ctx.frame, Axis::x)), S(f.y / cutoff.cy_mm(ctx.frame, Axis::y)));
    const S wavelength = wavelength_um.value_or(ctx.wavelength_um);
    return radius(f.x, f.y) * (ctx.frame.focal_length_mm * wavelength) / particle_radius_um.value_or(S(1));
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S depth = optical_depth(ctx);
    const double most = std::exp(-value_of(depth));
    if (!is_blur()) {
      if (value_of(f.x) == 0.0 && value_of(f.y) == 0.0) return {S(1), S(0)};
      return {lift({most, -most}, depth), S(0)};
    }
    const S u = relative(f, ctx);
    const double r = value_of(u);
    if (!(r < 1.0)) return {lift({most, -most}, depth), S(0)};
    const double h = std::exp(-value_of(depth) * r * r);
    return {lift({h, -r * r * h}, depth) + lift({0.0, -2.0 * value_of(depth) * r * h}, u), S(0)};
  }
  /// Of a blur by the size of particles where its loss begins to be constant.
  std::vector<double> kinks_cy_mm(const Context<S>& ctx) const {
    if (!is_blur() || cutoff.unit != nullptr) return {};
    return {1.0 / value_of(relative({S(1), S(0)}, ctx))};
  }
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double depth = value_of(optical_depth(ctx));
    const double r = is_blur() ? std::min(1.0, value_of(relative({S(fx), S(fy)}, ctx))) : 1.0;
    return -std::expm1(-depth * r * r);
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    if (!scattering_1_km && path_length_km)
      return {{.field = "scattering", .text = "missing beside path_length; without both, those of [atmosphere] count"}};
    if (!scattering_1_km && !ctx.air.scattering)
      return {{.field = "scattering",
               .text = "missing; give it with path_length, or [atmosphere] with haze and a line of sight"}};
    if (scattering_1_km && !path_length_km && !ctx.air.path_length_m)
      return {{.field = "path_length", .text = "missing; give it, or [atmosphere] with a line of sight"}};
    const bool has_cutoff = cutoff.unit != nullptr;
    if (is_blur() && has_cutoff == particle_radius_um.has_value())
      return {{.field = "cutoff", .text = "mode = \"blur\" needs either cutoff or particle_radius"}};
    if (!is_blur() && (has_cutoff || particle_radius_um))
      return {{.field = has_cutoff ? "cutoff" : "particle_radius",
               .text = "belongs to mode = \"blur\"; the contrast loss has no frequency"}};
    return {};
  }
};

}  // namespace mtf
