// SPDX-License-Identifier: Apache-2.0
#pragma once

// The planes that show the fixed patterns of a camera: for the page of results, and as maps for its sensor file.

#include <optional>
#include <string>
#include <vector>

#include "calib/characterize/characterize.h"

namespace apps {

struct PatternPlane {
  std::string name, unit;  ///< "dark signal" in e-, "response" in %
  mtf::Image plane{};      ///< about 0
  calib::PlaneSquares squares{};
  double temporal2 = 0.0;  ///< variance of a pixel that is left of temporal noise, and the fixed part of rounding

  /// Rms of the pattern of pixels alone.
  double rms() const;
};

/// The mean frame of the dark stack, then the difference of the bright and the dark one over its signal, without
/// shading (calib/characterize/trend.h); those that are there.
std::vector<PatternPlane> pattern_planes(const calib::Characterization& camera);

/// In the form of nonuniformity.offset, electrons, and nonuniformity.responsivity, factors, without defects of the mean
/// 0 and 1: without what is left of temporal noise (calib::pattern_map) and, of the responsivity, before crosstalk.
struct PatternMaps {
  mtf::Image offset, responsivity;
};
/// Throws UsageError where one of the planes is missing.
PatternMaps pattern_maps(const calib::Characterization& camera, const std::vector<PatternPlane>& planes);

/// A line a pixel: plane, x, y, excess, unit.
std::string defects_csv(const std::vector<PatternPlane>& planes);

}  // namespace apps
