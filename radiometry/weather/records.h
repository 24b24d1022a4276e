// SPDX-License-Identifier: Apache-2.0
#pragma once

// Records of a station with the time that each of them stands for: the step between a file and functions of time
// (weather_series.h).

#include <array>
#include <string>
#include <vector>

#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather_series.h"

namespace radiometry::heat {

/// `begin_s` = `end_s` for instants. Time that no record covers is a record without values, so that neighbours touch.
struct Records {
  bool means = false;
  double step_s = 0.0;  ///< usual distance of records
  std::vector<double> begin_s{}, end_s{};
  std::array<std::vector<double>, kQuantities> values{};

  std::size_t size() const { return begin_s.size(); }
  double length_s(std::size_t i) const { return end_s[i] - begin_s[i]; }
  double middle(std::size_t i) const { return begin_s[i] + length_s(i) / 2.0; }
  const std::vector<double>& operator[](WeatherQuantity quantity) const {
    return values[static_cast<std::size_t>(quantity)];
  }
  void add(double begin, double end) {
    begin_s.push_back(begin);
    end_s.push_back(end);
  }
};

/// Of weather with at least two records; the columns that hold at the stamps, or those that are means. Records are more
/// than 1.5 usual steps apart where time is missing.
Records records_of(const Weather& weather, bool means);

/// Makes the records those of one day, to be used again and again: instants get the first one as that of the next day.
/// A record too many at the beginning, as of 0 h and 24 h or of a mean that begins on the day before, is left out.
void close_day(Records& records, const std::string& source);

/// Straight lines over short stretches of missing values; longer ones and those at the ends stay.
void bridge(Records& records, const SeriesOptions& options, std::vector<std::string>& warnings);

/// The missing one of beam B, diffuse D and global G where two are there: G = B cos z + D.
void close_solar(Records& records, const Place& place, std::vector<std::string>& warnings);

}  // namespace radiometry::heat
