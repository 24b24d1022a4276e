// SPDX-License-Identifier: Apache-2.0
#pragma once

// Diffraction of an aberrated circular or annular pupil, the wavefront given by coefficients in waves.
//   otf = 1/A integral over the pupil's overlap of exp(2 pi i [W(p + nu) - W(p - nu)]) dp,  nu = f lambda N as a vector
//   W = W020 rho^2 + W040 rho^4 + W131 rho^2 x + W222 x^2 + W311 x + sum of zernike[i] Z_(i+1)
// p = (x, y) in the pupil of area A, x right and y down as in the image, rho = 1 at the outer edge; lambda =
// wavelength, N = f-number. Zernike terms by `numbering`: fringe (37 terms, each of unit peak) or noll (91 terms, each
// of unit rms over the full disc); list element 0 is Z1, piston, without effect
// (`mtf/components/pupil/wavefront_pupil.h`). `orientation` turns the whole wavefront from +x to +y. Complex unless W
// is even; W311 > 0 moves the image by -2 lambda N W311 along x. The wavefront is one path difference: waves are at
// `wavelength_reference` and scale as 1/lambda; without it they hold at every wavelength. By exact-geometry quadrature:
// absolute error 1e-13, 1e-15 / (1 - e^2) for a narrow annulus of obscuration e. Rims of other lenses cut the pupil off
// the axis (cat's eye): what lies within a circle of radius vignetting_rim is left, in pupil radii, whose centre lies
// at vignetting_shift along x of the wavefront; with orientation = "field" and vignetting_shift = { r = s } at s times
// the field point (`mtf/components/pupil/cut_pupil.h`). The OTF is that of the light that comes through; how much that
// is says [vignetting] of = "wavefront". A complete pupil OTF, zero from |f| = 1/(lambda N) on, or from the largest
// diameter of the pupil that is left. (Hopkins, Wave Theory of Aberrations (1950); Goodman, Introduction to Fourier
// Optics, ch. 6.)

#include <algorithm>
#include <cmath>
#include <vector>

#include "mtf/components/field.h"
#include "mtf/components/pupil/cut_pupil.h"
#include "mtf/components/pupil/pupil.h"
#include "mtf/components/pupil/wavefront_pupil.h"

namespace mtf {

inline constexpr FieldInfo wave_coefficient_info(std::string_view name, std::string_view doc) {
  return {.name = name, .lo = -10.0, .hi = 10.0, .presence = Presence::optional, .example = "0.1", .doc = doc};
}

template <class S>
struct Wavefront {
  static constexpr std::string_view kind = "wavefront";
  static constexpr std::string_view doc = "diffraction with aberrations by Seidel and Zernike coefficients";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;
  static constexpr bool is_pupil = true;
  static constexpr bool is_slow = true;

  std::optional<S> w020, w040, w131, w222, w311;
  Coefficients<S> zernike{};
  Choice numbering{0, kNumberingNames};
  NumberIn<S, degrees> orientation_deg{};
  std::optional<S> vignetting_rim, vignetting_shift;
  OptionalIn<S, micrometres> wavelength_reference_um{};
  std::optional<S> f_number{};
  std::optional<S> obscuration{};
  OptionalIn<S, micrometres> wavelength_um{};

  static constexpr auto fields() {
    return std::tuple{
        Field{&Wavefront::w020, wave_coefficient_info("w020", "defocus, waves at the pupil's edge")},
        Field{&Wavefront::w040, wave_coefficient_info("w040", "spherical aberration")},
        Field{&Wavefront::w131, wave_coefficient_info("w131", "coma along x")},
        Field{&Wavefront::w222, wave_coefficient_info("w222", "astigmatism: x^2")},
        Field{&Wavefront::w311, wave_coefficient_info("w311", "distortion: tilt along x, an image shift")},
        optional(&Wavefront::zernike, "zernike", -10.0, 10.0, "[0, 0, 0, 0.1, 0.05, 0, 0.08, 0, -0.06]",
                 "coefficients Z1, Z2, ... in waves"),
        optional(&Wavefront::numbering, "numbering", "\"fringe\"",
                 "of zernike: fringe (unit peak) or noll (unit rms over the full disc)"),
        optional(&Wavefront::orientation_deg, "orientation", "deg", -360.0, 360.0, "\"30 deg\"",
                 "turns the wavefront from +x (right) to +y (down)"),
        above(optional(&Wavefront::vignetting_rim, "vignetting_rim", 0.0, 10.0, "1.05",
                       "radius of the rim that cuts the pupil off the axis, in radii of the pupil")),
        optional(&Wavefront::vignetting_shift, "vignetting_shift", -10.0, 10.0, "0.5",
                 "place of the centre of that rim along x, in radii of the pupil; over the field { r = 0.5 }"),
        Field{&Wavefront::wavelength_reference_um, kWavelengthReferenceInfo},
        Field{&Wavefront::f_number, kFNumberInfo},
        Field{&Wavefront::obscuration, kQuadratureObscurationInfo},
        Field{&Wavefront::wavelength_um, kWavelengthInfo}};
  }

