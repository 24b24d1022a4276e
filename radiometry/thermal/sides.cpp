// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/sides.h"

#include <algorithm>

#include "mtf/error.h"
#include "mtf/words.h"

namespace radiometry::thermal {

namespace geometry = radiometry::scene;
using geometry::Side;

Sides sides_of(const HeatScene& scene) {
  Sides all;
  const auto facets = static_cast<std::uint32_t>(scene.facets().size());
  all.back_of.assign(facets, geometry::kNone);
  for (std::uint32_t f = 0; f < facets; ++f) all.sides.push_back({f, false});
  for (std::uint32_t f = 0; f < facets; ++f)
    if (const std::uint32_t opposite = scene.opposite_of(f); opposite != geometry::kNone) {
      all.back_of[f] = opposite;
    } else if (scene.is_sheet(f)) {
      all.back_of[f] = static_cast<std::uint32_t>(all.sides.size());
      all.sides.push_back({f, true});
    }
  return all;
}

std::vector<int> rays_of(const HeatScene& scene, const Sides& all, int rays) {
  constexpr int kFewer = 16, kLeast = 8;
  std::vector<int> of_side;
  if (!scene.seen.empty())
    for (const Side side : all.sides)
      of_side.push_back(scene.is_seen(side.facet) ? rays : std::min(rays, std::max(kLeast, rays / kFewer)));
  return of_side;
}

std::vector<bool> covered_sides(const geometry::Views& seen) {
  std::vector<bool> covered(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::uint64_t first = seen.patches.first[i], count = seen.patches.first[i + 1] - first;
    covered[i] = seen.ground[i] == 0.0 && seen.sky_share(i) == 0.0 && count == 1 && seen.patches.column[first] == i;
  }
  return covered;
}

geometry::SunVisibility sun_of(const HeatScene& scene, const Sides& all, const geometry::Views& seen,
                               const geometry::SunOptions& options) {
  const std::vector<Side>& sides = all.sides;
  std::vector<Side> open;
  std::vector<std::size_t> row;
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (seen.sky_share(i) > 0.0) {
      open.push_back(sides[i]);
      row.push_back(i);
    }
  const std::vector<geometry::Vector>& to_sun = scene.surroundings.shadow_to_sun;
  const geometry::SunVisibility traced = sun_visibility(scene.rays, open, to_sun, options);
  geometry::SunVisibility sun{options.points, to_sun.size(),
                              std::vector<std::uint8_t>(sides.size() * to_sun.size(), 0)};
  for (std::size_t i = 0; i < row.size(); ++i)
    std::copy_n(traced.lit.begin() + static_cast<std::ptrdiff_t>(i * to_sun.size()), to_sun.size(),
                sun.lit.begin() + static_cast<std::ptrdiff_t>(row[i] * to_sun.size()));
  return sun;
}

void require_room(const HeatScene& scene, const Sides& all) {
  const std::size_t sides = all.sides.size();
  constexpr double kMost = 4.0 * 1024 * 1024 * 1024;
  const double directions = static_cast<double>(scene.surroundings.shadow_to_sun.size());
  const double bytes = 5.0 * static_cast<double>(sides) * directions;
  if (bytes > kMost)
    throw mtf::UsageError(mtf::one_line(scene.input.name) + ": the table of shadows of " + std::to_string(sides) +
                          " surfaces and " + mtf::significant(directions, 6) + " directions of the sun would take " +
                          mtf::significant(bytes / (1024.0 * 1024 * 1024), 3) +
                          " GiB; shorten [time], or ask for fewer directions a day (--sun-directions)");
}

}  // namespace radiometry::thermal
