// SPDX-License-Identifier: Apache-2.0
#pragma once

// The dimensional fields of a component that are plain numbers inside. A field holds its number in the unit that ends
// its name, and only a quantity of that dimension sets it, in any unit:
//   OptionalIn<S, micrometres> distance_um;    ...{.distance_um = 0.03_mm}    holds 30
// Lengths on the focal plane that may also be angles or pixels are Extents (mtf/frame.h).

#include <optional>

#include "mtf/quantity.h"

namespace mtf {

/// `unit` is the function that makes a quantity of a number in the unit: degrees, micrometres (mtf/quantity.h).
template <class S, auto unit>
struct NumberIn {
  using Given = decltype(unit(1.0));
  S value{};

  NumberIn() = default;
  NumberIn(const Given& quantity) : value(S(quantity / unit(1.0))) {}
};

/// The same for a number that may be left out. It is read as a std::optional.
template <class S, auto unit>
struct OptionalIn : std::optional<S> {
  using Given = decltype(unit(1.0));

  OptionalIn() = default;
  OptionalIn(std::nullopt_t) {}
  OptionalIn(const Given& quantity) : std::optional<S>(S(quantity / unit(1.0))) {}
};

}  // namespace mtf
