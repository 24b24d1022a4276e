// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bodies of Component<S>, which go through the list of types. Only the sources that instantiate a scalar type include
// this: component_double.cpp, component_float.cpp, calib/fit/component_jet.cpp. Each visit costs the compiler one
// function for every type of the list. So what no value changes is in a table, and what is asked of doubles alone is in
// component_double.cpp.

#include <memory>
#include <string>
#include <type_traits>

#include "mtf/components/all.h"
#include "mtf/components/field_access.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace mtf {
namespace detail {

template <class S>
auto visit(const ComponentVariant<S>& v, auto&& f) {
  return std::visit(f, v.value);
}

/// One type of the list: what it says of itself, and how a handle's value is made of it.
template <class S>
struct TypeRow {
  KindFacts facts;
  const std::type_info* type;
  std::shared_ptr<ComponentVariant<S>> (*make)();
  std::shared_ptr<ComponentVariant<S>> (*copy)(const void* component);
};

/// Constructed in its place: moves of a variant would be another function for every type of the list.
template <class S, class C>
std::shared_ptr<ComponentVariant<S>> held(const auto&... component) {
  return std::shared_ptr<ComponentVariant<S>>(
      new ComponentVariant<S>{decltype(ComponentVariant<S>::value)(std::in_place_type<C>, component...)});
}

template <class S, class C>
constexpr TypeRow<S> row_of() {
  constexpr bool is_pupil = requires { C::is_pupil; };
  constexpr bool is_footprint = requires { C::is_footprint; };
  constexpr bool is_reconstruction = requires { C::is_reconstruction; };
  constexpr bool is_slow = requires { C::is_slow; };
  return {.facts = {C::kind, C::doc, C::stages, is_pupil, is_footprint, is_reconstruction, is_slow},
          .type = &typeid(C),
          .make = [] { return held<S, C>(); },
          .copy = [](const void* component) { return held<S, C>(*static_cast<const C*>(component)); }};
}

template <class S, class... C>
constexpr auto rows_of(const std::variant<C...>*) {
  return std::array{row_of<S, C>()...};
}

/// The list, in the order of the variant.
template <class S>
constexpr auto kTypes = rows_of<S>(static_cast<decltype(ComponentVariant<S>::value)*>(nullptr));

/// h[i] *= otf(at(i)).
template <class S>
void multiply(const ComponentVariant<S>& value, const Context<S>& ctx, std::span<Complex<S>> h, const auto& at) {
  visit(value, [&](const auto& c) {
    if constexpr (requires { c.evaluator(ctx); }) {
      const auto otf = c.evaluator(ctx);
      for (std::size_t i = 0; i < h.size(); ++i) h[i] = h[i] * otf(at(i));
    } else {
      for (std::size_t i = 0; i < h.size(); ++i) h[i] = h[i] * c.otf(at(i), ctx);
    }
  });
}

}  // namespace detail

template <class S>
Component<S> Component<S>::make(std::string_view kind) {
  for (const auto& type : detail::kTypes<S>)
    if (type.facts.kind == kind) return Component(type.make());
  const auto kinds = component_kinds();
  const auto guess = nearest(kind, kinds);
  throw UsageError("unknown kind \"" + std::string(kind) + "\"" + (guess ? ", did you mean \"" + *guess + "\"?" : "") +
                   " (known: " + joined(kinds) + ")");
}

template <class S>
Component<S> Component<S>::copy_of(const void* component, const std::type_info& type) {
  for (const auto& row : detail::kTypes<S>)
    if (*row.type == type) return Component(row.copy(component));
  throw UsageError(std::string("a component of the type ") + type.name() +
                   " is not in the list of mtf/components/all.h; add it there");
}

template <class S>
const void* Component<S>::address_if(const std::type_info& type) const {
  return detail::visit(*value_, [&](const auto& c) -> const void* { return typeid(c) == type ? &c : nullptr; });
}

template <class S>
const KindFacts& Component<S>::facts() const {
  return detail::kTypes<S>[value_->value.index()].facts;
}
template <class S>
SensorPart Component<S>::part() const {
  return detail::visit(*value_, [](const auto& c) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(c.part)>, Choice>)
      return static_cast<SensorPart>(c.part.index);  // a field, in the order of kSensorPartNames
    else
      return c.part;
  });
}
template <class S>
Traits Component<S>::traits(const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return c.traits(ctx); });
}
template <class S>
double Component<S>::cutoff_cy_mm(const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return detail::cutoff_of(c, ctx); });
}
template <class S>
double Component<S>::deviation(double fx, double fy, const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return c.deviation(fx, fy, ctx); });
}
template <class S>
Complex<S> Component<S>::otf(const Freq<S>& f, const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return c.otf(f, ctx); });
}
template <class S>
void Component<S>::multiply(std::span<const Freq<S>> f, const Context<S>& ctx, std::span<Complex<S>> h) const {
  detail::multiply(*value_, ctx, h.first(f.size()), [&](std::size_t i) { return f[i]; });
}
template <class S>
std::vector<double> Component<S>::kinks_cy_mm(const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) -> std::vector<double> {
    if constexpr (requires { c.kinks_cy_mm(ctx); }) {
      return c.kinks_cy_mm(ctx);
    } else {
      const double cutoff = cutoff_cy_mm(ctx);
      return cutoff < kInfinity ? std::vector{cutoff} : std::vector<double>{};
    }
  });
}
template <class S>
std::vector<FieldRef<S>> Component<S>::fields() {
  if (value_.use_count() > 1) value_ = std::make_shared<ComponentVariant<S>>(*value_);
  return std::as_const(*this).fields();
}
template <class S>
std::vector<FieldRef<S>> Component<S>::fields() const {
  return std::visit([](auto& c) { return detail::field_refs<std::remove_reference_t<decltype(c)>, S>(c); },
                    value_->value);
}

}  // namespace mtf
