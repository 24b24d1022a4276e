// SPDX-License-Identifier: Apache-2.0
#include "apps/arguments.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "apps/sensor/otf_curves.h"
#include "apps/text/message_words.h"
#include "mtf/io/config/schedule.h"
#include "mtf/io/csv/csv_cells.h"

namespace apps {
namespace {

constexpr int kMaxFrequencies = 1'000'000;

[[noreturn]] void refuse(std::string_view option, std::string_view text, std::string_view expected) {
  constexpr std::size_t shown = 60;
  throw mtf::UsageError(std::string(option) + ": '" + std::string(text.substr(0, shown)) +
                        (text.size() > shown ? "..." : "") + "' is not " + std::string(expected));
}

template <class T>
std::optional<T> read_number(std::string_view text) {
  return mtf::io::cell_number<T>(mtf::trimmed(text));
}

std::optional<double> finite(std::string_view text) {
  const auto value = read_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find(separator, at);
    parts.push_back(text.substr(at, end == std::string_view::npos ? end : end - at));
    if (end == std::string_view::npos) return parts;
    at = end + 1;
  }
}

std::vector<double> finite_list(std::string_view option, std::string_view text, std::string_view expected) {
  std::vector<double> values;
  for (const std::string_view part : split(text, ',')) {
    const auto value = finite(part);
    if (!value) refuse(option, text, expected);
    values.push_back(*value);
  }
  return values;
}

}  // namespace

double number(std::string_view option, std::string_view text) {
  const auto value = finite(text);
  if (!value) refuse(option, text, "a finite number");
  return *value;
}

GivenTemperature temperature(std::string_view option, std::string_view text) {
  if (const auto value = finite(text)) return {*value, false};
  try {
    const mtf::Quantity given = mtf::parse_quantity(text, mtf::Dimension::temperature);
    if (given.unit->name == "K") return {given.value, true};
  } catch (const mtf::UsageError&) {  // refused below in the words of the option
  }
  refuse(option, text, "a temperature in K or degC, such as 288, \"288 K\" or \"15 degC\"");
}

double temperature_difference(std::string_view option, std::string_view text) {
  try {
    const mtf::Quantity given = mtf::parse_quantity(text, mtf::Dimension::temperature_difference);
    if (const double kelvin = mtf::convert(given, "K"); kelvin > 0.0) return kelvin;
  } catch (const mtf::UsageError&) {  // refused below in the words of the option
  }
  refuse(option, text, "a temperature difference above 0 with its unit, such as \"0.1 K\" or \"50 mK\"");
}

