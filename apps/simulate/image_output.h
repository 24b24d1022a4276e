// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a finished image goes: a file, the caller's sink, or back to the caller.

#include "apps/simulate/sensor_image.h"
#include "apps/simulate/simulate.h"

namespace apps {

/// `file`: the name to write, "" for none. What is left of `image` afterwards is what the caller gets back: without
/// planes where a file or the sink has them, but for SimulateOptions::keep_images. Returns how a PNG or TIFF was
/// scaled. Throws as write_sensor_image.
Written deliver(const SimulateOptions& options, const std::string& file, const std::vector<std::string>& names,
                SimulatedImage& image, const IntegerRange& range);

}  // namespace apps
