// SPDX-License-Identifier: Apache-2.0
#pragma once

// Derivatives of an OTF by automatic differentiation, against difference quotients of the same body over double: by
// every number of the component, by focal length, pitches, wavelength, f-number and obscuration, and by both
// frequencies. `Jet` is ceres::Jet<double, N>, the scalar type of fits; nothing here includes Ceres.
// A quotient counts only where two step sizes agree, which they do not across a kink.

#include <array>
#include <cmath>
#include <cstdlib>

#include "mtf/components/conformance/subject.h"

namespace mtf::conformance {

/// The same values over double and over Jet. The wavelength of both comes from their optics, so that it is a parameter
/// like the others.
template <class Jet, class Double, class Jets>
struct Pair {
  Subject<double, Double> plain;
  Subject<Jet, Jets> jets;
};

struct Gradient {
  Complex<double> value;
  Complex<double> slope;
};

namespace detail {

/// The parameters of an OTF at one frequency, which belongs to them.
template <class S, class C>
struct Place {
  C component;
  Context<S> ctx;
  Freq<S> f;

  Place(const Subject<S, C>& subject, const Freq<double>& at)
      : component(subject.component), ctx(subject.ctx), f{S(at.x), S(at.y)} {}
  std::vector<S*> parameters() {
    std::vector<S*> all;
    for (const Scalar<S>& scalar : scalars_of<S>(fields_of<S>(component))) all.push_back(scalar.value);
    for (S* s : {&ctx.frame.focal_length_mm, &ctx.frame.pitch_x_um, &ctx.frame.pitch_y_um, &*ctx.optics.wavelength_um,
                 &*ctx.optics.f_number, &*ctx.optics.obscuration, &f.x, &f.y})
      all.push_back(s);
    return all;
  }
  Complex<S> otf() {
    ctx.wavelength_um = *ctx.optics.wavelength_um;
    return component.otf(f, ctx);
  }
};

inline double norm(const Complex<double>& z) { return std::hypot(z.re, z.im); }
inline Complex<double> combine(double a, const Complex<double>& x, double b, const Complex<double>& y) {
  return {a * x.re + b * y.re, a * x.im + b * y.im};
}

template <class C>
Complex<double> value_at(const Subject<double, C>& s, const Freq<double>& f, std::size_t index, double value) {
  Place<double, C> place(s, f);
  *place.parameters()[index] = value;
  return place.otf();
}

/// Difference quotient, second order; one-sided (`side` +1, -1) or central (0).
template <class C>
Complex<double> difference(const Subject<double, C>& s, const Freq<double>& f, std::size_t index, double at, double h,
                           int side) {
  const auto v = [&](double x) { return value_at(s, f, index, x); };
  if (side == 0) return combine(0.5 / h, v(at + h), -0.5 / h, v(at - h));
  const double step = side * h;
  const Complex<double> near = combine(-1.5 / step, v(at), 2.0 / step, v(at + step));
  return combine(1.0, near, -0.5 / step, v(at + 2.0 * step));
}

/// Small values next to a bound have no scale of their own; the example's is used, where it is a small plain number.
template <class C>
double smallest_scale(const Subject<double, C>& s, std::size_t index) {
  C component = s.component;
  const auto scalars = scalars_of<double>(fields_of<double>(component));
  if (index >= scalars.size() || scalars[index].info->dimension != Dimension::none) return 1e-2;
  const double example = std::strtod(std::string(scalars[index].info->example).c_str(), nullptr);
  return example > 0.0 ? std::min(example, 1e-2) : 1e-2;
}

}  // namespace detail

/// Names of the parameters: the numbers of the component, six of its surroundings, "fx" and "fy".
template <class C>
std::vector<std::string> parameter_names(const Subject<double, C>& s) {
  C component = s.component;
  std::vector<std::string> names;
  for (const Scalar<double>& scalar : scalars_of<double>(fields_of<double>(component))) names.push_back(scalar.name);
  for (const char* name :
       {"focal_length", "pitch_x", "pitch_y", "optics.wavelength", "optics.f_number", "optics.obscuration", "fx", "fy"})
    names.emplace_back(name);
  return names;
}

/// Value and slope by the parameter of that index, where it is `at` if given.
template <class Jet, class C>
Gradient gradient(const Subject<Jet, C>& s, const Freq<double>& f, std::size_t index, Outcome& outcome,
                  std::optional<double> at = std::nullopt) {
  constexpr int slot = Jet::DIMENSION / 2;
  detail::Place<Jet, C> place(s, f);
  Jet& parameter = *place.parameters()[index];
  if (at) parameter = Jet(*at);
  parameter.v[slot] = 1.0;
  const Complex<Jet> h = place.otf();
  if constexpr (slot != 0)
    outcome.at_most(std::abs(h.re.v[0]), 0.0, [&] { return s.at(f.x, f.y) + ": derivatives change their slots"; });
  return {{h.re.a, h.im.a}, {h.re.v[slot], h.im.v[slot]}};
}

/// Compares where the difference quotient itself has converged; true when it had.
template <class Jet, class Double, class Jets>
bool slope_equals_difference(const Pair<Jet, Double, Jets>& pair, const Freq<double>& f, std::size_t index, double at,
                             int side, Outcome& outcome) {
  using namespace detail;
  const Subject<double, Double>& s = pair.plain;
  const auto place = [&] {
    return s.at(f.x, f.y) + " by " + parameter_names(s)[index] + " = " + format_double(at) +
           (side == 0  ? ""
            : side > 0 ? ", from above"
                       : ", from below");
  };
  const Gradient jet = gradient(pair.jets, f, index, outcome, at);
  outcome.holds(std::isfinite(jet.slope.re) && std::isfinite(jet.slope.im), [&] { return place() + ": not finite"; });
  // 1e-14 but for pupil quadrature: 1e-13, 2e-15 / (1 - e^2) for obscurations up to 0.999, and mirrored frequencies are
  // folded only without derivatives.
  outcome.at_most(norm(combine(1.0, jet.value, -1.0, value_at(s, f, index, at))), 1e-12,
                  [&] { return place() + ": the value itself"; });
  const double scale = std::max(std::abs(at), smallest_scale(s, index)), h = (side == 0 ? 2.173e-5 : 1.071e-5) * scale;
  const Complex<double> wide = difference(s, f, index, at, h, side),
                        narrow = difference(s, f, index, at, 0.618 * h, side);
  const double tolerance = 1e-6 * (norm(wide) + 0.01 / scale);
  if (!(norm(combine(1.0, wide, -1.0, narrow)) < 0.3 * tolerance)) return false;
  outcome.at_most(norm(combine(1.0, jet.slope, -1.0, narrow)), tolerance, place);
  return true;
}

struct Quotients {
  std::size_t tried = 0, converged = 0;
};

/// Inside the range, at eight frequencies. At six of them at least the quotient has to converge.
template <class Jet, class Double, class Jets>
Quotients gradient_equals_difference(const Pair<Jet, Double, Jets>& pair, Outcome& outcome) {
  constexpr std::array<Freq<double>, 8> frequencies{
      {{3e-7, 0.0}, {0.2, -0.1}, {5.0, 3.0}, {-21.7, 4.4}, {33.0, 33.0}, {0.0, 47.0}, {61.0, 1e-3}, {150.0, 80.0}}};
  Quotients all;
  if (!pair.plain.typical) return all;
  const std::vector<std::string> names = parameter_names(pair.plain);
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::size_t converged = 0;
    for (const Freq<double>& f : frequencies) {
      const double at = *detail::Place(pair.plain, f).parameters()[i];
      converged += slope_equals_difference(pair, f, i, at, 0, outcome) ? 1 : 0;
    }
    outcome.holds(converged >= frequencies.size() - 2,
                  [&] { return pair.plain.name + " by " + names[i] + ": the difference quotient does not converge"; });
    all.tried += frequencies.size();
    all.converged += converged;
  }
  return all;
}

