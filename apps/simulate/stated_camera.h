// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the file of a thermal camera says of its counts (mtf/io/raw/flir.cpp): the constants of the camera, and the
// surface, air and window that it was told of.

#include <map>
#include <optional>
#include <span>
#include <string>

#include "mtf/io/image_io.h"
#include "radiometry/performance/count_uncertainty.h"

namespace apps {

struct StatedCamera {
  radiometry::CountCamera camera;
  radiometry::CountScene told;
  std::optional<radiometry::CountAir> air{};  ///< constants of its transmission; without them the air counts nothing
  radiometry::CountNumbers sd{};              ///< of what it was told, by assume(): 0 where nothing is stated
  /// "; the file's ..., is left out" of numbers that cannot be, "" where all can; the emissivity by itself.
  std::string left_out{}, no_emissivity{};

  radiometry::Thermometry assumed() const { return thermometry_of(told, air); }
};

/// Nothing where a constant of the camera is missing. What is missing of surface, air and window counts nothing, and so
/// does what is left out: an emissivity outside of (0, 1], and air and window whose numbers give no transmission there.
std::optional<StatedCamera> stated_camera(const std::map<std::string, std::string>& attributes);

/// Numbers in place of what the file says, and standard deviations: "emissivity=0.3 +- 0.05", "surroundings=+- 2 K" or
/// "distance=5 m", keys as in CountScene. Throws UsageError that names the key for what cannot be, and for air whose
/// constants are not in the file.
void assume(StatedCamera& stated, std::span<const std::string> words);

/// Throws UsageError, naming the file and what to do, for constants out of their bounds.
void require_camera(const std::string& file, const radiometry::CountCamera& camera);

/// "emissivity 0.95, reflected 293.15 K, transmission of the air 0.99 at 293.15 K"
std::string thermometry_words(const radiometry::Thermometry& assumed);

/// How many counts stand at an end of the 16 bits of their file, so that what they saw lies beyond the temperatures
/// that they become; "" where none do. `counts` are those of channel `name`, scaled.
std::string clipped_counts(const mtf::io::FileInfo& info, const std::string& name, mtf::ImageView<const float> counts,
                           const mtf::io::IntegerScaling& scaling = {});

}  // namespace apps
