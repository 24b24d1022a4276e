// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the field table of a component gives: the addresses of its values with their types erased, the check of their
// bounds, and the same values in another scalar type. These functions take the types that component headers define;
// whoever has a Component<S> calls its members instead.

#include <cmath>
#include <optional>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "mtf/components/field.h"

namespace mtf::detail {

// Where a field keeps what FieldRef points to.
template <class Member>
Member* number_at(Member& field) {
  return &field;
}
template <class S, auto unit>
S* number_at(NumberIn<S, unit>& field) {
  return &field.value;
}
template <class S, auto unit>
std::optional<S>* number_at(OptionalIn<S, unit>& field) {
  return &field;
}

template <class C, class S>
std::vector<FieldRef<S>> field_refs(C& component) {
  static constexpr auto table = C::fields();
  return std::apply(
      [&](const auto&... field) {
        return std::vector<FieldRef<S>>{{&field, number_at(component.*field.member)}...};
      },
      table);
}

/// The number that a field holds: the element of a list, of rows one after the other; the weight of a curve; of a pair
/// along the axes the part, 0 x or both, 1 y. Null where there is none.
template <class S>
S* number_of(const FieldRef<S>& field, std::size_t element) {
  if (auto* const* number = std::get_if<S*>(&field.value)) return *number;
  if (auto* const* given = std::get_if<std::optional<S>*>(&field.value)) return *given && **given ? &***given : nullptr;
  if (auto* const* pair = std::get_if<AxisPair<S>*>(&field.value))
    return !(*pair)->given() ? nullptr : element == 1 ? &(*pair)->y.value : &(*pair)->x.value;
  if (auto* const* frequency = std::get_if<SpatialFrequency<S>*>(&field.value))
    return (*frequency)->unit != nullptr ? &(*frequency)->value : nullptr;
  if (auto* const* list = std::get_if<Coefficients<S>*>(&field.value))
    return element < (*list)->size() ? &(**list)[element] : nullptr;
  if (auto* const* rows = std::get_if<Taps<S>*>(&field.value)) {
    const std::size_t columns = (*rows)->empty() ? 0 : (*rows)->front().size();
    return element < (*rows)->size() * columns ? &(**rows)[element / columns][element % columns] : nullptr;
  }
  if (auto* const* sum = std::get_if<CurveSum<S>*>(&field.value))
    return element < (*sum)->weight.size() ? &(*sum)->weight[element] : nullptr;
  return nullptr;
}

/// What a component says, or what one means that does not: no cutoff, nothing to check beyond its table.
template <class S, class C>
double cutoff_of(const C& component, const Context<S>& ctx) {
  if constexpr (requires { &C::cutoff_cy_mm; })
    return component.cutoff_cy_mm(ctx);
  else
    return kInfinity;
}
template <class S, class C>
std::vector<Problem> own_check(const C& component, const Context<S>& ctx) {
  if constexpr (requires { &C::check; })
    return component.check(ctx);
  else
    return {};
}

/// What is missing or outside its bounds. A component's own check() may rely on there being nothing.
std::vector<Problem> check_fields(std::span<const FieldRef<double>> fields, const Context<double>& ctx);

/// The direction of a displacement; nothing where it has none.
template <class S>
std::optional<Freq<double>> direction_of(const Freq<S>& displacement) {
  const double x = value_of(displacement.x), y = value_of(displacement.y), length = std::hypot(x, y);
  if (!(length > 0.0) || !std::isfinite(length)) return std::nullopt;
  return Freq<double>{x / length, y / length};
}

// A value in another scalar type, one overload for each type of field.
template <class To, class From>
To cast_value(const From& from) {
  if constexpr (std::is_same_v<To, float>)
    return static_cast<float>(value_of(from));
  else
    return To(value_of(from));
}
template <class To, class From>
std::optional<To> cast_value(const std::optional<From>& from) {
  return from ? std::optional<To>(cast_value<To>(*from)) : std::nullopt;
}
template <class To, class From>
Extent<To> cast_value(const Extent<From>& from) {
  return {cast_value<To>(from.value), from.unit};
}
template <class To, class From>
AxisPair<To> cast_value(const AxisPair<From>& from) {
  return {cast_value<To>(from.x), cast_value<To>(from.y), from.split};
}
template <class To, class From>
SpatialFrequency<To> cast_value(const SpatialFrequency<From>& from) {
  return {cast_value<To>(from.value), from.unit};
}
template <class To, class From>
std::vector<To> cast_value(const std::vector<From>& from) {
  std::vector<To> to;
  for (const From& element : from) to.push_back(cast_value<To>(element));
  return to;
}
template <class To, class From>
Taps<To> cast_value(const Taps<From>& from) {
  Taps<To> to;
  for (const std::vector<From>& row : from) to.push_back(cast_value<To>(row));
  return to;
}
template <class To>
int cast_value(const int& from) {
  return from;
}
template <class To>
Choice cast_value(const Choice& from) {
  return from;
}
template <class To, class From>
CurveSum<To> cast_value(const CurveSum<From>& from) {
  CurveSum<To> to;
  to.curves = from.curves;
  to.weight = cast_value<To>(from.weight);
  return to;
}

/// `from` and `to` are the fields of components of one kind.
template <class To, class From>
void cast_fields(std::span<const FieldRef<From>> from, std::span<const FieldRef<To>> to) {
  for (std::size_t i = 0; i < from.size(); ++i)
    std::visit(
        [&](const auto* source) {
          auto value = cast_value<To>(*source);
          *std::get<decltype(value)*>(to[i].value) = std::move(value);
        },
        from[i].value);
}

template <class To, class From>
Frame<To> cast_frame(const Frame<From>& from) {
  return {cast_value<To>(from.focal_length_mm),
          cast_value<To>(from.pitch_x_um),
          cast_value<To>(from.pitch_y_um),
          cast_value<To>(from.integration_time_s),
          from.columns,
          from.rows};
}

template <class To, class From>
Optics<To> cast_optics(const Optics<From>& from) {
  return {cast_value<To>(from.f_number), cast_value<To>(from.aperture_mm), cast_value<To>(from.obscuration),
          cast_value<To>(from.wavelength_um)};
}

}  // namespace mtf::detail
