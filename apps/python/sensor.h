// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sensor file in memory, as the class Sensor of the package holds it.

#include <memory>
#include <string>
#include <vector>

#include "mtf/io/config/config.h"

namespace apps::python {

struct SensorHandle {
  std::shared_ptr<const mtf::io::SensorConfig> config;
  /// The same with the electron rate of its band, for what takes the OTF alone, as `mtf curve` does.
  std::shared_ptr<const mtf::io::SensorConfig> weighted;
  /// Hashes of the files that it names, as they were when it was made; "" for one that was not there.
  std::vector<std::string> contents{};
};

/// Some of these files are read when they are needed: throws RuntimeError, naming it, for one that is not what it was.
void require_unchanged(const SensorHandle& sensor);

/// Reads the text of a sensor file. Throws UsageError with every error as a "file:line:col: error: ..." line.
SensorHandle read_sensor_text(const std::string& text, const std::string& file);

/// The sensor with the electron rate of its band, made when it is first asked for. Throws as load_chain.
std::shared_ptr<const mtf::io::SensorConfig> weighted(SensorHandle& sensor);

}  // namespace apps::python
