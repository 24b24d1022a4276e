// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/sun_visibility.h"

#include <algorithm>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/scene/tracing/embree_scene.h"
#include "radiometry/scene/tracing/sampling.h"

namespace radiometry::scene {
namespace {

std::vector<Vector> unit_directions(std::span<const Vector> to_sun) {
  std::vector<Vector> directions(to_sun.begin(), to_sun.end());
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const double norm = length(directions[d]);
    if (!(norm > 1e-150 && norm < 1e150))
      throw mtf::UsageError("sun_visibility: direction " + std::to_string(d) +
                            " has no length from 1e-150 to 1e150, or a component that is not finite.");
    directions[d] = (1.0 / norm) * directions[d];
  }
  return directions;
}

/// The points of the sides [begin, end), `points` for each.
std::vector<Point> starts_on(const Rays& rays, std::span<const Side> sides, std::size_t begin, std::size_t end,
                             const SunOptions& options) {
  std::vector<Point> starts;
  starts.reserve((end - begin) * static_cast<std::size_t>(options.points));
  for (std::size_t i = begin; i < end; ++i) {
    const ReceiverSurface surface(rays.facets(), sides.subspan(i, 1), rays.embree().lift_m());
    const SpreadNumbers<2> numbers(i, options.seed);
    for (int p = 0; p < options.points; ++p) {
      const auto [u, v] = numbers(static_cast<std::uint64_t>(p));
      starts.push_back(surface.at(u, v).point);
    }
  }
  return starts;
}

/// Rays of one direction, traced as soon as a packet is full.
class ShadowRays {
 public:
  ShadowRays(const EmbreeScene& embree, SunVisibility& sun) : embree_(embree), sun_(sun) {}
  void add(const SingleRay& ray, std::size_t cell) {
    packet_[count_] = ray;
    cell_[count_] = cell;
    if (++count_ == kPacket) trace();
  }
  void trace() {
    if (count_ == 0) return;
    const std::uint32_t blocked = embree_.blocked(std::span(packet_).first(count_));
    for (std::size_t k = 0; k < count_; ++k)
      if ((blocked >> k & 1U) == 0U) ++sun_.lit[cell_[k]];
    count_ = 0;
  }

 private:
  const EmbreeScene& embree_;
  SunVisibility& sun_;
  std::array<SingleRay, kPacket> packet_;
  std::array<std::size_t, kPacket> cell_{};
  std::size_t count_ = 0;
};

}  // namespace

SunVisibility sun_visibility(const Rays& rays, std::span<const Side> sides, std::span<const Vector> to_sun,
                             const SunOptions& options) {
  if (options.points < 1 || options.points > 255)
    throw mtf::UsageError("sun_visibility: the number of points is " + std::to_string(options.points) +
                          ", it must be 1 to 255.");
  const Facets& facets = rays.facets();
  for (const Side& side : sides)
    if (side.facet >= facets.size())
      throw mtf::UsageError("sun_visibility: there is no facet " + std::to_string(side.facet));
  const std::vector<Vector> directions = unit_directions(to_sun);
  SunVisibility sun{.points = options.points,
                    .directions = directions.size(),
                    .lit = std::vector<std::uint8_t>(sides.size() * directions.size(), 0)};

  const auto points = static_cast<std::size_t>(options.points);
  mtf::parallel_for(static_cast<std::int64_t>(sides.size()), 64, options.threads,
                    [&](std::int64_t first, std::int64_t last) {
                      const auto begin = static_cast<std::size_t>(first), end = static_cast<std::size_t>(last);
                      const std::vector<Point> starts = starts_on(rays, sides, begin, end, options);
                      ShadowRays shadow_rays(rays.embree(), sun);
                      for (std::size_t d = 0; d < directions.size(); ++d) {
                        if (directions[d][2] <= 0.0) continue;
                        for (std::size_t i = begin; i < end; ++i) {
                          const double cosine = dot(facets.facet[sides[i].facet].normal, directions[d]);
                          if ((sides[i].back ? -cosine : cosine) <= 0.0) continue;
                          for (std::size_t p = 0; p < points; ++p)
                            shadow_rays.add(rays.embree().single(starts[(i - begin) * points + p], directions[d]),
                                            i * directions.size() + d);
                        }
                        shadow_rays.trace();
                      }
                    });
  return sun;
}

}  // namespace radiometry::scene
