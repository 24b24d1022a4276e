// SPDX-License-Identifier: Apache-2.0
#pragma once

// Words of the command line as values. Every function throws UsageError that names the option, what it got and what it
// takes.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/options.h"
#include "mtf/error.h"
#include "mtf/units.h"

namespace apps {

/// A finite number, whatever the locale.
double number(std::string_view option, std::string_view text);

struct GivenTemperature {
  double kelvin = 0.0;
  bool has_unit = false;  ///< without one it was taken for kelvin
};
/// "288", "288 K" or "15 degC".
GivenTemperature temperature(std::string_view option, std::string_view text);

/// "0.1 K" or "50 mK"; above 0.
double temperature_difference(std::string_view option, std::string_view text);

/// A whole number in [low, high].
int whole_number(std::string_view option, std::string_view text, int low, int high);

/// "LOW:HIGH" with LOW < HIGH.
std::array<double, 2> number_range(std::string_view option, std::string_view text);

/// "START:STOP" or "START:STOP:STEP": whole numbers, 0 <= START <= STOP, STEP at least 1; both ends belong to it. "N":
/// the frames 0 to N - 1.
FrameRange frame_range(std::string_view option, std::string_view text);

/// "I/N": whole numbers, 1 <= I <= N.
std::array<int, 2> part_of(std::string_view option, std::string_view text);

/// Bytes: a number with or without a unit, "512MiB", "2GB", "1073741824"; 1 MiB or more.
std::int64_t byte_count(std::string_view option, std::string_view text);

/// "X,Y,WIDTH,HEIGHT": whole numbers, the last two above 0.
std::array<std::int64_t, 4> rectangle(std::string_view option, std::string_view text);

/// "START:STOP:COUNT" with both ends, or a comma list; 1 to 1e6 finite numbers.
std::vector<double> frequency_list(std::string_view option, std::string_view text);

/// A comma list of finite numbers, 1 to 1000.
std::vector<double> number_list(std::string_view option, std::string_view text);
/// "X,Y,Z", in m.
std::array<double, 3> point(std::string_view option, std::string_view text);

/// Reads a number that is `good`; of others the message is "OPTION: TEXT" and `otherwise`.
template <class Good>
auto number_that_is(const Good& good, const char* otherwise) {
  return [=](const std::string& option, const std::string& text) {
    const double value = number(option, text);
    if (!good(value)) throw mtf::UsageError(option + ": " + text + otherwise);
    return value;
  };
}
inline auto within(double low, double high, const char* otherwise) {
  return number_that_is([=](double x) { return x >= low && x <= high; }, otherwise);
}
inline auto between(double low, double high, const char* otherwise) {
  return number_that_is([=](double x) { return x > low && x < high; }, otherwise);
}
inline auto fraction() { return between(0.0, 1.0, " is outside (0, 1)"); }

/// Reads a whole number in [low, high].
inline auto whole(int low, int high) {
  return [=](const std::string& option, const std::string& text) { return whole_number(option, text, low, high); };
}

/// Words and what they stand for.
template <class T, std::size_t N>
using Choices = std::array<std::pair<std::string_view, T>, N>;

/// The words of an enumeration, in its order.
template <class T, std::size_t N>
constexpr Choices<T, N> enumerated(const std::array<std::string_view, N>& names) {
  Choices<T, N> words{};
  for (std::size_t i = 0; i < N; ++i) words[i] = {names[i], static_cast<T>(i)};
  return words;
}
template <class T, class... Text>
constexpr auto enumerated(const Text&... names) {
  return enumerated<T>(std::array{std::string_view(names)...});
}

/// Words that stand for themselves.
template <class... Text>
constexpr Choices<std::string_view, sizeof...(Text)> as_they_are(const Text&... words) {
  return {{{words, words}...}};
}

/// The place of a word among those that are known.
std::size_t place_of(std::string_view option, std::string_view text, std::span<const std::string_view> names);

/// The value that belongs to a word.
template <class T, std::size_t N>
T choice(std::string_view option, std::string_view text, const Choices<T, N>& words) {
  std::array<std::string_view, N> names{};
  for (std::size_t i = 0; i < N; ++i) names[i] = words[i].first;
  return words[place_of(option, text, names)].second;
}

}  // namespace apps
