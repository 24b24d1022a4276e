// SPDX-License-Identifier: Apache-2.0
#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/atmosphere/amounts_impl.h"

namespace radiometry::atmosphere {

using mtf::format_double;
using mtf::UsageError;

namespace {

std::string metres(double value) { return format_double(1e-3 * std::round(1e3 * value)) + " m"; }

}  // namespace

void refuse_sensor(const std::string& source, double altitude_m, double lowest_m, double highest_m) {
  throw UsageError("line of sight: an altitude of " + metres(altitude_m) +
                   (altitude_m < lowest_m ? " is below the ground; " : " is above the air; ") + source + " goes from " +
                   metres(lowest_m) + " to " + metres(highest_m) +
                   (altitude_m < lowest_m ? "" : "; there is no air above, so put the end of the line there"));
}
void refuse_one_level(const std::string& source) {
  throw UsageError(
      "line of sight: " + source +
      " has one level, which is the air of horizontal paths; give a model atmosphere or a profile for slant ones");
}
void refuse_range(double range_m) {
  throw UsageError("line of sight: a range of " + format_double(range_m) + " m; it has to be a number from 0 on");
}
void refuse_level_range(double range_m) {
  throw UsageError("line of sight: a range of " + metres(range_m) +
                   " at one altitude, a quarter of the way around the earth and more; give the altitude of the object, "
                   "or a zenith angle");
}
void refuse_zenith(double zenith_rad) {
  throw UsageError("line of sight: a zenith angle of " + format_double(zenith_rad) +
                   " rad; it has to be from 0 (up) to pi (down)");
}
void refuse_nearer(double range_m, double from_m, double to_m) {
  throw UsageError("line of sight: a range of " + metres(range_m) + " between altitudes of " + metres(from_m) +
                   " and " + metres(to_m) + ", which are " + metres(std::abs(to_m - from_m)) +
                   " apart; the range has to be that or more");
}
void refuse_ground(double range_m, double length_m, double from_m) {
  throw UsageError("line of sight: from " + metres(from_m) + " it meets the ground after " + metres(length_m) +
                   (range_m >= 0.0 ? ", before its range of " + metres(range_m) + "; give less range or look higher"
                                   : "; look higher, or end it at the altitude of the ground"));
}
void refuse_horizon(double range_m, double from_m, double to_m, double horizon_m) {
  throw UsageError("line of sight: a range of " + metres(range_m) + " is beyond the horizon, which is " +
                   metres(horizon_m) + " for altitudes of " + metres(from_m) + " and " + metres(to_m));
}
void refuse_altitude(double altitude_m, double zenith_rad, double tangent_m) {
  throw UsageError("line of sight: with a zenith angle of " + format_double(180.0 / mtf::kPi * zenith_rad) +
                   " degrees it never gets to " + metres(altitude_m) + "; it goes no lower than " + metres(tangent_m));
}

double horizon_range_m(const Air<double>& air, double sensor_altitude_m, double object_altitude_m) {
  require_valid(air);
  for (const double z : {sensor_altitude_m, object_altitude_m}) static_cast<void>(line_from(air, z));
  return horizon_m(column_of(air), sensor_altitude_m, object_altitude_m);
}

template SightNumbers<double> sight_numbers(const Air<double>&, const Sight<double>&);
template std::vector<PathLayer<double>> path_layers(const Air<double>&, const Sight<double>&);

}  // namespace radiometry::atmosphere
