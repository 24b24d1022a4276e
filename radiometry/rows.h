// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rows of field tables that stand in no sensor file: name, unit, bounds and what it is, for checks and messages.

#include "radiometry/fields.h"

namespace radiometry {

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

}  // namespace radiometry
