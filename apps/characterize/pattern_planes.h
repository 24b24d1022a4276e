// SPDX-License-Identifier: Apache-2.0
#pragma once

// The planes that show the fixed patterns of a camera: for the page of results, and as maps for its sensor file.

#include <optional>
#include <string>
#include <vector>

#include "calib/characterize/characterize.h"

namespace apps {

/// Of noise and patterns: electrons, or mK of blackbodies.
struct NoiseUnit {
  std::string name;
  double per_count = 1.0;
};
NoiseUnit noise_unit(const calib::Characterization& camera);

/// The stacks of the least and of the most light in the fit.
struct FitEnds {
  const calib::Stack &least, &most;
};
FitEnds fit_ends(const calib::Characterization& camera);

struct PatternPlane {
  std::string name, unit;  ///< "dark signal" or, of blackbodies, "fixed pattern" in a NoiseUnit; "response" in %
  mtf::Image plane{};      ///< about 0
  calib::PlaneSquares squares{};
  double temporal2 = 0.0;  ///< variance of a pixel that is left of temporal noise, and the fixed part of rounding

  /// Rms of the pattern of pixels alone.
  double rms() const;
};

/// The mean frame of the dark stack, then the difference of the bright and the dark one over its signal, without
/// shading (calib/characterize/pattern.h); those that are there. Of blackbodies the mean frame of that nearest to the
/// reference, then the difference of the hottest and the coldest one.
std::vector<PatternPlane> pattern_planes(const calib::Characterization& camera);

/// In the form of nonuniformity.offset, electrons, and nonuniformity.responsivity, factors, without defects of the mean
/// 0 and 1: without what is left of temporal noise (calib::pattern_map) and, of the responsivity, before crosstalk.
struct PatternMaps {
  mtf::Image offset, responsivity;
};
/// Throws UsageError where one of the planes is missing.
PatternMaps pattern_maps(const calib::Characterization& camera, const std::vector<PatternPlane>& planes);

/// A line a pixel: plane, x, y, excess, unit. Of pixels that are too noisy, as those that blink, the plane is "temporal
/// noise" and the excess their rms.
std::string defects_csv(const calib::Characterization& camera, const std::vector<PatternPlane>& planes);

}  // namespace apps
