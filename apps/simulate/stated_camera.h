// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the file of a thermal camera says of its counts (mtf/io/raw/flir.cpp): the constants of the camera, and the
// surface, air and window that it was told of.

#include <map>
#include <optional>
#include <string>

#include "radiometry/light/raw_counts.h"

namespace apps {

struct StatedCamera {
  radiometry::CountCamera camera;
  radiometry::Thermometry assumed;
};

/// Nothing where a constant of the camera is missing. What is missing of surface, air and window counts nothing, and so
/// do air and window whose numbers give no transmission above 0, up to 1.
std::optional<StatedCamera> stated_camera(const std::map<std::string, std::string>& attributes);

/// "emissivity 0.95, reflected 293.15 K, transmission of the air 0.99 at 293.15 K"
std::string thermometry_words(const radiometry::Thermometry& assumed);

}  // namespace apps
