// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a sensor file to the chain of radiometry: the files that its tables name, read and checked.

#include "mtf/io/config.h"
#include "radiometry/chain.h"

namespace apps {

/// True when the file says more than the OTF: its output is electrons or what comes after them.
bool has_chain(const mtf::io::SensorConfig& config);

/// The sensor with its curves, tables and maps. Throws UsageError with the key of the sensor file for what does not
/// fit, RuntimeError for files that cannot be read.
radiometry::Sensor load_chain(const mtf::io::SensorConfig& config);

/// The system whose band is weighted by the electrons that the curves of the sensor give.
mtf::System<double> with_electron_rate(const mtf::System<double>& system, const radiometry::Sensor& sensor);

}  // namespace apps