  S wavelength(const Context<S>& ctx) const { return wavelength_um.value_or(ctx.wavelength_um); }
  S nu(const S& f_cy_mm, const Context<S>& ctx) const {
    return relative_frequency(f_cy_mm, wavelength(ctx), f_number_of(f_number, ctx));
  }
  /// f(coefficient, term) for every coefficient that is given.
  template <class F>
  void each_coefficient(const F& f) const {
    const auto seidel = [&](const std::optional<S>& c, SeidelTerm term) {
      if (c) f(*c, seidel_polynomial(term));
    };
    seidel(w020, SeidelTerm::w020);
    seidel(w040, SeidelTerm::w040);
    seidel(w131, SeidelTerm::w131);
    seidel(w222, SeidelTerm::w222);
    seidel(w311, SeidelTerm::w311);
    const std::size_t known = std::min(zernike.size(), static_cast<std::size_t>(zernike_count(zernike_numbering())));
    for (std::size_t i = 0; i < known; ++i)
      f(zernike[i], zernike_polynomial(zernike_numbering(), 1 + static_cast<int>(i)));
  }
  ZernikeNumbering zernike_numbering() const { return static_cast<ZernikeNumbering>(numbering.index); }
  /// The wavefront in waves at the wavelength in use, before `orientation`.
  PupilPolynomial wavefront(const Context<S>& ctx) const {
    const double scale = value_of(waves_at(S(1), wavelength_reference_um, wavelength(ctx)));
    PupilPolynomial sum;
    each_coefficient([&](const S& c, const PupilPolynomial& term) { sum.add(term, scale * value_of(c)); });
    return sum;
  }

  /// The rim that cuts the pupil, far away where none does.
  template <class T = S>
  PupilRim<T> rim() const {
    return {T(vignetting_rim.value_or(S(kInfinity))), T(vignetting_shift.value_or(S(0)))};
  }
  /// Share of the pupil's area that the rim leaves.
  double throughput(const Context<S>& ctx) const {
    return pupil_share({value_of(rim().radius), value_of(rim().shift)}, value_of(obscuration_of(obscuration, ctx)));
  }

  Traits traits(const Context<S>& ctx) const {
    const WavefrontSymmetry own = symmetry_of(wavefront(ctx));
    if (own.radial) return {.radial = true, .even_x = true, .even_y = true, .chromatic = !wavelength_um};
    // Turned by a right angle the mirror axes change places; otherwise there are none along x and y.
    const auto [cosine, sine] = unit_vector(value_of(orientation_deg.value));
    const bool mirror_x = cosine == 0.0 ? own.mirror_y : sine == 0.0 && own.mirror_x;
    const bool mirror_y = cosine == 0.0 ? own.mirror_x : sine == 0.0 && own.mirror_y;
    // An OTF that is real and even about one axis is so about the other.
    const bool both = own.point && (mirror_x || mirror_y);
    return {.even_x = mirror_x || both, .even_y = mirror_y || both, .real = own.point, .chromatic = !wavelength_um};
  }

