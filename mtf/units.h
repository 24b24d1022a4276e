// SPDX-License-Identifier: Apache-2.0
#pragma once

// Units of configuration values. A dimensional value is written as number and unit ("15 um", "8 urad"); inside the
// toolkit every raw double carries its unit in its name. The table here is the only place with conversion factors.

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include "mtf/error.h"

namespace mtf {

enum class Dimension {
  none,       ///< plain number
  length,     ///< base um
  angle,      ///< base urad
  extent,     ///< a focal-plane length, the object angle that subtends it, or pixels: see Extent in frame.h
  frequency,  ///< spatial frequency: cy/mm, cy/mrad, cy/px (converted to each other only by Frame)
  temporal,   ///< frequency in time, base Hz
  cutoff,     ///< of electronics: a spatial frequency, or a temporal one with its Scan (frame.h)
  time,       ///< base s
  velocity,   ///< focal-plane length per second, base um/s
  rate,       ///< object angle per second, base urad/s
  pixel,      ///< base px
  luminance,  ///< base cd/m^2
  /// focal-plane length per second squared, base um/s^2
  acceleration,
  /// object angle per second squared, base urad/s^2
  angular_acceleration,
  temperature,             ///< absolute, base K; degC is read too
  temperature_difference,  ///< base K; units are those of temperature, without degC
  electrons,               ///< charge of a pixel, base e-
  current,                 ///< electrons per second, base e-/s
  capacitance,             ///< base F
  voltage,                 ///< base V
  power,                   ///< base W
  pressure,                ///< base Pa
  rain_rate                ///< depth of water per time, base mm/h
};

struct Unit {
  std::string_view name;
  Dimension dimension;
  double factor;  ///< value in this unit x factor = value in the base unit of the dimension
};

inline constexpr double kDegree_urad = std::numbers::pi / 180.0 * 1e6;
inline constexpr double kAmpere_e_s = 1.0 / 1.602176634e-19;  // exact in the SI

inline constexpr std::array kAllUnits{
    Unit{"nm", Dimension::length, 1e-3},
    Unit{"um", Dimension::length, 1.0},
    Unit{"mm", Dimension::length, 1e3},
    Unit{"cm", Dimension::length, 1e4},
    Unit{"m", Dimension::length, 1e6},
    Unit{"km", Dimension::length, 1e9},
    Unit{"in", Dimension::length, 25400.0},
    Unit{"nrad", Dimension::angle, 1e-3},
    Unit{"urad", Dimension::angle, 1.0},
    Unit{"mrad", Dimension::angle, 1e3},
    Unit{"rad", Dimension::angle, 1e6},
    Unit{"deg", Dimension::angle, kDegree_urad},
    Unit{"arcmin", Dimension::angle, kDegree_urad / 60.0},
    Unit{"arcsec", Dimension::angle, kDegree_urad / 3600.0},
    Unit{"px", Dimension::pixel, 1.0},
    Unit{"cy/mm", Dimension::frequency, 1.0},
    Unit{"cy/mrad", Dimension::frequency, 1.0},
    Unit{"cy/px", Dimension::frequency, 1.0},
    Unit{"Hz", Dimension::temporal, 1.0},
    Unit{"kHz", Dimension::temporal, 1e3},
    Unit{"MHz", Dimension::temporal, 1e6},
    Unit{"GHz", Dimension::temporal, 1e9},
    Unit{"ns", Dimension::time, 1e-9},
    Unit{"us", Dimension::time, 1e-6},
    Unit{"ms", Dimension::time, 1e-3},
    Unit{"s", Dimension::time, 1.0},
    Unit{"um/s", Dimension::velocity, 1.0},
    Unit{"mm/s", Dimension::velocity, 1e3},
    Unit{"m/s", Dimension::velocity, 1e6},
    Unit{"urad/s", Dimension::rate, 1.0},
    Unit{"mrad/s", Dimension::rate, 1e3},
    Unit{"rad/s", Dimension::rate, 1e6},
    Unit{"deg/s", Dimension::rate, kDegree_urad},
    Unit{"cd/m^2", Dimension::luminance, 1.0},
    Unit{"fL", Dimension::luminance, 1.0 / (std::numbers::pi * 0.3048 * 0.3048)},
    Unit{"um/s^2", Dimension::acceleration, 1.0},
    Unit{"mm/s^2", Dimension::acceleration, 1e3},
    Unit{"m/s^2", Dimension::acceleration, 1e6},
    Unit{"urad/s^2", Dimension::angular_acceleration, 1.0},
    Unit{"mrad/s^2", Dimension::angular_acceleration, 1e3},
    Unit{"rad/s^2", Dimension::angular_acceleration, 1e6},
    Unit{"deg/s^2", Dimension::angular_acceleration, kDegree_urad},
    Unit{"mK", Dimension::temperature, 1e-3},
    Unit{"K", Dimension::temperature, 1.0},
    Unit{"e-", Dimension::electrons, 1.0},
    Unit{"ke-", Dimension::electrons, 1e3},
    Unit{"Me-", Dimension::electrons, 1e6},
    Unit{"e-/s", Dimension::current, 1.0},
    Unit{"ke-/s", Dimension::current, 1e3},
    Unit{"Me-/s", Dimension::current, 1e6},
    Unit{"aA", Dimension::current, kAmpere_e_s * 1e-18},
    Unit{"fA", Dimension::current, kAmpere_e_s * 1e-15},
    Unit{"pA", Dimension::current, kAmpere_e_s * 1e-12},
    Unit{"nA", Dimension::current, kAmpere_e_s * 1e-9},
    Unit{"fF", Dimension::capacitance, 1e-15},
    Unit{"pF", Dimension::capacitance, 1e-12},
    Unit{"F", Dimension::capacitance, 1.0},
    Unit{"nV", Dimension::voltage, 1e-9},
    Unit{"uV", Dimension::voltage, 1e-6},
    Unit{"mV", Dimension::voltage, 1e-3},
    Unit{"V", Dimension::voltage, 1.0},
    Unit{"fW", Dimension::power, 1e-15},
    Unit{"pW", Dimension::power, 1e-12},
    Unit{"nW", Dimension::power, 1e-9},
    Unit{"W", Dimension::power, 1.0},
    Unit{"Pa", Dimension::pressure, 1.0},
    Unit{"hPa", Dimension::pressure, 1e2},
    Unit{"mbar", Dimension::pressure, 1e2},
    Unit{"kPa", Dimension::pressure, 1e3},
    Unit{"mm/h", Dimension::rain_rate, 1.0},
};

/// That of a unit, `none` of "".
constexpr Dimension dimension_of(std::string_view unit) {
  for (const Unit& known : kAllUnits)
    if (known.name == unit) return known.dimension;
  return unit.empty() ? Dimension::none : throw UsageError("unknown unit " + std::string(unit));
}

/// The unit of that exact name, or null. Case matters (mrad, Mrad); "µm" and "μm" are read as "um".
const Unit* find_unit(std::string_view name);

struct Quantity {
  double value = 0.0;
  const Unit* unit = nullptr;
};

/// 0 degC, by definition of the degree Celsius.
inline constexpr double kZeroCelsius_k = 273.15;

/// Reads "15 um" or "15um"; a temperature in degC becomes one in K. Throws UsageError for a missing or unknown unit
/// (nearest names offered), trailing text, or a number that is not finite. `expected` says which units fit.
Quantity parse_quantity(std::string_view text, Dimension expected);

/// Value of `quantity` in the unit called `target`. Both have to be of one dimension (assert).
double convert(const Quantity& quantity, std::string_view target);

/// Shortest decimal form that reads back as the same double.
std::string format_double(double value);
/// Three digits, for messages.
std::string three_digits(double value);
/// "15 um"; a plain number, whose unit is empty, stays as it is.
std::string with_unit(std::string number, std::string_view unit);

/// "a length such as \"15 um\"": what a value of this dimension looks like, for messages.
std::string_view describe(Dimension dimension);

/// The candidate closest to `word` by edit distance, when it is close enough to be what was meant.
template <class Range>
std::optional<std::string> nearest(std::string_view word, const Range& candidates);

/// Number of single-character insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`;
/// only their first 64 characters count.
int edit_distance(std::string_view a, std::string_view b);

template <class Range>
std::optional<std::string> nearest(std::string_view word, const Range& candidates) {
  std::optional<std::string> best;
  int best_distance = 1 + static_cast<int>(word.size()) / 3;
  for (const auto& candidate : candidates) {
    const int distance = edit_distance(word, candidate);
    if (distance > best_distance || (best && distance == best_distance)) continue;
    best = std::string(candidate);
    best_distance = distance;
  }
  return best;
}

}  // namespace mtf
