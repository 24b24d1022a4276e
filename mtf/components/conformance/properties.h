// SPDX-License-Identifier: Apache-2.0
#pragma once

// The properties that every component keeps, each as a function that adds its comparisons to an outcome. With h(f) the
// OTF at f = (fx, fy) in cycles/mm:
//   h(0) = 1, or the declared gain at zero frequency           |h| <= 1 where no gain is declared
//   h(-f) = conj h(f), as the OTF of a real point spread       the declared symmetries
//   h = 0 from the cutoff on, and not below it                 finite for every finite f
//   |h - 1| <= deviation                                       the wavelength matters only where that is declared
//   rows and evaluator give the OTF                            h(f) = h((f.u) u) for a motion along u
//   float gives what double gives                              values outside the range of a field are refused by name
// For double and float alike; allowances are multiples of the rounding of S. Derivatives: slope_checks.h.

#include <cmath>
#include <limits>

#include "mtf/components/conformance/subject.h"

namespace mtf::conformance {

template <class S>
constexpr double ulp() {
  return static_cast<double>(std::numeric_limits<S>::epsilon());
}

template <class S>
double modulus(const Complex<S>& h) {
  return std::hypot(static_cast<double>(h.re), static_cast<double>(h.im));
}

template <class S>
double distance(const Complex<S>& a, const Complex<S>& b) {
  return std::hypot(static_cast<double>(a.re) - static_cast<double>(b.re),
                    static_cast<double>(a.im) - static_cast<double>(b.im));
}

/// A thousandth to 300 cycles/mm, of either sign.
inline double random_frequency(Random& random) {
  const double f = random.decades(1e-3, 300.0);
  return random.below(2) == 1 ? f : -f;
}

template <class S, class C>
void unity_at_zero_frequency(const Subject<S, C>& s, Outcome& outcome) {
  const Complex<S> h = s.otf(S(0), S(0));
  const Traits traits = s.traits();
  const auto place = [&] { return s.at(0.0, 0.0); };
  outcome.at_most(std::abs(static_cast<double>(h.re) - traits.dc), 4.0 * ulp<S>() * s.scale, place);
  outcome.at_most(std::abs(static_cast<double>(h.im)), 0.0, place);
  if (!traits.gain) outcome.holds(traits.dc == 1.0, [&] { return place() + ", dc is not 1 and no gain is declared"; });
}

template <class S, class C>
void passive_ones_do_not_amplify(const Subject<S, C>& s, Outcome& outcome) {
  if (s.traits().gain) return;
  Random random(s.name, 1);
  for (int i = 0; i < 200; ++i) {
    const S x = static_cast<S>(random_frequency(random)), other = static_cast<S>(random_frequency(random)),
            y = i % 3 ? other : S(0);
    outcome.at_most(modulus(s.otf(x, y)), 1.0 + 4.0 * ulp<S>(), [&] { return s.at(x, y); });
  }
}

template <class S, class C>
void hermitian(const Subject<S, C>& s, Outcome& outcome) {
  Random random(s.name, 2);
  for (int i = 0; i < 50; ++i) {
    const S x = static_cast<S>(random_frequency(random)), y = static_cast<S>(random_frequency(random));
    const Complex<S> h = s.otf(x, y), g = s.otf(-x, -y);
    outcome.at_most(distance(h, {g.re, -g.im}), 1e-15 * s.scale, [&] { return s.at(x, y); });
  }
}

template <class S, class C>
void declared_symmetry_is_true(const Subject<S, C>& s, Outcome& outcome) {
  Random random(s.name, 3);
  const Traits traits = s.traits();
  const double rounding = ulp<S>() * s.scale;
  const Complex<S> zero = s.otf(S(0), S(0)), one{S(1), S(0)};
  for (int i = 0; i < 50; ++i) {
    const double u = random_frequency(random), v = random_frequency(random);
    const S x = static_cast<S>(u), y = static_cast<S>(v);
    const Complex<S> h = s.otf(x, y);
    const auto same = [&](const char* flag, const Complex<S>& a, const Complex<S>& b, double ulps) {
      outcome.at_most(distance(a, b), ulps * rounding, [&] { return s.at(u, v) + ", declared " + flag; });
    };
    if (traits.real)
      outcome.at_most(std::abs(static_cast<double>(h.im)), 0.0, [&] { return s.at(u, v) + ", declared real"; });
    if (traits.even_x) same("even_x", h, s.otf(-x, y), 8.0);
    if (traits.even_y) same("even_y", h, s.otf(x, -y), 8.0);
    if (traits.radial) {  // slopes against log f stay below a few units for all but narrow annuli
      const S r = static_cast<S>(std::hypot(static_cast<double>(x), static_cast<double>(y)));
      const double steep = s.typical ? 32.0 : 1e4;
      same("radial", h, s.otf(r, S(0)), steep);
      same("radial", h, s.otf(S(0), -r), steep);
    }
    if (traits.square) same("square", s.otf(x, S(0)), s.otf(S(0), x), 8.0);
    if (traits.flat_x) same("flat_x", s.otf(x, S(0)), one, 8.0);
    if (traits.flat_y) same("flat_y", s.otf(S(0), y), one, 8.0);
    if (traits.separable) same("separable", h * zero, s.otf(x, S(0)) * s.otf(S(0), y), 8.0);
  }
}

/// A finite cutoff is where the OTF ends: it is zero from there on and not much below.
template <class S, class C>
void cutoff_is_true_and_tight(const Subject<S, C>& s, Outcome& outcome) {
  const double cutoff = mtf::detail::cutoff_of(s.component, s.ctx);
  outcome.holds(cutoff > 0.0, [&] { return s.name + ": the cutoff is not positive"; });
  if (!(cutoff > 0.0 && std::isfinite(cutoff))) return;
  const bool pupil = is_pupil(s.component), all_round = s.traits().radial;
  bool reached = false;
  for (const double angle : {0.0, 0.3, 1.1, 0.5 * kPi, 2.0, 3.1}) {
    const double cosine = std::cos(angle), sine = std::sin(angle);
    const auto at = [&](double f) { return modulus(s.otf(static_cast<S>(f * cosine), static_cast<S>(f * sine))); };
    const auto place = [&](double f) { return s.at(f * cosine, f * sine) + ", cutoff " + format_double(cutoff); };
    for (const double factor : {1.0 + 8.0 * ulp<S>(), 1.001, 2.0, 1e6})
      outcome.at_most(at(cutoff * factor), 0.0, [&] { return place(cutoff * factor); });
    const double before = at(0.99 * cutoff);
    const bool here = before > (s.typical && pupil ? 1e-4 : 0.0);
    reached = reached || here;
    if (all_round) outcome.holds(here, [&] { return place(0.99 * cutoff) + ", the OTF ends below its cutoff"; });
    // The cutoff itself may round to either side: a pupil ends like (1 - nu)^1.5, others at most with a steep slope.
    const double left = pupil ? 100.0 * std::pow(4.0 * ulp<S>(), 1.5) : 1e4 * ulp<S>() * before;
    if (s.typical) outcome.at_most(at(cutoff), left, [&] { return place(cutoff); });
  }
  if (!all_round) outcome.holds(reached, [&] { return s.name + ": the OTF ends below its cutoff in all directions"; });
}

template <class S, class C>
void finite_everywhere(const Subject<S, C>& s, Outcome& outcome) {
  const double largest = std::is_same_v<S, float> ? 3e38 : 1e300;
  const double frequencies[] = {0.0, 5e-324, 1e-300, 1e-45, 1e-9, 0.01, 20.0, 125.0, 1e4, 1e18, 1e30, largest};
  for (const double a : frequencies)
    for (const double b : frequencies)
      for (const double y : {b, -b})
        outcome.at_most(modulus(s.otf(static_cast<S>(a), static_cast<S>(y))), 1.05 * s.scale * (1.0 + 8.0 * ulp<S>()),
                        [&] { return s.at(a, y); });
}

template <class S, class C>
void deviation_bounds_the_distance_from_one(const Subject<S, C>& s, Outcome& outcome) {
  Random random(s.name, 5);
  const double rounding = 4.0 * ulp<S>() * s.scale;
  for (int i = 0; i < 40; ++i) {
    const double fx = random.decades(1e-4, 500.0), fy = random.below(4) == 0 ? 0.0 : random.decades(1e-4, 500.0);
    const double bound = s.component.deviation(fx, fy, s.ctx);
    outcome.holds(bound >= 0.0 && std::isfinite(bound),
                  [&] { return s.at(fx, fy) + ", the deviation is negative or not finite"; });
    for (int k = 0; k < 5; ++k) {
      const S x = static_cast<S>(k == 0 ? fx : random.uniform(-fx, fx)),
              y = static_cast<S>(k == 0 ? fy : random.uniform(-fy, fy));
      outcome.at_most(distance(s.otf(x, y), {S(1), S(0)}), bound * (1.0 + 64.0 * ulp<S>()) + rounding,
                      [&] { return s.at(x, y) + ", deviation at " + format_double(fx) + ", " + format_double(fy); });
    }
  }
}

template <class S, class C>
void chromatic_flag_is_true(const Subject<S, C>& s, Outcome& outcome) {
  const bool chromatic = s.traits().chromatic;
  Context<S> other = s.ctx;
  other.wavelength_um = s.ctx.wavelength_um * S(1.25);
  bool differs = false;
  for (const double f : {0.1, 3.0, 20.0, 60.0}) {
    const Freq<S> at{static_cast<S>(f), static_cast<S>(0.7 * f)};
    differs |= distance(s.component.otf(at, s.ctx), s.component.otf(at, other)) > 0.0;
  }
  if (!chromatic) outcome.holds(!differs, [&] { return s.name + ": depends on the wavelength, chromatic is false"; });
  if (chromatic && s.typical)
    outcome.holds(differs, [&] { return s.name + ": does not depend on the wavelength, chromatic is true"; });
}

/// The two functions that a component may add for speed, on frequencies that both take.
template <class C>
void rows_equal_the_otf(const Subject<double, C>& s, Outcome& outcome) {
  Random random(s.name, 31);
  std::vector<double> fx(5);
  for (double& f : fx) f = random_frequency(random);
  const auto compare = [&](double x, double y, const Complex<double>& h, const Complex<double>& expected) {
    outcome.at_most(distance(h, expected), 32.0 * ulp<double>() * s.scale, [&] { return s.at(x, y); });
  };
  if constexpr (requires { s.component.rows(fx, s.ctx); }) {
    const auto rows = s.component.rows(fx, s.ctx);
    for (int repeat = 0; repeat < 2; ++repeat) {
      const double fy = random_frequency(random);
      std::vector<Complex<double>> h(4, {0.0, 2.0});
      rows(fy, h);
      for (std::size_t i = 0; i < h.size(); ++i) compare(fx[i], fy, h[i], s.otf(fx[i], fy) * Complex<double>{0.0, 2.0});
    }
  }
  if constexpr (requires { s.component.evaluator(s.ctx); }) {
    const auto otf = s.component.evaluator(s.ctx);
    for (const double x : fx) compare(x, 0.7 * x, otf(Freq<double>{x, 0.7 * x}), s.otf(x, 0.7 * x));
  }
}

/// The direction of a motion: of a Component its line(), of a type of its own its displacement_mm().
template <class C>
std::optional<Freq<double>> line_of(const Subject<double, C>& s) {
  if constexpr (requires { s.component.line(s.ctx); })
    return s.component.line(s.ctx);
  else if constexpr (requires { s.component.displacement_mm(s.ctx); })
    return mtf::detail::direction_of(s.component.displacement_mm(s.ctx));
  else
    return std::nullopt;
}

template <class C>
void only_the_projection_counts(const Subject<double, C>& s, Outcome& outcome) {
  Random random(s.name, 32);
  const std::optional<Freq<double>> u = line_of(s);
  if (!s.typical || !u) return;
  outcome.at_most(std::abs(std::hypot(u->x, u->y) - 1.0), 1e-15, [&] { return s.name + ": length of the direction"; });
  for (int repeat = 0; repeat < 20; ++repeat) {
    const double x = random_frequency(random), y = random_frequency(random), along = x * u->x + y * u->y;
    outcome.at_most(distance(s.otf(x, y), s.otf(along * u->x, along * u->y)), 1e-11, [&] { return s.at(x, y); });
  }
}

/// The subject with parameters that float holds exactly, so that only the arithmetic differs.
template <class C>
Subject<double, C> rounded_to_float(Subject<double, C> s) {
  for (const Scalar<double>& scalar : scalars_of<double>(fields_of<double>(s.component)))
    *scalar.value = static_cast<double>(static_cast<float>(*scalar.value));
  return s;
}

/// `exact` of rounded_to_float, `single` the same over float.
template <class Double, class Float>
void float_equals_double(const Subject<double, Double>& exact, const Subject<float, Float>& single, Outcome& outcome) {
  if (!exact.typical) return;
  Random random(exact.name, 6);
  const double most = allowed_in_presample(exact.component) ? 4.0 : 1.0;  // times the detector's Nyquist frequency
  for (int i = 0; i < 300; ++i) {
    const auto draw = [&](Axis axis) {
      return static_cast<float>(most * exact.ctx.frame.nyquist_cy_mm(axis) * random.uniform(-1.0, 1.0));
    };
    const float x = draw(Axis::x), y = draw(Axis::y);
    const double u = static_cast<double>(x), v = static_cast<double>(y);
    const Complex<double> h = exact.otf(u, v);
    const Complex<float> g = single.otf(x, y);
    const double off = distance(h, {static_cast<double>(g.re), static_cast<double>(g.im)});
    double allowed = 1e-6 * exact.scale;
    if (!(off <= allowed)) {
      // A phase is the sum of two products, along x and y, each of which carries the roundings of four factors to
      // float, 4 x 2^-24 of itself. Almost across a motion of ten cycles they cancel, their roundings do not.
      const double nudge = 1.0 + 0x1p-22;
      allowed = distance(h, exact.otf(nudge * u, v)) + distance(h, exact.otf(u, nudge * v));
    }
    outcome.at_most(off, allowed, [&] { return single.at(u, v); });
  }
}

/// For each number of the component the values just outside of its range, infinities and NaN.
template <class C>
void values_outside_their_range_are_refused_by_name(const Subject<double, C>& s, Outcome& outcome) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  C broken = s.component;
  const auto scalars = scalars_of<double>(fields_of<double>(broken));
  for (const Scalar<double>& scalar : scalars) {
    const FieldInfo& info = *scalar.info;
    const double own = *scalar.value;
    for (const double bad :
         {info.lo_open ? info.lo : std::nextafter(info.lo, -inf), info.hi_open ? info.hi : std::nextafter(info.hi, inf),
          inf, -inf, std::numeric_limits<double>::quiet_NaN()}) {
      *scalar.value = bad;
      const auto problems = problems_of<double>(broken, s.ctx);
      const bool named = std::any_of(problems.begin(), problems.end(), [&](const Problem& problem) {
        return problem.error && problem.field.starts_with(info.name) &&
               problem.text.find("outside") != std::string::npos;
      });
      outcome.holds(named, [&] { return s.name + ": " + scalar.name + " = " + format_double(bad) + " is accepted"; });
    }
    *scalar.value = own;
  }
}

}  // namespace mtf::conformance