int whole_number(std::string_view option, std::string_view text, int low, int high) {
  const auto value = read_number<int>(text);
  if (!value || *value < low || *value > high)
    refuse(option, text, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return *value;
}

std::array<double, 2> number_range(std::string_view option, std::string_view text) {
  const auto parts = split(text, ':');
  const auto low = finite(parts.front()), high = finite(parts.back());
  if (parts.size() != 2 || !low || !high) refuse(option, text, "LOW:HIGH, such as 0:12.5");
  if (!(*low < *high)) refuse(option, text, "a range: LOW has to be below HIGH");
  return {*low, *high};
}

FrameRange frame_range(std::string_view option, std::string_view text) {
  const auto parts = split(text, ':');
  constexpr std::int64_t last = mtf::io::kLastFrame;
  std::vector<std::int64_t> numbers;
  for (const std::string_view part : parts)
    if (const auto value = read_number<std::int64_t>(part); value && *value >= 0 && *value <= last)
      numbers.push_back(*value);
  if (numbers.size() != parts.size() || parts.size() > 3 || (parts.size() == 1 && numbers[0] == 0))
    refuse(option, text,
           "a number of frames, START:STOP or START:STOP:STEP, whole numbers up to " + std::to_string(last));
  if (parts.size() == 1) return {0, numbers[0] - 1, 1};
  const FrameRange range{numbers[0], numbers[1], numbers.size() == 3 ? numbers[2] : 1};
  if (range.first > range.last) refuse(option, text, "a range: START has to be at most STOP");
  if (range.step < 1) refuse(option, text, "a range: STEP has to be 1 or more");
  return range;
}

std::array<int, 2> part_of(std::string_view option, std::string_view text) {
  const auto parts = split(text, '/');
  const auto part = read_number<int>(parts.front()), all = read_number<int>(parts.back());
  if (parts.size() != 2 || !part || !all || *part < 1 || *part > *all)
    refuse(option, text, "I/N, whole numbers with I from 1 to N, such as 2/8");
  return {*part, *all};
}

std::int64_t byte_count(std::string_view option, std::string_view text) {
  constexpr std::array units{std::pair{"KiB", 1024.0},
                             std::pair{"MiB", 1048576.0},
                             std::pair{"GiB", 1073741824.0},
                             std::pair{"TiB", 1099511627776.0},
                             std::pair{"KB", 1e3},
                             std::pair{"MB", 1e6},
                             std::pair{"GB", 1e9},
                             std::pair{"TB", 1e12},
                             std::pair{"B", 1.0},
                             std::pair{"", 1.0}};
  for (const auto& [unit, bytes] : units) {
    if (!text.ends_with(unit)) continue;
    const auto value = finite(text.substr(0, text.size() - std::string_view(unit).size()));
    if (!value || !(*value * bytes >= 1048576.0 && *value * bytes < 9e18)) break;
    return static_cast<std::int64_t>(*value * bytes);
  }
  refuse(option, text, "an amount of memory from 1MiB, such as 512MiB or 2GB");
}

std::array<std::int64_t, 4> rectangle(std::string_view option, std::string_view text) {
  const auto parts = split(text, ',');
  std::array<std::int64_t, 4> values{};
  bool good = parts.size() == values.size();
  for (std::size_t i = 0; good && i < values.size(); ++i) {
    const auto value = read_number<std::int64_t>(parts[i]);
    good = value && *value >= (i < 2 ? 0 : 1) && *value <= (std::int64_t{1} << 31);
    values[i] = value.value_or(0);
  }
  if (!good) refuse(option, text, "X,Y,WIDTH,HEIGHT in pixels, such as 128,64,256,256");
  return values;
}

std::vector<double> number_list(std::string_view option, std::string_view text) {
  if (std::ranges::count(text, ',') >= 1000) refuse(option, text.substr(0, 40), "short enough: at most 1000 numbers");
  return finite_list(option, text, "a comma list of finite numbers, such as 1,0.5");
}

std::array<double, 3> point(std::string_view option, std::string_view text) {
  const std::vector<double> numbers = number_list(option, text);
  if (numbers.size() != 3) throw mtf::UsageError(std::string(option) + ": write three numbers, X,Y,Z in m");
  return {numbers[0], numbers[1], numbers[2]};
}

std::vector<double> frequency_list(std::string_view option, std::string_view text) {
  if (text.find(':') != std::string_view::npos) {
    const auto parts = split(text, ':');
    if (parts.size() != 3) refuse(option, text, "START:STOP:COUNT, such as 0:60:61");
    const auto start = finite(parts[0]), stop = finite(parts[1]);
    const auto count = read_number<int>(parts[2]);
    if (!start || !stop) refuse(option, text, "START:STOP:COUNT with finite ends, such as 0:60:61");
    if (!count || *count < 1 || *count > kMaxFrequencies)
      refuse(option, text, "START:STOP:COUNT with a whole COUNT from 1 to " + std::to_string(kMaxFrequencies));
    if (*count == 1 && *start != *stop) refuse(option, text, "possible: both ends need a COUNT of at least 2");
    return evenly_spaced(*start, *stop, *count);
  }
  if (std::ranges::count(text, ',') >= kMaxFrequencies)
    refuse(option, text, "short enough: at most " + std::to_string(kMaxFrequencies) + " frequencies");
  return finite_list(option, text, "START:STOP:COUNT or a comma list of finite numbers, such as 0,10,33.3");
}

std::size_t place_of(std::string_view option, std::string_view text, std::span<const std::string_view> names) {
  const auto found = std::ranges::find(names, text);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  const auto meant = mtf::nearest(text, names);
  throw mtf::UsageError(std::string(option) + ": '" + std::string(text) + "' is not known" +
                        (meant ? "; did you mean " + *meant + "?" : "") + " (one of " +
                        joined(std::vector<std::string>(names.begin(), names.end())) + ")");
}

}  // namespace apps
