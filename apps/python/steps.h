// SPDX-License-Identifier: Apache-2.0
#pragma once

// The spacing of scene samples as Python gives it: one text, or one for each axis; a length at the focal plane, an
// object angle, or pixels.

#include <optional>
#include <string>
#include <utility>

#include "mtf/grid.h"
#include "mtf/io/config/config.h"
#include "radiometry/output_stage.h"

namespace apps::python {

using SampleWords = std::optional<std::pair<std::string, std::string>>;

/// The grid of a scene of that size. Without words the spacing is that of [scene]; throws UsageError where that has
/// none.
mtf::SampleGrid grid_of(const mtf::io::SensorConfig& sensor, std::int64_t width, std::int64_t height,
                        const SampleWords& sample);

/// What values in memory are. Throws UsageError that lists what they may be.
mtf::io::Quantity quantity_of(const std::string& name);

/// A place in the chain by its name. Throws UsageError that lists them.
radiometry::OutputStage output_stage(const std::string& name);

}  // namespace apps::python
