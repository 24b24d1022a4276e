// SPDX-License-Identifier: Apache-2.0
#pragma once

// `mtf render --picture`: radiance beside the image of the sensor, one row a sensor, for the eye.

#include <span>
#include <string>

#include "apps/options.h"
#include "mtf/image.h"
#include "mtf/io/config/config.h"

namespace apps {

/// The picture of one sensor, and the file that it was written to.
struct SensorPictureFile {
  const mtf::io::SensorConfig& sensor;
  mtf::ImageView<const float> radiance;
  std::string unit, file;
};

/// Draws the scenes and what `mtf simulate` makes of them. A hundredth of the pixels is shown in black, and as much as
/// three hundredths in white: hot spots would take all of the colours.
void draw_pictures(const std::string& path, std::span<const SensorPictureFile> pictures, int threads);

}  // namespace apps
