// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a camera is over time, from a CSV file:
//   time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)
//   0,200,-150,60,0,0,1
//   20,60,-40,25,0,0,1
// `time` counts from the first frame; x, y and z are the position, look_x, look_y and look_z what the camera looks at.
// Between lines both go along straight lines. Lengths in any unit; comments, separators and times as in weather files
// (weather_csv.h).

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace apps::scene {

struct CameraPlace {
  std::array<double, 3> position_m{}, look_at_m{};
};

struct CameraPath {
  std::string source;
  std::vector<double> time_s;  ///< rising, from the first frame
  std::vector<CameraPlace> place;

  /// Throws UsageError for a time that the path does not have.
  CameraPlace at(double time_s) const;
};

/// Throws RuntimeError where the file cannot be read, UsageError "file:line: error: ..." for a wrong or missing column,
/// times that do not rise or are instants, a camera that looks at itself or jumps (above 3000 m/s).
CameraPath read_camera_path(const std::string& path);
CameraPath parse_camera_path(std::string_view text, const std::string& source);

}  // namespace apps::scene
