// SPDX-License-Identifier: Apache-2.0
#pragma once

// Field tables of the value types here, one row a field as for the components of a system (mtf::FieldInfo). Checks,
// messages, documentation and files are made from them. A type takes part with `static constexpr auto fields()`, a
// tuple of optional(&T::x, "x", ...) and the like. The type of the member says how it stands in a sensor file: double
// (or optional) a number with unit, int a whole number, bool, std::string the name of a file, ChannelName a text,
// NumberOrFile either, an enum one of words(Enum), which stands beside it.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "mtf/components/field.h"
#include "mtf/error.h"
#include "mtf/math/special.h"
#include "mtf/settings.h"

namespace radiometry {

using mtf::Field;
using mtf::FieldInfo;
using mtf::optional;
using mtf::optional_row;
using mtf::required;
using mtf::required_row;

/// "640 x 512", for messages.
inline std::string size_of(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// Rows of field tables that stand in no sensor file: name, unit, bounds and what it is, for checks and messages.
/// From lo to hi, both allowed.
template <class Member>
constexpr Field<Member> row_between(Member member, std::string_view name, std::string_view unit, double lo, double hi,
                                    std::string_view doc) {
  return {member, required_row(name, mtf::Dimension::none, unit, lo, hi, "", doc)};
}

/// Above 0, to hi.
template <class Member>
constexpr Field<Member> row_above_zero(Member member, std::string_view name, std::string_view unit, double hi,
                                       std::string_view doc) {
  return above(row_between(member, name, unit, 0.0, hi, doc));
}

/// A number, or the file of a curve in its place.
struct NumberOrFile {
  double number = 0.0;
  std::string file{};
};

/// The name of a plane of an image file.
struct ChannelName {
  std::string name{};
};

}  // namespace radiometry

template <>
inline constexpr mtf::FieldType mtf::kTypeOf<radiometry::NumberOrFile> = mtf::FieldType::number_or_file;
template <>
inline constexpr mtf::FieldType mtf::kTypeOf<radiometry::ChannelName> = mtf::FieldType::text;

namespace radiometry {

/// Calls visit(info, value) for every field.
template <class T, class Visit>
void for_each_field(T& object, Visit visit) {
  std::apply([&](const auto&... field) { (visit(field, object.*field.member), ...); },
             std::remove_const_t<T>::fields());
}

namespace detail {
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

template <class T>
inline constexpr bool has_bounds = !std::is_same_v<T, bool> && !std::is_enum_v<T> && !std::is_same_v<T, std::string> &&
                                   !std::is_same_v<T, ChannelName>;
template <class T>
inline constexpr bool has_bounds<std::optional<T>> = has_bounds<T>;

/// The number that has to lie in the bounds of the row, where there is one.
template <class T>
std::optional<double> bounded(const T& field) {
  if constexpr (is_optional<T>)
    return field ? std::optional<double>(mtf::value_of(*field)) : std::nullopt;
  else if constexpr (std::is_same_v<T, NumberOrFile>)
    return field.file.empty() ? std::optional<double>(field.number) : std::nullopt;
  else
    return mtf::value_of(field);
}

template <class T>
void assign(T& member, const mtf::SettingValue& value) {
  if constexpr (is_optional<T>) {
    assign(member.emplace(), value);
  } else if constexpr (std::is_enum_v<T>) {
    member = static_cast<T>(std::get<int>(value));
  } else if constexpr (std::is_same_v<T, ChannelName>) {
    member.name = std::get<std::string>(value);
  } else if constexpr (std::is_same_v<T, NumberOrFile>) {
    if (const auto* number = std::get_if<double>(&value))
      member = {.number = *number};
    else
      member.file = std::get<std::string>(value);
  } else {
    member = std::get<T>(value);
  }
}
}  // namespace detail

/// The type as a table of a sensor file.
template <class T>
mtf::TableInfo table_info(std::string_view name, std::string_view doc) {
  mtf::TableInfo table{.name = name, .doc = doc, .settings = {}};
  T prototype{};
  for_each_field(prototype, [&](const FieldInfo& info, const auto&) { table.settings.push_back(info); });
  return table;
}

/// The type with what is given in its table.
template <class T>
T from_table(const mtf::SettingsTable& table) {
  T result{};
  for_each_field(result, [&](const FieldInfo& info, auto& member) {
    if (const mtf::SettingValue* value = table.find(info.name)) detail::assign(member, *value);
  });
  return result;
}

/// Throws UsageError naming every field outside its bounds; `where` is the table it stands in ("camera").
template <class T>
void require_valid(const std::string& where, const T& object) {
  std::string text;
  for_each_field(object, [&](const FieldInfo& info, const auto& field) {
    if constexpr (detail::has_bounds<std::decay_t<decltype(field)>>) {
      const std::optional<double> given = detail::bounded(field);
      if (!given) return;
      const double value = *given;
      const bool above = info.lo_open ? value > info.lo : value >= info.lo;
      const bool below = info.hi_open ? value < info.hi : value <= info.hi;
      if (above && below) return;
      const std::string unit = info.unit.empty() ? "" : " " + std::string(info.unit);
      text += (text.empty() ? "" : "\n") + where + "." + std::string(info.name) + " = " + mtf::format_double(value) +
              unit + ": " + std::string(info.doc) + ", " + (info.lo_open ? "above " : "from ") +
              mtf::format_double(info.lo) + (info.hi_open ? " to below " : " to ") + mtf::format_double(info.hi) + unit;
    }
  });
  if (!text.empty()) throw mtf::UsageError(text);
}

}  // namespace radiometry
