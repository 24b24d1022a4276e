// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/csv/air_profile_csv.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/units.h"

namespace mtf::io {
namespace {

constexpr std::size_t kMostRows = 10'000;
const std::string kRemedy =
    "write the first line like this: altitude_m,pressure_hpa,temperature_k,relative_humidity_percent";

/// A column name with its unit: value in SI = factor x value + offset.
struct Known {
  std::string_view name;
  double factor = 1.0, offset = 0.0;
};
constexpr std::array kAltitudes{Known{"altitude_m"}, Known{"altitude_km", 1e3}};
constexpr std::array kPressures{Known{"pressure_pa"}, Known{"pressure_hpa", 1e2}};
constexpr std::array kTemperatures{Known{"temperature_k"}, Known{"temperature_degc", 1.0, kZeroCelsius_k}};
constexpr std::array kHumidities{Known{"relative_humidity"}, Known{"relative_humidity_percent", 1e-2}};

/// Which columns of the file were chosen, in the order in which they are read.
struct Chosen {
  std::vector<std::size_t> columns;
  Known altitude, pressure, temperature;
  std::optional<Known> humidity;
  std::vector<std::size_t> gases;  ///< indices into kProfileGases
};

std::optional<std::size_t> column_called(const std::vector<std::string_view>& cells, std::string_view name,
                                         const std::string& where) {
  const auto first = std::find(cells.begin(), cells.end(), name);
  if (first == cells.end()) return std::nullopt;
  if (std::find(first + 1, cells.end(), name) != cells.end())
    throw UsageError(where + "two columns are called " + std::string(name) + "; leave one");
  return static_cast<std::size_t>(first - cells.begin());
}

template <std::size_t N>
std::optional<Known> choose_one(const std::vector<std::string_view>& cells, const std::array<Known, N>& names,
                                const std::string& where, std::vector<std::size_t>& columns) {
  std::optional<Known> found;
  for (const Known& known : names) {
    const auto column = column_called(cells, known.name, where);
    if (!column) continue;
    if (found)
      throw UsageError(where + "both " + std::string(found->name) + " and " + std::string(known.name) +
                       " are columns; leave one");
    found = known;
    columns.push_back(*column);
  }
  return found;
}

template <std::size_t N>
Known choose_needed(const std::vector<std::string_view>& cells, const std::array<Known, N>& names,
                    const std::string& where, std::vector<std::size_t>& columns) {
  if (const auto found = choose_one(cells, names, where, columns)) return *found;
  throw UsageError(where + "no column is called " + std::string(names[0].name) + " or " + std::string(names[1].name) +
                   "; " + kRemedy);
}

Chosen choose(const std::vector<std::string_view>& cells, const std::string& where) {
  Chosen chosen;
  chosen.altitude = choose_needed(cells, kAltitudes, where, chosen.columns);
  chosen.pressure = choose_needed(cells, kPressures, where, chosen.columns);
  chosen.temperature = choose_needed(cells, kTemperatures, where, chosen.columns);
  chosen.humidity = choose_one(cells, kHumidities, where, chosen.columns);
  for (std::size_t gas = 0; gas < kProfileGases.size(); ++gas) {
    const auto column = column_called(cells, std::string(kProfileGases[gas]) + "_ppmv", where);
    if (!column) continue;
    if (gas == 0 && chosen.humidity)
      throw UsageError(where + "both " + std::string(chosen.humidity->name) + " and h2o_ppmv are columns; leave one");
    chosen.gases.push_back(gas);
    chosen.columns.push_back(*column);
  }
  if (!chosen.humidity && (chosen.gases.empty() || chosen.gases.front() != 0))
    throw UsageError(where + "no column is called relative_humidity, relative_humidity_percent or h2o_ppmv; " +
                     kRemedy);
  return chosen;
}

/// What a value of another unit looks like.
std::string unit_problem(double altitude_m, double pressure_pa, double temperature_k) {
  if (!(pressure_pa > 0.0)) return "a pressure of " + format_double(pressure_pa) + " Pa; it has to be above 0";
  // Nowhere on Earth is the pressure below 60 kPa / e^(h / 6 km), 200 hPa at 6.5 km, or above 120 kPa.
  if (pressure_pa > 120e3 || (altitude_m < 10e3 && pressure_pa < 60e3 * std::exp(-altitude_m / 6e3)))
    return "a pressure of " + format_double(pressure_pa) + " Pa at " + format_double(altitude_m) +
           " m; is it in the unit that the column names?";
  if (!(temperature_k >= 120.0 && temperature_k <= 1000.0))
    return "a temperature of " + format_double(temperature_k) + " K; is it in the unit that the column names?";
  return "";
}

}  // namespace

AirProfileColumns parse_air_profile_csv(std::string_view text, const std::string& source) {
  Chosen chosen;
  const CsvNumbers numbers = read_csv_numbers(text, source, kRemedy, [&](const auto& cells, const std::string& where) {
    chosen = choose(cells, where);
    return chosen.columns;
  });
  if (numbers.line.size() > kMostRows)
    throw UsageError(source + ": " + std::to_string(numbers.line.size()) + " heights; at most " +
                     std::to_string(kMostRows) + " are taken");
  AirProfileColumns result;
  result.source = source;
  for (std::size_t row = 0; row < numbers.line.size(); ++row) {
    const std::string where = source + ":" + std::to_string(numbers.line[row]) + ": ";
    const auto si = [&](std::size_t column, const Known& known) {
      return numbers.column[column][row] * known.factor + known.offset;
    };
    const double altitude_m = si(0, chosen.altitude), pressure_pa = si(1, chosen.pressure),
                 temperature_k = si(2, chosen.temperature);
    if (row > 0 && !(altitude_m > result.altitude_m.back()))
      throw UsageError(where + "a height of " + format_double(altitude_m) + " m after " +
                       format_double(result.altitude_m.back()) + " m; sort the rows by rising height");
    if (const std::string problem = unit_problem(altitude_m, pressure_pa, temperature_k); !problem.empty())
      throw UsageError(where + problem);
    if (row > 0 && !(pressure_pa < result.pressure_pa.back()))
      throw UsageError(where + "a pressure of " + format_double(pressure_pa) + " Pa above one of " +
                       format_double(result.pressure_pa.back()) + " Pa; pressure falls with height");
    result.altitude_m.push_back(altitude_m);
    result.pressure_pa.push_back(pressure_pa);
    result.temperature_k.push_back(temperature_k);
    std::size_t column = 3;
    if (chosen.humidity) {
      const double humidity = si(column++, *chosen.humidity);
      if (!(humidity >= 0.0 && humidity <= 1.0))
        throw UsageError(
            where + "a relative humidity of " + format_double(100.0 * humidity) + " %; it is from 0 to 100 %" +
            (chosen.humidity->factor == 1.0 ? " (call the column relative_humidity_percent if it is in percent)" : ""));
      result.relative_humidity.push_back(humidity);
    }
    for (const std::size_t gas : chosen.gases) {
      const double ppmv = numbers.column[column++][row];
      if (!(ppmv >= 0.0 && ppmv <= 1e6))
        throw UsageError(where + std::string(kProfileGases[gas]) + "_ppmv " + format_double(ppmv) +
                         "; it is from 0 to 1e6");
      result.mixing_ratio[gas].push_back(ppmv);
    }
  }
  return result;
}

AirProfileColumns read_air_profile_csv(const std::string& path) {
  return parse_air_profile_csv(read_table_text(path), path);
}

}  // namespace mtf::io
