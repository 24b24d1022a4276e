// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sampling error of tables of views and of visibility, from a second independent set with twice the rays (and, of
// the sun, at other directions too) on facets picked at random. The difference of two sets has the variance of both; it
// is reported as it is, so that the error of the first one is overstated by a factor of 1.1 to 1.2. Two sets of few
// sides may agree by chance. A scene of few sides has many rays of each (2048 or more): the second set of views is then
// eight independent ones, and the variance of their mean, over the number of sides, is added to the squares.

#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/scene/sun_visibility.h"
#include "radiometry/scene/views.h"

namespace radiometry::scene {

/// Over `count` sides, which is all of them where the scene has fewer than were asked for.
struct TableError {
  double rms = 0.0;
  double percentile_95 = 0.0;  ///< of the absolute difference
  std::size_t count = 0;
};

/// Of `count` sides from differences of one or more of each; `variance`: of what they were compared with, summed over
/// sides.
TableError error_of(std::vector<double> differences, double variance, std::size_t count);

/// Of the view of the whole sky, and of other surfaces.
struct ViewError {
  TableError sky, surfaces;
};

/// What is added to the seed of a set for another one.
inline constexpr std::uint64_t kOtherSet = 0x9e3779b97f4a7c15;

/// The options of the second set, as one or eight.
std::vector<ViewOptions> other_sets(const ViewOptions& options);
/// A value by each of them.
struct OtherSets {
  int count = 0;
  double mean = 0.0, squares = 0.0;  ///< of differences from the mean
  void add(double value) {
    const double from = value - mean;
    mean += from / ++count;
    squares += from * (value - mean);
  }
  double variance() const { return count < 2 ? 0.0 : squares / (count * (count - 1.0)); }  ///< of the mean
};

/// `views` was made of `receivers` with `options`; of those among the receivers, where they are named.
ViewError view_error(const Rays& rays, const Receivers& receivers, const Views& views, const ViewOptions& options,
                     std::size_t count = 2000, std::span<const std::uint32_t> among = {});

/// A direction to the sun, of length 1, and its place in the table: after an entry, by a share of the time to the next.
struct SunCheck {
  Vector to_sun{};
  std::size_t entry = 0;
  double share = 0.0;
};

struct SunError {
  TableError of_directions;  ///< over sides and those directions that they face
  TableError of_sides;       ///< over sides, of the largest of all directions
};
/// Of the irradiance by the sun as a share of the direct normal irradiance, visibility times cosine. `sun` was made of
/// `sides` with `options`.
SunError sun_error(const Rays& rays, std::span<const Side> sides, std::span<const SunCheck> checks,
                   const SunVisibility& sun, const SunOptions& options, std::size_t count = 2000);

}  // namespace radiometry::scene
