// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <ctime>
#include <random>

#include "radiometry/weather/instant.h"
#include "tests/expect_error.h"

namespace radiometry::heat {
namespace {

double parsed(std::string_view text) {
  InstantError error;
  const auto instant = parse_instant(text, error);
  EXPECT_TRUE(instant) << text << ": " << error.text;
  return instant.value_or(0.0);
}

std::string refusal(std::string_view text) {
  InstantError error;
  EXPECT_FALSE(parse_instant(text, error)) << text;
  return error.text;
}

TEST(Instant, AgreesWithTheSystemsCalendarFrom1800To2200) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::int64_t> any(-5364662400, 7258118400);
  for (int i = 0; i < 20000; ++i) {
    const std::time_t t = any(random);
    std::tm fields{};
    gmtime_r(&t, &fields);
    const CalendarDate date = date_of(static_cast<double>(t));
    ASSERT_EQ(date.year, fields.tm_year + 1900);
    ASSERT_EQ(date.month, fields.tm_mon + 1);
    ASSERT_EQ(date.day, fields.tm_mday);
    ASSERT_EQ(instant_of(date, fields.tm_hour * 3600 + fields.tm_min * 60 + fields.tm_sec), static_cast<double>(t));
    ASSERT_EQ(parsed(instant_text(static_cast<double>(t))), static_cast<double>(t));
  }
}

TEST(Instant, ReadsZonesDecimalsAndTheEndOfTheDay) {
  EXPECT_EQ(parsed("1970-01-01T00:00:00Z"), 0.0);
  EXPECT_EQ(parsed("2016-01-01T00:00:00Z"), 1451606400.0);
  EXPECT_EQ(parsed("2016-01-01 13:30+01:00"), parsed("2016-01-01T12:30:00Z"));
  EXPECT_EQ(parsed("2016-01-01T00:30:00-0530"), parsed("2016-01-01T06:00:00Z"));
  EXPECT_EQ(parsed("2016-02-28T24:00Z"), parsed("2016-02-29T00:00Z"));
  EXPECT_EQ(parsed("1970-01-01T00:00:01.25Z"), 1.25);
  EXPECT_EQ(instant_text(1.25), "1970-01-01T00:00:01.25Z");
  EXPECT_EQ(instant_text(59.9999999), "1970-01-01T00:01:00Z");
}

TEST(Instant, RefusesWhatIsNoInstantAndSaysWhy) {
  expect_says(refusal("2016-01-01T12:30:00"), {"time zone is missing"});
  expect_says(refusal("2015-02-29T00:00Z"), {"no such day"});
  expect_says(refusal("1900-02-29T00:00Z"), {"no such day"});
  expect_says(refusal("2016-01-01"), {"without a time"});
  expect_says(refusal("2016-01-01T25:00Z"), {"no such time"});
  expect_says(refusal("2016-01-01T24:01Z"), {"no such time"});
  for (const char* text : {"", "now", "2016-1-1T00:00Z", "2016-13-01T00:00Z", "2016-01-01T12Z", "2016-01-01T12:30CET",
                           "2016-01-01T12:30:00.Z", "2016-01-01T12:30Z and more", "2016-01-01T12:30+25:00"})
    EXPECT_TRUE(says(refusal(text), "write it like")) << text;
}

TEST(Instant, KnowsLeapYears) {
  EXPECT_TRUE(is_leap_year(2000));
  EXPECT_FALSE(is_leap_year(2100));
  EXPECT_EQ(days_of_month(2024, 2), 29);
  EXPECT_FALSE(is_date({2023, 2, 29}));
}

}  // namespace
}  // namespace radiometry::heat
