// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/instant.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace radiometry::heat {
namespace {

constexpr std::array kMonthDays{31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
constexpr std::string_view kExample = "write it like 2016-01-01T12:30:00Z or 2016-01-01T13:30:00+01:00";

/// Days from 1970-01-01, proleptic Gregorian calendar, years counted from March (Hinnant, "chrono-compatible low-level
/// date algorithms").
std::int64_t days_of(const CalendarDate& date) {
  const std::int64_t y = date.year - (date.month <= 2 ? 1 : 0);
  const std::int64_t era = (y >= 0 ? y : y - 399) / 400;
  const std::int64_t year_of_era = y - era * 400;
  const std::int64_t day_of_year = (153 * (date.month + (date.month > 2 ? -3 : 9)) + 2) / 5 + date.day - 1;
  return era * 146097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719468;
}

/// Takes exactly `digits` digits off the text.
std::optional<int> take_digits(std::string_view& text, std::size_t digits) {
  if (text.size() < digits) return std::nullopt;
  int value = 0;
  for (const char c : text.substr(0, digits)) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + (c - '0');
  }
  text.remove_prefix(digits);
  return value;
}

bool take(std::string_view& text, std::string_view any_of) {
  if (text.empty() || any_of.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

/// ":30", ":30.25", or nothing.
std::optional<double> take_seconds(std::string_view& text) {
  if (!take(text, ":")) return 0.0;
  const std::string_view start = text;
  if (!take_digits(text, 2)) return std::nullopt;
  if (take(text, ".")) {
    if (!take_digits(text, 1)) return std::nullopt;
    while (take_digits(text, 1)) {
    }
  }
  double value = 0.0;
  std::from_chars(start.data(), text.data(), value);
  return value;
}

/// Seconds east of Greenwich.
std::optional<double> take_zone(std::string_view& text) {
  if (take(text, "Zz")) return 0.0;
  const bool west = !text.empty() && text.front() == '-';
  if (!take(text, "+-")) return std::nullopt;
  const auto hours = take_digits(text, 2);
  take(text, ":");
  const auto minutes = text.empty() ? std::optional(0) : take_digits(text, 2);
  if (!hours || !minutes || *hours > 14 || *minutes > 59) return std::nullopt;
  return (west ? -60.0 : 60.0) * (60 * *hours + *minutes);
}

}  // namespace

bool is_leap_year(int year) { return year % 4 == 0 && (year % 100 != 0 || year % 400 == 0); }

int days_of_month(int year, int month) {
  return month == 2 && is_leap_year(year) ? 29 : kMonthDays.at(static_cast<std::size_t>(month - 1));
}

bool is_date(const CalendarDate& date) {
  return date.year >= 1 && date.year <= 9999 && date.month >= 1 && date.month <= 12 && date.day >= 1 &&
         date.day <= days_of_month(date.year, date.month);
}

double instant_of(const CalendarDate& date, double seconds) {
  return static_cast<double>(days_of(date)) * kDay_s + seconds;
}

CalendarDate date_of(double utc_s) {
  const auto days = static_cast<std::int64_t>(std::floor(utc_s / kDay_s)) + 719468;
  const std::int64_t era = (days >= 0 ? days : days - 146096) / 146097;
  const std::int64_t day_of_era = days - era * 146097;
  const std::int64_t year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36524 - day_of_era / 146096) / 365;
  const std::int64_t day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
  const std::int64_t month = (5 * day_of_year + 2) / 153;  // from March
  const std::int64_t year = year_of_era + era * 400 + (month >= 10 ? 1 : 0);
  return {static_cast<int>(year), static_cast<int>(month < 10 ? month + 3 : month - 9),
          static_cast<int>(day_of_year - (153 * month + 2) / 5 + 1)};
}

std::optional<double> parse_instant(std::string_view text, InstantError& error) {
  const auto fail = [&](std::string_view why) {
    error.text = std::string(why) + "; " + std::string(kExample);
    return std::nullopt;
  };
  CalendarDate date;
  const auto year = take_digits(text, 4);
  const bool dash = take(text, "-");
  const auto month = take_digits(text, 2);
  const bool second_dash = take(text, "-");
  const auto day = take_digits(text, 2);
  if (!year || !dash || !month || !second_dash || !day) return fail("no date and time");
  date = {*year, *month, *day};
  if (!is_date(date)) return fail("the calendar has no such day");
  if (!take(text, "Tt ")) return fail("a date without a time");
  const auto hour = take_digits(text, 2);
  const bool colon = take(text, ":");
  const auto minute = take_digits(text, 2);
  const auto second = take_seconds(text);
  if (!hour || !colon || !minute || !second) return fail("no time of the day");
  const double seconds = 3600.0 * *hour + 60.0 * *minute + *second;
  if (*minute > 59 || *second >= 60.0 || seconds > kDay_s) return fail("the day has no such time");
  if (text.empty()) return fail("the time zone is missing");
  const auto zone = take_zone(text);
  if (!zone) return fail("no time zone");
  if (!text.empty()) return fail("text after the time zone");
  return instant_of(date, seconds) - *zone;
}

std::string instant_text(double utc_s) {
  // Whole microseconds first, so that 59.9999999 s is not written as 60 s.
  double day = std::floor(utc_s / kDay_s);
  auto micros = static_cast<std::int64_t>(std::llround((utc_s - day * kDay_s) * 1e6));
  constexpr std::int64_t kDayMicros = 86'400'000'000;
  if (micros >= kDayMicros) {
    micros -= kDayMicros;
    day += 1.0;
  }
  const CalendarDate date = date_of(day * kDay_s);
  const auto seconds = static_cast<int>(micros / 1'000'000);
  auto rest = static_cast<int>(micros % 1'000'000);
  std::array<char, 64> text{};
  int size = std::snprintf(text.data(), text.size(), "%04d-%02d-%02dT%02d:%02d:%02d", date.year, date.month, date.day,
                           seconds / 3600, seconds / 60 % 60, seconds % 60);
  std::string result(text.data(), static_cast<std::size_t>(size));
  if (rest > 0) {
    size = std::snprintf(text.data(), text.size(), ".%06d", rest);
    result.append(text.data(), static_cast<std::size_t>(size));
    while (result.back() == '0') result.pop_back();
  }
  return result + "Z";
}

}  // namespace radiometry::heat
