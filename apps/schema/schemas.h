// SPDX-License-Identifier: Apache-2.0
#pragma once

// What files may hold, for other programs: the field tables of apps/sensor/sensor_kinds.h as JSON, and JSON Schemas
// (draft-07) that editors complete and check TOML with. Every name, unit and range comes from the table that reads the
// file.

#include <string>

namespace apps {

/// `mtf config kinds [KIND] --format json`: {"components": [...], "tables": [...]}, those of that name where one is
/// given; of `metrics` {"metrics": [...]}. Throws UsageError for an unknown one.
std::string kinds_json(const std::string& kind);

/// `mtf config schema sensor`.
std::string sensor_file_schema();
/// `mtf config schema study`; where studies are built.
std::string study_file_schema();
/// `mtf config schema scene`; where scenes are built.
std::string scene_file_schema();

}  // namespace apps
