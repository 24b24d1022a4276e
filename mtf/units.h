// SPDX-License-Identifier: Apache-2.0
#pragma once

// Units of configuration values. A dimensional value is written as number and unit ("15 um", "8 urad"); inside the
// toolkit every raw double carries its unit in its name. The table in units.cpp is the only place with conversion
// factors.

#include <optional>
#include <string>
#include <string_view>

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
