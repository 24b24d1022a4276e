// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rows of field tables that stand in no sensor file: name, unit, bounds and what it is, for checks and messages.

#include "radiometry/fields.h"

namespace radiometry {

/// From lo to hi, both allowed.
template <class Member>
constexpr Field<Member> row_between(std::string_view name, std::string_view unit, double lo, double hi,
                                    std::string_view doc, Member member) {
  return {FieldInfo{.name = name, .unit = unit, .lo = lo, .hi = hi, .doc = doc}, member};
}

/// Above 0, to hi.
template <class Member>
constexpr Field<Member> row_above_zero(std::string_view name, std::string_view unit, double hi, std::string_view doc,
                                       Member member) {
  return {FieldInfo{.name = name, .unit = unit, .lo = 0.0, .hi = hi, .lo_open = true, .doc = doc}, member};
}

}  // namespace radiometry