/// At the bounds of each field, from inside. Gives the names of those that could be compared: "rms.lo".
template <class Jet, class Double, class Jets>
std::vector<std::string> gradient_at_bounds(const Pair<Jet, Double, Jets>& pair, Outcome& outcome) {
  std::vector<std::string> compared;
  Double component = pair.plain.component;
  const auto scalars = scalars_of<double>(fields_of<double>(component));
  for (std::size_t i = 0; i < scalars.size(); ++i) {
    const FieldInfo& info = *scalars[i].info;
    const auto accepted = [&](double value) {
      const double own = *scalars[i].value;
      *scalars[i].value = value;
      const bool yes = is_accepted<double>(component, pair.plain.ctx);
      *scalars[i].value = own;
      return yes;
    };
    bool low = false, high = false;
    // A bound of 1e9 um or 1e15 um/s is seen at a frequency where the component is not yet gone.
    for (const Freq<double>& f : {Freq<double>{1e-7, 5e-8}, {1e-4, 2e-5}, {0.3, 0.1}, {12.0, 7.0}}) {
      if (!info.lo_open && accepted(info.lo) && slope_equals_difference(pair, f, i, info.lo, 1, outcome)) low = true;
      if (!info.hi_open && accepted(info.hi) && slope_equals_difference(pair, f, i, info.hi, -1, outcome)) high = true;
    }
    if (low) compared.push_back(scalars[i].name + ".lo");
    if (high) compared.push_back(scalars[i].name + ".hi");
  }
  return compared;
}

