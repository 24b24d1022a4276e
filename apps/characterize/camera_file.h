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
  std::string text;
  std::vector<std::string> left;  ///< keys that hold nothing measured: the nominal's, or placeholders
};

/// The least sensor file in which the numbers can stand. What flat frames do not tell is a placeholder.
std::string least_sensor(std::int64_t columns, std::int64_t rows, int bits, double time_s);

/// The nominal with the numbers that were determined, { value, stderr }; its comments and all else stay. Limits are
/// named in the lines above it.
CameraFile camera_file(const calib::Characterization& camera, const StacksFile& stacks, mtf::io::SensorConfig nominal,
                       int bits, bool placeholders, const std::string& destination);

std::string characterize_table(const calib::Characterization& camera, const std::vector<std::string>& left);
Json characterize_json(const calib::Characterization& camera, const StacksFile& stacks, const CameraFile& file);
std::string emva1288_table(const calib::Emva1288& standard);
Json emva1288_json(const calib::Emva1288& standard, const StacksFile& stacks);
std::string levels_csv(const calib::Characterization& camera);

}  // namespace apps
