// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/scene_file/scene_sections.h"

#include <algorithm>
#include <cmath>

#include "apps/scene/weather/weather_file.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"

namespace apps::scene {
namespace {

constexpr std::array<std::string_view, 6> kColumns{"x", "y", "z", "look_x", "look_y", "look_z"};
constexpr double kFastest_m_s = 3000.0, kFarthest_m = 1e6;
constexpr double kFirstInstant_s = 1e8;  // seconds of a flight are fewer; instants are since 1970

std::array<double, 3> between(const std::array<double, 3>& a, const std::array<double, 3>& b, double share) {
  return {std::lerp(a[0], b[0], share), std::lerp(a[1], b[1], share), std::lerp(a[2], b[2], share)};
}

const TimedColumn& column_of(const TimedTable& table, std::string_view name, const std::string& source) {
  for (const TimedColumn& column : table.columns)
    if (column.name == name) {
      if (!same_dimension(column.unit, *parse_unit("m")))
        throw mtf::UsageError(error_at(source, table.header_line) + "column " + std::string(name) +
                              " is a length; write " + std::string(name) + " (m)");
      return column;
    }
  throw mtf::UsageError(error_at(source, table.header_line) + "there is no column " + std::string(name) +
                        "; write time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)");
}

}  // namespace

CameraPlace CameraPath::at(double asked_s) const {
  constexpr double kSlack_s = 1e-6;  // for the rounding of frame numbers times a rate
  const double time = std::clamp(asked_s, time_s.front(), time_s.back());
  if (!(std::abs(time - asked_s) <= kSlack_s))
    throw mtf::UsageError(one_line(source) + ": the camera's path goes from " + significant(time_s.front(), 6) +
                          " s to " + significant(time_s.back(), 6) + " s; there is no place at " +
                          significant(asked_s, 6) + " s");
  const auto above = std::upper_bound(time_s.begin(), time_s.end(), time);
  if (above == time_s.end()) return place.back();
  const auto k = static_cast<std::size_t>(above - time_s.begin());
  const double share = (time - time_s[k - 1]) / (time_s[k] - time_s[k - 1]);
  return {between(place[k - 1].position_m, place[k].position_m, share),
          between(place[k - 1].look_at_m, place[k].look_at_m, share)};
}

CameraPath parse_camera_path(std::string_view text, const std::string& source) {
  const TimedTable table = parse_timed_table(text, source, 0.0);
  std::array<const TimedColumn*, 6> columns{};
  for (std::size_t c = 0; c < columns.size(); ++c) columns[c] = &column_of(table, kColumns[c], source);
  for (const TimedColumn& column : table.columns)
    if (std::find(kColumns.begin(), kColumns.end(), column.name) == kColumns.end())
      throw mtf::UsageError(error_at(source, table.header_line) + "there is no such column as " +
                            one_line(column.name) + " in a path: x, y, z, look_x, look_y, look_z");
  CameraPath path{.source = source, .time_s = table.time_s, .place = {}};
  if (path.time_s.empty()) throw mtf::UsageError(error_at(source, table.header_line) + "a path needs a place");
  for (std::size_t i = 0; i < path.time_s.size(); ++i) {
    const std::string here = error_at(source, table.line[i]);
    std::array<double, 6> v{};
    for (std::size_t c = 0; c < v.size(); ++c) {
      v[c] = columns[c]->value[i];
      if (!std::isfinite(v[c])) throw mtf::UsageError(here + std::string(kColumns[c]) + " is missing");
      if (std::abs(v[c]) > kFarthest_m)
        throw mtf::UsageError(here + std::string(kColumns[c]) + " is " + significant(v[c], 3) +
                              " m; a place is within 1000 km of the origin");
    }
    const CameraPlace place{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
    if (std::abs(path.time_s[i]) > kFirstInstant_s)
      throw mtf::UsageError(here + "time counts from the first frame, in s: write time (s)");
    if (place.position_m == place.look_at_m) throw mtf::UsageError(here + "the camera looks at its own position");
    if (i > 0 && !(path.time_s[i] > path.time_s[i - 1]))
      throw mtf::UsageError(here + "the time is not after that of the line above it");
    if (i > 0) {
      const auto &from = path.place.back().position_m, &to = place.position_m;
      const double speed =
          std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]) / (path.time_s[i] - path.time_s[i - 1]);
      if (speed > kFastest_m_s)
        throw mtf::UsageError(here + "the camera jumps: " + significant(speed, 3) + " m/s from the line above it");
    }
    path.place.push_back(place);
  }
  return path;
}

CameraPath read_camera_path(const std::string& path) { return parse_camera_path(mtf::io::read_table_text(path), path); }

}  // namespace apps::scene