/// At f = 0 every OTF is 1 whatever its parameters, but for a gain: a filter's is the sum of its taps, and a field of
/// that name holds them; others are compared with the difference quotient. No slope along the frequency there (a tip
/// counts as none), but the phase of a one-sided response turns at once.
template <class Jet, class Double, class Jets>
void gradient_at_zero_frequency(const Pair<Jet, Double, Jets>& pair, Outcome& outcome) {
  const std::vector<std::string> names = parameter_names(pair.plain);
  const bool real = pair.plain.traits().real, gain = pair.plain.traits().gain;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool frequency = i + 2 >= names.size();
    if (frequency && !pair.plain.typical) continue;
    const Gradient g = gradient(pair.jets, {0.0, 0.0}, i, outcome);
    const auto place = [&] { return pair.plain.at(0.0, 0.0) + " by " + names[i]; };
    if (gain && !frequency && names[i] != "taps[]" && g.slope.re != 0.0) {
      const double at = *detail::Place(pair.plain, {0.0, 0.0}).parameters()[i];
      static_cast<void>(slope_equals_difference(pair, {0.0, 0.0}, i, at, 0, outcome));
      continue;
    }
    outcome.at_most(std::abs(g.slope.re - (names[i] == "taps[]" ? 1.0 : 0.0)), frequency ? 1e-12 : 1e-14, place);
    if (!frequency || real) outcome.at_most(std::abs(g.slope.im), frequency ? 1e-12 : 0.0, place);
  }
}

template <class Jet, class Double, class Jets>
void gradient_at_and_beyond_the_cutoff(const Pair<Jet, Double, Jets>& pair, Outcome& outcome) {
  const double cutoff = mtf::detail::cutoff_of(pair.plain.component, pair.plain.ctx);
  if (!std::isfinite(cutoff)) return;
  const std::vector<std::string> names = parameter_names(pair.plain);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto place = [&] { return pair.plain.name + " at its cutoff by " + names[i]; };
    outcome.at_most(std::abs(gradient(pair.jets, {cutoff * 1.001, 0.0}, i, outcome).slope.re), 0.0, place);
    if (!pair.plain.typical || !is_pupil(pair.plain.component)) continue;
    // The MTF of a pupil ends like (1 - nu)^1.5, so its slope ends in 0.
    const Freq<double> f{cutoff, 0.0};
    const double scale = std::max(1.0, std::abs(*detail::Place(pair.plain, f).parameters()[i]));
    outcome.at_most(std::abs(gradient(pair.jets, f, i, outcome).slope.re) * scale, 1e-4, place);
  }
}

template <class Jet, class Double, class Jets>
void gradient_is_never_nan(const Pair<Jet, Double, Jets>& pair, Outcome& outcome) {
  const std::vector<std::string> names = parameter_names(pair.plain);
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const double x : {0.0, 5e-324, 1e-300, 1e-9, 0.1, 20.0, 1e4, 1e30, 1e300})
      for (const double y : {0.0, -x, 33.0}) {
        const Complex<double> slope = gradient(pair.jets, {x, y}, i, outcome).slope;
        outcome.holds(!std::isnan(slope.re) && !std::isnan(slope.im),
                      [&] { return pair.plain.at(x, y) + " by " + names[i] + ": not a number"; });
      }
}

/// Where u^(n - 1) or 1/u of a formula would be infinite, or their product with 0 no number.
template <class Jet, class Double, class Jets>
void gradient_is_finite_at_and_near_zero(const Pair<Jet, Double, Jets>& pair, Outcome& outcome) {
  const std::vector<std::string> names = parameter_names(pair.plain);
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const Freq<double>& f :
         {Freq<double>{0.0, 0.0}, {5e-324, 0.0}, {0.0, -5e-324}, {5e-324, 5e-324}, {-1e-310, 0.0}}) {
      const Complex<double> slope = gradient(pair.jets, f, i, outcome).slope;
      outcome.holds(std::isfinite(slope.re) && std::isfinite(slope.im),
                    [&] { return pair.plain.at(f.x, f.y) + " by " + names[i] + ": not finite"; });
    }
}

}  // namespace mtf::conformance
