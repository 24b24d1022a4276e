// SPDX-License-Identifier: Apache-2.0
#pragma once

// A component with its values and surroundings, as the properties see it, and what the check of one of them has found.
// It is a Component<S>, as systems hold it, or the type C<S> that a header defines and that need not be in the list of
// mtf/components/all.h.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "mtf/components/conformance/draws.h"
#include "mtf/components/field_access.h"
#include "mtf/units.h"

namespace mtf::conformance {

/// One property over all values and frequencies that were tried: how many comparisons were made, how many failed, and
/// the one that failed by most.
struct Outcome {
  std::string property;
  std::size_t compared = 0;
  std::size_t failed = 0;
  std::string where{};   ///< of the worst failure: values of the component, frequency, what was compared
  double found = 0.0;    ///< there: the difference, or the value that has a bound
  double allowed = 0.0;  ///< there
  bool ok() const { return failed == 0; }

  /// Makes one comparison, which a NaN fails. `place` is a function that gives `where`; called for failures.
  void at_most(double value, double limit, const auto& place) {
    ++compared;
    if (value <= limit) return;
    if (failed++ == 0 || std::isnan(value) || value - limit > found - allowed) {
      where = place();
      found = value;
      allowed = limit;
    }
  }
  /// The same for what is true or false: a failure has found 1 and allowed 0.
  void holds(bool is_true, const auto& place) { at_most(is_true ? 0.0 : 1.0, 0.0, place); }
};

inline bool all_ok(const std::vector<Outcome>& outcomes) {
  return std::all_of(outcomes.begin(), outcomes.end(), [](const Outcome& outcome) { return outcome.ok(); });
}

/// A line for each property that fails: "hermitian: 3 of 50 comparisons fail; the worst gives 0.2 where at most 1e-15
/// is allowed: jitter rms #3 at (20, -5) cy/mm". Empty when none does.
inline std::string describe_failures(const std::vector<Outcome>& outcomes) {
  std::string text;
  for (const Outcome& outcome : outcomes)
    if (!outcome.ok())
      text += outcome.property + ": " + std::to_string(outcome.failed) + " of " + std::to_string(outcome.compared) +
              " comparisons fail; the worst gives " + format_double(outcome.found) + " where at most " +
              format_double(outcome.allowed) + " is allowed: " + outcome.where + "\n";
  return text;
}

template <class S, class C>
struct Subject {
  std::string name;  ///< of the draw
  bool typical;      ///< Draw::typical
  C component;       ///< over S
  Context<S> ctx;
  double scale = 1.0;  ///< the largest modulus of the OTF: differences by rounding are allowed in proportion to it

  Traits traits() const { return component.traits(ctx); }
  Complex<S> otf(const S& x, const S& y) const { return component.otf({x, y}, ctx); }
  /// "jitter rms #3 at (20, -5) cy/mm".
  std::string at(double x, double y) const {
    return name + " at (" + format_double(x) + ", " + format_double(y) + ") cy/mm" +
           (std::is_same_v<S, float> ? ", in float" : "");
  }
};

/// A bound of |otf|: a component that amplifies differs from 1 by its deviation at most, all others stay below 1.
template <class C>
double largest_modulus(const C& component, const Context<double>& ctx) {
  return component.traits(ctx).gain ? 1.0 + component.deviation(1e300, 1e300, ctx) : 1.0;
}

template <class S, class C>
std::vector<FieldRef<S>> fields_of(C& component) {
  if constexpr (std::is_same_v<C, Component<S>>)
    return component.fields();
  else
    return mtf::detail::field_refs<C, S>(component);
}

/// What Component::check finds: values outside the bounds of their fields or, without any, what its own check() says.
template <class S, class C>
std::vector<Problem> problems_of(const C& component, const Context<S>& ctx) {
  if constexpr (std::is_same_v<C, Component<S>>) {
    return component.check(ctx);
  } else {
    C copy = component;
    const std::vector<Problem> problems = mtf::detail::check_fields(fields_of<S>(copy), ctx);
    return problems.empty() ? mtf::detail::own_check(component, ctx) : problems;
  }
}

template <class S, class C>
bool is_accepted(const C& component, const Context<S>& ctx) {
  const auto problems = problems_of<S>(component, ctx);
  return std::none_of(problems.begin(), problems.end(), [](const Problem& problem) { return problem.error; });
}

template <class C>
bool is_pupil(const C& component) {
  if constexpr (requires { component.is_pupil(); })
    return component.is_pupil();
  else
    return requires { C::is_pupil; };
}

template <class C>
bool allowed_in_presample(const C& component) {
  if constexpr (requires { component.stages(); })
    return component.stages().presample;
  else
    return C::stages.presample;
}

/// A number that a fit could vary, with the row of its field.
template <class S>
struct Scalar {
  std::string name;  ///< of the field, with "_x", "_y" or "[]" for a part of it
  S* value;
  const FieldInfo* info;
};

/// All of them, in the order of the field table.
template <class S>
std::vector<Scalar<S>> scalars_of(const std::vector<FieldRef<S>>& fields) {
  std::vector<Scalar<S>> all;
  for (const FieldRef<S>& field : fields) {
    const std::string name(field.info->name);
    const auto push = [&](S& s, const std::string& suffix = "") { all.push_back({name + suffix, &s, field.info}); };
    std::visit(
        [&](auto* v) {
          using T = std::remove_pointer_t<decltype(v)>;
          if constexpr (std::is_same_v<T, S>) {
            push(*v);
          } else if constexpr (std::is_same_v<T, std::optional<S>>) {
            if (*v) push(**v);
          } else if constexpr (std::is_same_v<T, AxisPair<S>>) {
            if (v->given()) push(v->x.value, v->split ? "_x" : "");
            if (v->given() && v->split) push(v->y.value, "_y");
          } else if constexpr (std::is_same_v<T, SpatialFrequency<S>>) {
            if (v->unit != nullptr) push(v->value);
          } else if constexpr (std::is_same_v<T, Coefficients<S>>) {
            for (S& coefficient : *v) push(coefficient, "[]");
          } else if constexpr (std::is_same_v<T, Taps<S>>) {
            for (auto& row : *v)
              for (S& tap : row) push(tap, "[]");
          }
        },
        field.value);
  }
  return all;
}

/// The subject of a draw, over double; `component`: with default values.
template <class C>
Subject<double, C> subject_of(const Draw& draw, C component) {
  const Context<double> ctx = give_values(draw, fields_of<double>(component));
  const double scale = largest_modulus(component, ctx);
  return {draw.name, draw.typical(), std::move(component), ctx, scale};
}

/// The same values in another scalar type. `To` is the component type over S.
template <class S, class To, class From>
Subject<S, To> cast_subject(const Subject<double, From>& from) {
  From source = from.component;
  Subject<S, To> to{from.name, from.typical, {}, {}, from.scale};
  mtf::detail::cast_fields<S, double>(fields_of<double>(source), fields_of<S>(to.component));
  to.ctx = {mtf::detail::cast_frame<S>(from.ctx.frame), mtf::detail::cast_optics<S>(from.ctx.optics),
            mtf::detail::cast_value<S>(from.ctx.wavelength_um)};
  return to;
}

}  // namespace mtf::conformance
