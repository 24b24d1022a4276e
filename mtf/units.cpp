// SPDX-License-Identifier: Apache-2.0
#include "mtf/units.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <vector>

#include "mtf/components/component_docs.h"
#include "mtf/quantity.h"
#include "mtf/words.h"

namespace mtf {
namespace {

std::string ascii_micro(std::string_view name) {
  for (const std::string_view micro : {"\xC2\xB5", "\xCE\xBC"})  // MICRO SIGN, GREEK SMALL LETTER MU
    if (name.starts_with(micro)) return "u" + std::string(name.substr(micro.size()));
  return std::string(name);
}

bool accepts(Dimension expected, Dimension given) {
  if (expected == Dimension::temperature_difference) return given == Dimension::temperature;
  if (expected == Dimension::extent)
    return given == Dimension::length || given == Dimension::angle || given == Dimension::pixel;
  if (expected == Dimension::cutoff) return given == Dimension::frequency || given == Dimension::temporal;
  return expected == given;
}

std::string in_quotes(std::string_view text) { return "\"" + std::string(text) + "\""; }

}  // namespace

const Unit* find_unit(std::string_view name) {
  const std::string ascii = ascii_micro(name);
  const auto found = std::find_if(kAllUnits.begin(), kAllUnits.end(), [&](const Unit& u) { return u.name == ascii; });
  return found == kAllUnits.end() ? nullptr : &*found;
}

std::vector<std::string_view> units_of(Dimension expected) {
  std::vector<std::string_view> names;
  for (const Unit& unit : kAllUnits)
    if (accepts(expected, unit.dimension)) names.push_back(unit.name);
  if (expected == Dimension::temperature) names.push_back("degC");
  return names;
}

Quantity parse_quantity(std::string_view text, Dimension expected) {
  const std::string_view whole = text;
  const auto fail = [&](const std::string& why) -> UsageError {
    return UsageError(in_quotes(whole) + ": " + why + "; expected " + std::string(describe(expected)));
  };
  text = trimmed(text);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Quantity result;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), result.value);
  if (status == std::errc::result_out_of_range) throw fail("number out of range");
  if (status != std::errc{}) throw fail("no number");
  if (!std::isfinite(result.value)) throw fail("number is not finite");
  text = trimmed(text.substr(static_cast<std::size_t>(end - text.data())));
  if (text.empty()) throw fail("no unit");
  // The one unit with an offset becomes kelvin here; all others are factors.
  if (text == "degC" || text == "\u00b0C") {
    if (expected == Dimension::temperature_difference) throw fail("degC has an offset, a difference has none");
    if (expected == Dimension::temperature) {
      result.value += kZeroCelsius_k;
      text = "K";
    }
  }
  result.unit = find_unit(text);
  if (result.unit == nullptr) {
    // Units are short: where half of the letters differ, as of "kg" and "km", another one may have been meant.
    auto guess = nearest(text, units_of(expected));
    if (guess && (text.size() < 3 || 2 * edit_distance(text, *guess) > static_cast<int>(text.size()))) guess.reset();
    throw fail("unknown unit " + in_quotes(text) + (guess ? ", did you mean " + in_quotes(*guess) + "?" : ""));
  }
  if (!accepts(expected, result.unit->dimension)) throw fail("unit " + in_quotes(text) + " does not fit");
  return result;
}

Quantity quantity_of(double value, std::string_view unit, Dimension dimension) {
  const Unit* found = find_unit(unit);
  if (found == nullptr || found->dimension != dimension)
    throw UsageError(in_quotes(unit) + " is no unit here; expected " + std::string(describe(dimension)));
  return {value, found};
}

double convert(const Quantity& quantity, std::string_view target) {
  const Unit* to = find_unit(target);
  assert(to != nullptr && quantity.unit != nullptr && to->dimension == quantity.unit->dimension);
  if (to == quantity.unit) return quantity.value;
  const double from_factor = quantity.unit->factor;
  // A quotient of powers of ten is exact where their product with a small factor is not.
  return to->factor > from_factor ? quantity.value / (to->factor / from_factor)
                                  : quantity.value * (from_factor / to->factor);
}

std::string format_double(double value) {
  std::array<char, 32> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string three_digits(double value) { return significant(value, 3); }

std::string with_unit(std::string number, std::string_view unit) {
  if (!unit.empty()) number.append(" ").append(unit);
  return number;
}

std::string_view describe(Dimension dimension) {
  constexpr std::array kDescriptions{
      "a plain number",
      "a length such as \"15 um\"",
      "an angle such as \"30 deg\"",
      "a focal-plane length, an angle or pixels, such as \"2 um\", \"8 urad\" or \"0.5 px\"",
      "a spatial frequency such as \"40 cy/mm\", \"1.5 cy/mrad\" or \"0.6 cy/px\"",
      "a frequency in time such as \"25 kHz\"",
      "a spatial frequency such as \"40 cy/mm\" or \"0.6 cy/px\", or a frequency in time such as \"25 kHz\"",
      "a time such as \"10 ms\"",
      "an image velocity such as \"2 mm/s\"",
      "an angular rate such as \"20 mrad/s\"",
      "pixels such as \"0.5 px\"",
      "a luminance such as \"100 cd/m^2\"",
      "an image acceleration such as \"60 mm/s^2\"",
      "an angular acceleration such as \"600 mrad/s^2\"",
      "an absolute temperature such as \"300 K\" or \"27 degC\"",
      "a temperature difference such as \"2 K\"",
      "a charge such as \"50 e-\" or \"7 Me-\"",
      "a current such as \"1e5 e-/s\" or \"16 fA\"",
      "a capacitance such as \"100 fF\"",
      "a voltage such as \"2 mV\"",
      "a power such as \"20 pW\"",
      "a pressure such as \"1013 hPa\"",
      "a rain rate such as \"5 mm/h\"",
  };
  static_assert(kDescriptions.size() == static_cast<std::size_t>(Dimension::rain_rate) + 1);
  return kDescriptions[static_cast<std::size_t>(dimension)];
}

int edit_distance(std::string_view a, std::string_view b) {
  constexpr std::size_t kLongest = 64;  // nobody means a known word with more; the table grows with the product
  a = a.substr(0, kLongest);
  b = b.substr(0, kLongest);
  std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = static_cast<int>(i);
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replace = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace mtf
