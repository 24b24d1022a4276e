// SPDX-License-Identifier: Apache-2.0
#pragma once

// Units of heat as scene files and weather tables write them, as products of powers: "W/m2/K", "W/(m K)", "kJ/kg/K",
// "kg m^-3", "W/m^2", "hPa", "min", "deg", "%". Symbols: m km cm mm um, kg g t, s min h d, K mK, J kJ MJ, W kW mW,
// Pa hPa kPa mbar bar, rad deg, %, and km/h by rule; "*", "." and blanks multiply, "/" divides by what follows it. degC
// is read where it stands alone and a temperature is meant.

#include <array>
#include <optional>
#include <string_view>

namespace apps::scene {

/// A unit: value in it x factor (+ offset) = value in SI.
struct SiUnit {
  double factor = 1.0;
  double offset = 0.0;          ///< of degC alone
  std::array<int, 4> powers{};  ///< of m, kg, s, K; all 0 for plain numbers and angles
  bool operator==(const SiUnit&) const = default;
};

/// Null for what is no unit.
std::optional<SiUnit> parse_unit(std::string_view text);

bool same_dimension(const SiUnit& a, const SiUnit& b);

/// "45 W/m/K" as a number in `in_unit` ("W/m/K", "deg"; "" for plain numbers and percentages). Throws UsageError for a
/// missing unit, one that is unknown or of another dimension, trailing text, a number that is not finite; `example`
/// ("45 W/m/K") says what is expected.
double parse_si(std::string_view text, std::string_view in_unit, std::string_view example);

}  // namespace apps::scene
