// SPDX-License-Identifier: Apache-2.0
#pragma once

// Instants as seconds of UTC since 1970-01-01T00:00:00Z, every day of 86400 s (leap seconds are not counted, as in
// POSIX time), in the Gregorian calendar; negative before 1970. A double keeps 0.3 us over the years 1900 to 2100.

#include <optional>
#include <string>
#include <string_view>

namespace radiometry::heat {

inline constexpr double kDay_s = 86400.0;

struct CalendarDate {
  int year = 1970, month = 1, day = 1;
};

bool is_leap_year(int year);
int days_of_month(int year, int month);
/// True for a date that the calendar has, years 1 to 9999.
bool is_date(const CalendarDate& date);

/// The instant at `seconds` after the midnight that begins the date; 86400 s is the next midnight.
double instant_of(const CalendarDate& date, double seconds = 0.0);
CalendarDate date_of(double utc_s);

/// Why a text is no instant; what to write instead.
struct InstantError {
  std::string text;
};

/// ISO 8601: "2016-01-01T12:30:00Z", "2016-01-01 12:30+01:00", seconds with or without decimals, "24:00" for the end of
/// the day. The zone is compulsory. Null with `error` filled for anything else.
std::optional<double> parse_instant(std::string_view text, InstantError& error);

/// "2016-01-01T12:30:00Z", with decimals of a second where there are any (to 1 us).
std::string instant_text(double utc_s);

}  // namespace radiometry::heat
