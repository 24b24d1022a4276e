// SPDX-License-Identifier: Apache-2.0
#pragma once

// Physical dimensions of the numbers in a study's expressions: powers of metre, second, kelvin, electron,
// kilogram and candela. Angles, pixels, cycles and photons are plain numbers (small angles: pitch / focal length is an
// angle in rad). Powers are multiples of 1/25200, which has all of two decimals, thirds and sevenths: costs go with
// aperture ^ 2.7. Values made here are rounded to them, so that equal ones are equal.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace study {

struct Dimensions {
  double metre = 0, second = 0, kelvin = 0, electron = 0, kilogram = 0, candela = 0;

  bool operator==(const Dimensions&) const = default;
  bool plain() const { return *this == Dimensions{}; }
};

/// A unit as expressions see it: value x si = value in m, s, K, e-, kg, cd, rad and their products.
struct UnitScale {
  Dimensions dimensions;
  double si = 1.0;
};

/// The scale of a unit of mtf/units.h ("um", "urad", "e-/s", "cy/mm", ...), of a metric ("%", "W") or of a
/// product of them as describe() writes it ("m s^-1"); "" is a plain number. Throws UsageError for a unit that nothing
/// has.
UnitScale unit_scale(std::string_view unit);

/// Length of the longest unit that `text` starts with and that no letter, digit or "_" goes on: "mm" of "mm / pitch",
/// "m/s" of "m/s". 0 when it starts with none. Products are not read here.
std::size_t unit_length(std::string_view text);

/// Dimensions of a product, of a quotient (power = -1), of a power. Null where a power is beyond 100, or none of those
/// multiples.
std::optional<Dimensions> product(const Dimensions& a, const Dimensions& b, int power = 1);
std::optional<Dimensions> power(const Dimensions& base, double exponent);

/// "m s^-1", for messages; "a plain number" for none.
std::string describe(const Dimensions& dimensions);

/// The unit of a value in SI: "m s^-1", "" for a plain number.
std::string si_unit(const Dimensions& dimensions);

}  // namespace study
