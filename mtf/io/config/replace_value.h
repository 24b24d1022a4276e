// SPDX-License-Identifier: Apache-2.0
#pragma once

// One value of a sensor file changed as its author would change it: comments, order and units of everything else stay.
//   const SensorConfig steady = replaced(sensor, "jitter.rms", "10 urad");
//   // steady.text is the file to write, steady.system the system that it describes

#include <string>
#include <string_view>

#include "mtf/io/config/config.h"

namespace mtf::io {

/// The text of the sensor file with a new value. `parameter`: a name as in schedules and studies, the label of a
/// component or the name of a table, then the key: "jitter.rms", "presample[1].rms_x", "frame.pitch",
/// "wavefront.zernike[3]"; beyond those names any key of a table, "scene.border", also of a table that the file does
/// not have. `value`: a number, a list, true or false as TOML writes them, else the text of a string
/// ("10 urad"); or a table { value = "10 urad", fit = true } that takes the place of the whole. A key that the file
/// does not have is added to its table; of a value with { fit = ... } the number changes and the rest stays. Throws
/// UsageError for a parameter that the sensor does not have (with the nearest name), for an element beyond the end of a
/// list, and for a file that holds the table in dotted keys, which cannot be changed in place. The value itself is not
/// checked here.
std::string replace_value(const SensorConfig& config, std::string_view parameter, std::string_view value);

/// The text without that key, which counts as not given from then on. Throws UsageError for a parameter that the sensor
/// does not have, or that the file does not state by that name.
std::string without_value(const SensorConfig& config, std::string_view parameter);

/// The value of a parameter as the file has it, `"10 urad"` with its quotes; of { value = ... } the number. "" where
/// the file does not state it. Throws UsageError for a parameter that the sensor does not have.
std::string stated_value(const SensorConfig& config, std::string_view parameter);

/// The sensor of that text. Throws UsageError as replace_value(), and with every error that the value causes.
SensorConfig replaced(const SensorConfig& config, std::string_view parameter, std::string_view value);

}  // namespace mtf::io
