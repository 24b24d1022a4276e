// SPDX-License-Identifier: Apache-2.0
#pragma once

// The air over many ranges at once: a PathTable as the chain takes it (radiometry/light/path.h), computed from sums
// that ranges on one line of sight share.
//   Horizontal, AtAngle     the range of the sight is replaced by each of the ranges
//   ToAltitude, ToSpace     ranges along that line, up to its end
//   Between                 the altitudes stay, so that each range is a line of its own angle (no shared sums)

#include <span>
#include <vector>

#include "radiometry/atmosphere/spectral_path.h"

namespace radiometry::atmosphere {

struct RangeTableResult {
  PathTable table;
  std::vector<LeftOut> left_out;
};

/// `ranges_m` rise and are above 0. Throws UsageError as spectral_path does.
RangeTableResult path_table(const Air<double>& air, const Sight<double>& sight, std::span<const double> ranges_m,
                            const SpectralOptions& options = {});

/// The spectral paths of those ranges, for other uses. Equal to spectral_path of each alone.
template <class S>
std::vector<SpectralPath<S>> spectral_paths(const Air<S>& air, const Sight<S>& sight, std::span<const double> ranges_m,
                                            const SpectralOptions& options = {});

/// Ranges from the nearest to the longest, so dense that PathTable is wrong by no more than the tolerance between them:
/// in transmission, and in radiance relative to a blackbody of the sensor's air; found by comparing with the model
/// halfway (geometrically). `error` is the largest difference found; it is above the tolerance when `most` ranges did
/// not do. Nothing is said of ranges nearer than the nearest: strong lines saturate within centimetres.
struct TableRanges {
  std::vector<double> ranges_m;
  double error = 0.0;
};
TableRanges ranges_for(const Air<double>& air, const Sight<double>& sight, double nearest_m, double longest_m,
                       double tolerance, const Interval& band, std::size_t most = 256);

}  // namespace radiometry::atmosphere
