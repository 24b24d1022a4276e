// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the field table of a component gives: the addresses of its values with their types erased, the check of their
// bounds, and the same values in another scalar type. These functions take the types that component headers define;
// whoever has a Component<S> calls its members instead.

#include <span>
#include <string>
#include <tuple>
#include <type_traits>
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
  std::vector<FieldRef<S>> refs;
  refs.reserve(std::tuple_size_v<std::remove_const_t<decltype(table)>>);
  std::apply(
      [&](const auto&... field) {
        (refs.push_back({&field.info, number_at(component.*field.member)}), ...);
      },
      table);
  return refs;
}

/// Text of an allowed interval: "[0, 1)", with the unit.
std::string range_text(const FieldInfo& info);
bool in_range(const FieldInfo& info, double value);

template <class S>
void check_field(const FieldRef<S>& field, const Context<S>& ctx, std::vector<Problem>& problems) {
  const FieldInfo& info = *field.info;
  const auto missing = [&] { problems.push_back({.field = std::string(info.name), .text = "missing"}); };
  const auto bounded = [&](std::string_view suffix, double value, std::string_view unit) {
    if (in_range(info, value)) return;
    problems.push_back({.field = std::string(info.name) + std::string(suffix),
                        .text = format_double(value) + (unit.empty() ? "" : " ") + std::string(unit) + " is outside " +
                                range_text(info)});
  };
  std::visit(
      [&](auto* value) {
        using T = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<T, S>) {
          bounded("", value_of(*value), info.unit);
        } else if constexpr (std::is_same_v<T, std::optional<S>>) {
          if (*value)
            bounded("", value_of(**value), info.unit);
          else if (info.presence == Presence::required)
            missing();
        } else if constexpr (std::is_same_v<T, AxisPair<S>>) {
          if (value->given()) {
            bounded(value->split ? "_x" : "", value_of(value->x.value), value->x.unit->name);
            if (value->split) bounded("_y", value_of(value->y.value), value->y.unit->name);
          } else if (info.presence == Presence::required) {
            missing();
          }
        } else if constexpr (std::is_same_v<T, SpatialFrequency<S>>) {
          if (value->temporal() && info.dimension != Dimension::cutoff)
            problems.push_back({.field = std::string(info.name),
                                .text = "in " + std::string(value->unit->name) + "; it takes " +
                                        std::string(describe(info.dimension))});
          else if (value->unit != nullptr)
            bounded("", value_of(value->value), value->unit->name);
          else if (info.presence == Presence::required)
            missing();
        } else if constexpr (std::is_same_v<T, int>) {
          bounded("", *value, "");
        } else if constexpr (std::is_same_v<T, Coefficients<S>>) {
          for (std::size_t i = 0; i < value->size(); ++i)
            bounded("[" + std::to_string(i) + "]", value_of((*value)[i]), info.unit);
        } else if constexpr (std::is_same_v<T, Taps<S>>) {
          for (const auto& row : *value)
            for (const S& tap : row) bounded("", value_of(tap), "");
        }
      },
      field.value);
  // Shared fields: f_number and wavelength have to come from somewhere; obscuration is 0 unless given.
  const auto* own = std::get_if<std::optional<S>*>(&field.value);
  if (info.presence != Presence::shared || own == nullptr || (*own)->has_value()) return;
  const bool found = info.name == "f_number"     ? ctx.optics.f_number || ctx.optics.aperture_mm
                     : info.name == "wavelength" ? value_of(ctx.wavelength_um) > 0.0
                                                 : true;
  if (!found)
    problems.push_back({.field = std::string(info.name),
                        .text = "missing; give it here, or for all components in [optics]" +
                                std::string(info.name == "wavelength" ? " or as [band] wavelength" : "")});
}

template <class To, class From>
To cast_scalar(const From& from) {
  if constexpr (std::is_same_v<To, float>)
    return static_cast<float>(value_of(from));
  else
    return To(value_of(from));
}

template <class To, class From>
std::optional<To> cast_optional(const std::optional<From>& from) {
  return from ? std::optional<To>(cast_scalar<To>(*from)) : std::nullopt;
}

// One overload a field type; pairs of different types never meet, because both components have the same table.
template <class To, class From>
struct CastField {
  void operator()(const From& from, To& to) const { to = cast_scalar<To>(from); }
  void operator()(const std::optional<From>& from, std::optional<To>& to) const { to = cast_optional<To>(from); }
  void operator()(const Extent<From>& from, Extent<To>& to) const { to = {cast_scalar<To>(from.value), from.unit}; }
  void operator()(const AxisPair<From>& from, AxisPair<To>& to) const {
    (*this)(from.x, to.x);
    (*this)(from.y, to.y);
    to.split = from.split;
  }
  void operator()(const SpatialFrequency<From>& from, SpatialFrequency<To>& to) const {
    to = {cast_scalar<To>(from.value), from.unit};
  }
  void operator()(const Coefficients<From>& from, Coefficients<To>& to) const {
    to.clear();
    for (const From& coefficient : from) to.push_back(cast_scalar<To>(coefficient));
  }
  void operator()(const Taps<From>& from, Taps<To>& to) const {
    to.resize(from.size());
    for (std::size_t row = 0; row < from.size(); ++row) (*this)(from[row], to[row]);
  }
  void operator()(const int& from, int& to) const { to = from; }
  void operator()(const Choice& from, Choice& to) const { to = from; }
  void operator()(const std::shared_ptr<const Curve>& from, std::shared_ptr<const Curve>& to) const { to = from; }
  template <class A, class B>
  void operator()(const A&, B&) const {}
};

/// `from` and `to` are the fields of components of one kind.
template <class To, class From>
void cast_fields(std::span<const FieldRef<From>> from, std::span<const FieldRef<To>> to) {
  for (std::size_t i = 0; i < from.size(); ++i)
    std::visit([](const auto* source, auto* target) { CastField<To, From>{}(*source, *target); }, from[i].value,
               to[i].value);
}

template <class To, class From>
Frame<To> cast_frame(const Frame<From>& from) {
  return {cast_scalar<To>(from.focal_length_mm),
          cast_scalar<To>(from.pitch_x_um),
          cast_scalar<To>(from.pitch_y_um),
          cast_scalar<To>(from.integration_time_s),
          from.columns,
          from.rows};
}

template <class To, class From>
Optics<To> cast_optics(const Optics<From>& from) {
  return {cast_optional<To>(from.f_number), cast_optional<To>(from.aperture_mm), cast_optional<To>(from.obscuration),
          cast_optional<To>(from.wavelength_um)};
}

}  // namespace mtf::detail
