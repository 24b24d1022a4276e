// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sensor file in memory, as the class Sensor of the package holds it, and the words that its calls take.

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mtf/grid.h"
#include "mtf/io/config/config.h"
#include "radiometry/output_stage.h"

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

/// The spacing of scene samples as Python gives it: one text, or one for each axis; a length at the focal plane, an
/// object angle, or pixels.
using SampleWords = std::optional<std::pair<std::string, std::string>>;

/// The grid of a scene of that size. Without words the spacing is that of [scene]; throws UsageError without one.
mtf::SampleGrid grid_of(const mtf::io::SensorConfig& sensor, std::int64_t width, std::int64_t height,
                        const SampleWords& sample);

/// What values in memory are. Throws UsageError that lists what they may be.
mtf::io::Quantity quantity_of(const std::string& name);

/// A place in the chain by its name. Throws UsageError that lists them.
radiometry::OutputStage output_stage(const std::string& name);

}  // namespace apps::python
