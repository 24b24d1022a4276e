// SPDX-License-Identifier: Apache-2.0
#pragma once

// Physical dimensions of the numbers in a study's expressions: powers of metre, second, kelvin and electron. Angles,
// pixels and cycles are plain numbers (small angles: pitch / focal length is an angle in rad).

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace study {

struct Dimensions {
  std::int8_t metre = 0, second = 0, kelvin = 0, electron = 0;

  bool operator==(const Dimensions&) const = default;
  bool plain() const { return *this == Dimensions{}; }
};

/// A unit as expressions see it: value x si = value in m, s, K, e-, rad and their products.
struct UnitScale {
  Dimensions dimensions;
  double si = 1.0;
};

/// The scale of a unit of mtf/units.h ("um", "urad", "e-/s", "cy/mm", ...) or of a metric ("mK", "m", "%"); "" is a
/// plain number. Throws UsageError for a unit that nothing has.
UnitScale unit_scale(std::string_view unit);

/// "m s^-1", for messages; "a plain number" for none.
std::string describe(const Dimensions& dimensions);

}  // namespace study
