// SPDX-License-Identifier: Apache-2.0
#include "mtf/units.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include "mtf/components/component_docs.h"
#include "mtf/error.h"
#include "mtf/quantity.h"
#include "mtf/words.h"

namespace mtf {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0 * 1e6;  // urad
constexpr double kAmpere = 1.0 / 1.602176634e-19;           // electrons per second (exact in the SI)

constexpr std::array kUnits{
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
    Unit{"deg", Dimension::angle, kDegree},
    Unit{"arcmin", Dimension::angle, kDegree / 60.0},
    Unit{"arcsec", Dimension::angle, kDegree / 3600.0},
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
    Unit{"deg/s", Dimension::rate, kDegree},
    Unit{"cd/m^2", Dimension::luminance, 1.0},
    Unit{"fL", Dimension::luminance, 1.0 / (std::numbers::pi * 0.3048 * 0.3048)},
    Unit{"um/s^2", Dimension::acceleration, 1.0},
    Unit{"mm/s^2", Dimension::acceleration, 1e3},
    Unit{"m/s^2", Dimension::acceleration, 1e6},
    Unit{"urad/s^2", Dimension::angular_acceleration, 1.0},
    Unit{"mrad/s^2", Dimension::angular_acceleration, 1e3},
    Unit{"rad/s^2", Dimension::angular_acceleration, 1e6},
    Unit{"deg/s^2", Dimension::angular_acceleration, kDegree},
    Unit{"mK", Dimension::temperature, 1e-3},
    Unit{"K", Dimension::temperature, 1.0},
    Unit{"e-", Dimension::electrons, 1.0},
    Unit{"ke-", Dimension::electrons, 1e3},
    Unit{"Me-", Dimension::electrons, 1e6},
    Unit{"e-/s", Dimension::current, 1.0},
    Unit{"ke-/s", Dimension::current, 1e3},
    Unit{"Me-/s", Dimension::current, 1e6},
    Unit{"aA", Dimension::current, kAmpere * 1e-18},
    Unit{"fA", Dimension::current, kAmpere * 1e-15},
    Unit{"pA", Dimension::current, kAmpere * 1e-12},
    Unit{"nA", Dimension::current, kAmpere * 1e-9},
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
  const auto found = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.name == ascii; });
  return found == kUnits.end() ? nullptr : &*found;
}

std::vector<std::string_view> units_of(Dimension expected) {
  std::vector<std::string_view> names;
  for (const Unit& unit : kUnits)
    if (accepts(expected, unit.dimension)) names.push_back(unit.name);
  if (expected == Dimension::temperature) names.push_back("degC");
  return names;
}

Quantity parse_quantity(std::string_view text, Dimension expected) {
  const std::string_view whole = text;
  const auto fail = [&](const std::string& why) -> UsageError {
    return UsageError(in_quotes(whole) + ": " + why + "; expected " + std::string(describe(expected)));
  };
  const auto skip_blanks = [&] {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  };
  skip_blanks();
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Quantity result;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), result.value);
  if (status == std::errc::result_out_of_range) throw fail("number out of range");
  if (status != std::errc{}) throw fail("no number");
  if (!std::isfinite(result.value)) throw fail("number is not finite");
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  skip_blanks();
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
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
  switch (dimension) {
    case Dimension::none:
      return "a plain number";
    case Dimension::length:
      return "a length such as \"15 um\"";
    case Dimension::angle:
      return "an angle such as \"30 deg\"";
    case Dimension::extent:
      return "a focal-plane length, an angle or pixels, such as \"2 um\", \"8 urad\" or \"0.5 px\"";
    case Dimension::frequency:
      return "a spatial frequency such as \"40 cy/mm\", \"1.5 cy/mrad\" or \"0.6 cy/px\"";
    case Dimension::temporal:
      return "a frequency in time such as \"25 kHz\"";
    case Dimension::cutoff:
      return "a spatial frequency such as \"40 cy/mm\" or \"0.6 cy/px\", or a frequency in time such as \"25 kHz\"";
    case Dimension::time:
      return "a time such as \"10 ms\"";
    case Dimension::velocity:
      return "an image velocity such as \"2 mm/s\"";
    case Dimension::rate:
      return "an angular rate such as \"20 mrad/s\"";
    case Dimension::acceleration:
      return "an image acceleration such as \"60 mm/s^2\"";
    case Dimension::angular_acceleration:
      return "an angular acceleration such as \"600 mrad/s^2\"";
    case Dimension::pixel:
      return "pixels such as \"0.5 px\"";
    case Dimension::luminance:
      return "a luminance such as \"100 cd/m^2\"";
    case Dimension::temperature_difference:
      return "a temperature difference such as \"2 K\"";
    case Dimension::temperature:
      return "an absolute temperature such as \"300 K\" or \"27 degC\"";
    case Dimension::electrons:
      return "a charge such as \"50 e-\" or \"7 Me-\"";
    case Dimension::current:
      return "a current such as \"1e5 e-/s\" or \"16 fA\"";
    case Dimension::capacitance:
      return "a capacitance such as \"100 fF\"";
    case Dimension::voltage:
      return "a voltage such as \"2 mV\"";
    case Dimension::power:
      return "a power such as \"20 pW\"";
    case Dimension::pressure:
      return "a pressure such as \"1013 hPa\"";
    case Dimension::rain_rate:
      return "a rain rate such as \"5 mm/h\"";
  }
  return "";
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
