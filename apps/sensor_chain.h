// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a sensor file to the chain of radiometry: the files that its tables name, read and checked.

#include "mtf/io/config.h"
#include "radiometry/chain.h"
#include "radiometry/path.h"

namespace apps {

/// True when the file says more than the OTF: its output is electrons or what comes after them.
bool has_chain(const mtf::io::SensorConfig& config);

/// A sensor and what lies before its aperture.
struct LoadedSensor {
  radiometry::Sensor sensor;
  std::shared_ptr<const radiometry::PathTable> paths;  ///< for the range of each pixel, where the file says so
};

/// The sensor with its curves, tables and maps. Throws UsageError with file and key for what does not fit, RuntimeError
/// for files that cannot be read.
LoadedSensor load_chain(const mtf::io::SensorConfig& config);

/// The system whose band is weighted by the electrons that the curves of the sensor give; unchanged where no curve and
/// no source temperature is given.
mtf::System<double> with_electron_rate(const mtf::System<double>& system, const radiometry::Sensor& sensor);

/// The stages of the chain in their order, and those that are off with what would switch them on. Throws as load_chain.
std::string explain_chain(const mtf::io::SensorConfig& config);

/// Settings that contradict each other, as `mtf config check` tells them: empty when load_chain has none.
std::string chain_problem(const mtf::io::SensorConfig& config);

}  // namespace apps
