// SPDX-License-Identifier: Apache-2.0
#pragma once

// What was found of a camera, as files: the sensor file, a table for people, JSON, and a line a stack.

#include <string>
#include <vector>

#include "apps/characterize/stacks_file.h"
#include "apps/text/json.h"
#include "calib/characterize/emva1288.h"
#include "mtf/io/config/config.h"

namespace apps {

struct CameraFile {
  std::string text{};
  // Keys for which there is no measured number.
  std::vector<std::string> kept{};      ///< that have the nominal's value, or a placeholder
  std::vector<std::string> left_out{};  ///< that the file does not have
  bool placeholders = false;            ///< there is no nominal
};
/// "kept from the nominal: optics.f_number, optics.transmission" and "left out: ...", those that there are.
std::vector<std::string> not_measured(const CameraFile& file);
/// Parts the keys, for which `sensor` has no measured number.
void add_not_measured(CameraFile& file, const std::vector<std::string>& keys, const mtf::io::SensorConfig& sensor);

/// The least sensor file in which the numbers can stand. What flat frames do not tell is a placeholder.
std::string least_sensor(std::int64_t columns, std::int64_t rows, int bits, double time_s);

/// The nominal with the numbers that were determined, { value, stderr }, or { value, interval } of what may be 0; its
/// comments and all else stay. `maps`: names those of pattern_planes.h in place of the
/// rms of the patterns.
CameraFile camera_file(const calib::Characterization& camera, const StacksFile& stacks, mtf::io::SensorConfig nominal,
                       int bits, bool placeholders, bool maps, const std::string& destination);

/// "2.998 +- 0.013 e-", "0 .. 0.11 e-" or the reason.
std::string shown(const calib::Finding& finding);
/// { value = "2.998 e-", stderr = "0.013 e-" } of the finding times `scale`, or the interval of what may be 0.
std::string value_with_error(const calib::Finding& finding, std::string_view unit, double scale = 1.0);
/// The sensor without that key, where it has it.
mtf::io::SensorConfig without_key(mtf::io::SensorConfig sensor, const std::string& key);
/// The sensor with the dead, hot and blinking pixels that were found, whose excess is in `unit` times `scale`.
mtf::io::SensorConfig with_pixels(mtf::io::SensorConfig sensor, const calib::Characterization& camera,
                                  std::string_view unit, double scale = 1.0);
/// The sensor with the lag that was found, or without one where the frames show that there is none.
mtf::io::SensorConfig with_lag(mtf::io::SensorConfig sensor, const calib::Characterization& camera);
/// The sensor as a file at `destination`, which names its own files from its folder.
mtf::io::SensorConfig own_named(const mtf::io::SensorConfig& sensor, const std::string& destination);
/// Lines above its text: where its numbers are from, and what is not measured.
std::string file_head(const calib::Characterization& camera, const StacksFile& stacks, const CameraFile& file);

std::string characterize_table(const calib::Characterization& camera, const CameraFile& file);
Json characterize_json(const calib::Characterization& camera, const StacksFile& stacks, const CameraFile& file);
std::string emva1288_table(const calib::Emva1288& standard);
Json emva1288_json(const calib::Emva1288& standard, const StacksFile& stacks);
std::string levels_csv(const calib::Characterization& camera);

}  // namespace apps
