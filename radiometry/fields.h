// SPDX-License-Identifier: Apache-2.0
#pragma once

// Field tables of the value types here, one row a field as for the components of a system (mtf::FieldInfo): what
// checks, messages, documentation and files go by. A type takes part with `static constexpr auto fields()`, a tuple of
// Field{FieldInfo, pointer to member}. Units that mtf/units.h has no dimension for stand in FieldInfo::unit alone.
// Members are numbers, bools, enumerations, or the names of files. The words of an enumeration, in the order of its
// values, are `words(value)`, found beside it:
//   constexpr std::span<const std::string_view> words(Rounding);

#include <array>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "mtf/components/field.h"
#include "mtf/error.h"
#include "mtf/special.h"

namespace radiometry {

using mtf::Field;
using mtf::FieldInfo;

/// Calls visit(info, value) for every field.
template <class T, class Visit>
void for_each_field(T& object, Visit visit) {
  std::apply([&](const auto&... field) { (visit(field.info, object.*field.member), ...); },
             std::remove_const_t<T>::fields());
}

/// Throws UsageError naming every field outside its bounds; `where` is the table it stands in ("camera").
template <class T>
void require_valid(const std::string& where, const T& object) {
  std::string text;
  for_each_field(object, [&](const FieldInfo& info, const auto& field) {
    using Value = std::decay_t<decltype(field)>;
    if constexpr (!std::is_same_v<Value, bool> && !std::is_enum_v<Value> && !std::is_same_v<Value, std::string>) {
      const double value = mtf::value_of(field);
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
