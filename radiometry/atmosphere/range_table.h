// SPDX-License-Identifier: Apache-2.0
#pragma once

// The air over many ranges at once: a PathTable as the chain takes it (radiometry/light/path.h), computed from sums
// that ranges on one line of sight share.
//   Horizontal, AtAngle     the range of the sight is replaced by each of the ranges
//   ToAltitude, ToSpace     ranges along that line, up to its end
//   Between                 the altitudes stay, so that each range is a line of its own angle (no shared sums)

#include <span>
#include <string>
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

/// Ranges from 0 to the longest, so dense that no transmission or (relative to a blackbody of the air) radiance of
/// PathTable between them is wrong by more than the tolerance, as found by comparing midpoints. `error` is what was
/// found; above the tolerance when `most` ranges did not do.
struct TableRanges {
  std::vector<double> ranges_m;
  double error = 0.0;
};
TableRanges ranges_for(const Air<double>& air, const Sight<double>& sight, double longest_m, double tolerance,
                       const Interval& band, std::size_t most = 256);

}  // namespace radiometry::atmosphere
