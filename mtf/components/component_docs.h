// SPDX-License-Identifier: Apache-2.0
#pragma once

// The physics of every component as its header tells it: the comment that opens mtf/components/*.h, taken over when the
// library is built. Such a comment says what the component is; its formula, in lines indented by two spaces; units,
// sign and validity; and last, in parentheses, the source.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/units.h"

namespace mtf {

struct ComponentNotes {
  std::string_view kind;
  std::string_view text;  ///< lines that end in '\n'; indented ones are formulas
};

std::span<const ComponentNotes> all_component_notes();

/// The text for a kind; empty for an unknown one.
std::string_view component_notes(std::string_view kind);

/// Its formula lines alone, without indentation; those marked "kind:" when some are.
std::string component_formula(std::string_view kind);

/// Its source, without the parentheses, on one line; empty when there is none.
std::string component_source(std::string_view kind);

/// Every unit that parse_quantity() reads where that dimension is expected, "degC" among those of an absolute
/// temperature; none for plain numbers. In units.cpp.
std::vector<std::string_view> units_of(Dimension expected);

}  // namespace mtf