  /// Absolute error about `accuracy`.
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx, double accuracy = 1e-13) const {
    const PupilPolynomial w = wavefront(ctx);
    const S e = obscuration_of(obscuration, ctx);
    // The frequency is turned back instead of the wavefront.
    const auto [cosine, sine] = unit_vector(orientation_deg.value);
    const S x = nu(f.x, ctx), y = nu(f.y, ctx);
    const Freq<S> v{cosine * x + sine * y, cosine * y - sine * x};
    if (!rim().is_idle()) return cut(w, v, e, ctx, accuracy);
    if constexpr (std::is_floating_point_v<S>) {
      const Complex<double> h = wavefront_pupil_otf(w, {v.x, v.y}, e, accuracy);
      return {static_cast<S>(h.re), static_cast<S>(h.im)};
    } else {
      return with_derivatives(w, v, e, ctx, accuracy);
    }
  }
  double cutoff_cy_mm(const Context<S>& ctx) const { return rim().half_diameter() / value_of(nu(S(1), ctx)); }
  std::vector<double> kinks_cy_mm(const Context<S>& ctx) const {
    const double cutoff = cutoff_cy_mm(ctx);
    std::vector<double> kinks = pupil_kinks(value_of(obscuration_of(obscuration, ctx)), 1.0 / value_of(nu(S(1), ctx)));
    std::erase_if(kinks, [cutoff](double f) { return f >= cutoff; });
    kinks.push_back(cutoff);
    return kinks;
  }
  /// |1 - otf| <= (1 - MTF without aberrations) + mean of |exp(2 pi i D) - 1|, |D| <= 2 nu steepest slope.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double v = value_of(nu(S(std::hypot(fx, fy)), ctx));
    const bool round = rim().is_idle() && !(value_of(obscuration_of(obscuration, ctx)) > 0.0);
    const double perfect = round ? 1.0 - circular_pupil_mtf(v).value : 1.0;
    return std::min(2.0, perfect + 4.0 * kPi * std::min(v, 1.0) * steepest_slope(wavefront(ctx)));
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    const int most = zernike_count(zernike_numbering());
    if (std::ssize(zernike) > most)
      return {{.field = "zernike",
               .text = std::to_string(zernike.size()) + " coefficients; " +
                       std::string(numbering.names[static_cast<std::size_t>(numbering.index)]) + " numbering has " +
                       std::to_string(most) + " here"}};
    const double slope = steepest_slope(wavefront(ctx));
    if (slope > kSteepestWavefront)
      return {{.text = "the wavefront rises by " + format_double(slope) + " waves per pupil radius, more than " +
                       format_double(kSteepestWavefront) +
                       "; use \"defocus\" where it is defocus alone, or a geometrical blur"}};
    std::vector<Problem> problems = check_quadrature_obscuration(obscuration, ctx);
    if (vignetting_shift.has_value() != vignetting_rim.has_value())
      return {{.field = vignetting_rim ? "vignetting_shift" : "vignetting_rim",
               .text = "missing; a pupil is cut by a rim of a radius, vignetting_rim, at a place, vignetting_shift"}};
    if (constexpr double kLeast = 1e-3; problems.empty() && throughput(ctx) < kLeast)
      return {{.field = "vignetting_shift",
               .text = "the rim leaves " + three_digits(throughput(ctx)) + " of the pupil; less than " +
                       format_double(kLeast) + " makes no image"}};
    constexpr double kSlowFrom = 8.0;
    if (problems.empty() && slope > kSlowFrom)
      problems.push_back({.error = false,
                          .text = "a wavefront that rises by " + format_double(slope) +
                                  " waves per pupil radius is evaluated exactly, which can take minutes for a large "
                                  "image; where it is defocus alone, \"defocus\" is quicker"});
    return problems;
  }

 private:
  using T = std::conditional_t<std::is_same_v<S, float>, double, S>;

  /// What the pupil that is left keeps of the symmetry of the wavefront: its mirror image at the x axis.
  WavefrontSymmetry symmetry_of(const PupilPolynomial& w) const {
    const WavefrontSymmetry own = symmetry(w);
    if (rim().is_idle()) return own;
    const bool flat = w.degree == 0;  // the autocorrelation of the pupil alone
    return {.mirror_x = flat, .mirror_y = own.mirror_y, .point = flat, .radial = false};
  }
  /// The OTF of the cut pupil, at a frequency in the half or quarter that its symmetry leaves.
  Complex<S> cut(const PupilPolynomial& w, const Freq<S>& v, const S& e, const Context<S>& ctx, double accuracy) const {
    Freq<T> nu{T(v.x), T(v.y)};
    const bool conjugate = value_of(nu.x) < 0.0 || (value_of(nu.x) == 0.0 && value_of(nu.y) < 0.0);
    if (conjugate) nu = {-nu.x, -nu.y};
    const WavefrontSymmetry own = symmetry_of(w);
    if (own.mirror_y && value_of(nu.y) < 0.0) nu.y = -nu.y;
    WavePolynomial<T> waves;
    const S scale = waves_at(S(1), wavelength_reference_um, wavelength(ctx));
    each_coefficient([&](const S& c, const PupilPolynomial& term) { waves.add(term, T(c * scale)); });
    const Complex<T> h = cut_pupil_otf<T>(waves, nu, T(e), rim<T>(), accuracy);
    return {S(h.re), own.point ? S(lift({0.0, 1.0}, h.im)) : S(conjugate ? T(-h.im) : h.im)};
  }
  /// S is a Jet.
  Complex<S> with_derivatives(const PupilPolynomial& w, const Freq<S>& v, const S& e, const Context<S>& ctx,
                              double accuracy) const {
    const S scale = waves_at(S(1), wavelength_reference_um, wavelength(ctx));
    std::vector<PupilPolynomial> terms;
    std::vector<S> waves;
    each_coefficient([&](const S& c, const PupilPolynomial& term) {
      const S here = c * scale;
      if (here.v.isZero(0)) return;  // nobody asks for its derivative
      terms.push_back(term);
      waves.push_back(here);
    });
    const WavefrontOtf h =
        wavefront_pupil_gradient(w, {value_of(v.x), value_of(v.y)}, value_of(e), {terms, true}, accuracy);
    Complex<S> result{lift(h.value.re, h.d_nu_x.re, v.x, h.d_nu_y.re, v.y) + lift({0.0, h.d_obscuration.re}, e),
                      lift(h.value.im, h.d_nu_x.im, v.x, h.d_nu_y.im, v.y) + lift({0.0, h.d_obscuration.im}, e)};
    for (std::size_t i = 0; i < terms.size(); ++i) {
      result.re += lift({0.0, h.d_term[i].re}, waves[i]);
      result.im += lift({0.0, h.d_term[i].im}, waves[i]);
    }
    return result;
  }
};

}  // namespace mtf
