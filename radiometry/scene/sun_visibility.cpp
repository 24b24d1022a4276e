// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/sun_visibility.h"

#include <algorithm>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/scene/tracing/embree_scene.h"
#include "radiometry/scene/tracing/ray_sampling.h"

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

/// By how much the course of the sun may come nearer to a plane than both its neighbours in the list, as a sine:
/// between two directions an angle a apart 1 - cos(a / 2), and the course bends no more than twice as much.
std::vector<double> bends(const std::vector<Vector>& directions) {
  std::vector<double> bend(directions.size(), 0.0);
  for (std::size_t d = 0; d + 1 < directions.size(); ++d) {
    const double half = 0.5 * length(directions[d + 1] - directions[d]);
    for (const std::size_t end : {d, d + 1}) bend[end] = std::max(bend[end], half * half);
  }
  return bend;
}

/// The cosines of all directions with a side.
std::vector<double> cosines(const Facets& facets, const Side& side, const std::vector<Vector>& directions) {
  std::vector<double> cosine;
  for (const Vector& direction : directions)
    cosine.push_back((side.back ? -1.0 : 1.0) * dot(facets.facet[side.facet].normal, direction));
  return cosine;
}

/// The neighbour of a direction in the list that is before the side; the direction itself where none is.
std::size_t facing_neighbour(const std::vector<double>& cosine, std::size_t d) {
  if (d + 1 < cosine.size() && cosine[d + 1] > 0.0) return d + 1;
  return d > 0 && cosine[d - 1] > 0.0 ? d - 1 : d;
}

/// The points of the sides [begin, end), `points` for each.
std::vector<Point> starts_on(const Rays& rays, std::span<const Side> sides, std::size_t begin, std::size_t end,
                             const SunOptions& options) {
  std::vector<Point> starts;
  starts.reserve((end - begin) * static_cast<std::size_t>(options.points));
  for (std::size_t i = begin; i < end; ++i) {
    const ReceiverSurface surface(rays.facets(), sides.subspan(i, 1), rays.embree().lift_m());
    const SpreadNumbers<2> numbers(index(sides[i]), options.seed);
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
  const std::vector<double> bend = bends(directions);
  SunVisibility sun{.points = options.points,
                    .directions = directions.size(),
                    .lit = std::vector<std::uint8_t>(sides.size() * directions.size(), 0)};

  const auto points = static_cast<std::size_t>(options.points);
  mtf::parallel_for(static_cast<std::int64_t>(sides.size()), 64, options.threads,
                    [&](std::int64_t first, std::int64_t last) {
                      const auto begin = static_cast<std::size_t>(first), end = static_cast<std::size_t>(last);
                      const std::vector<Point> starts = starts_on(rays, sides, begin, end, options);
                      ShadowRays shadow_rays(rays.embree(), sun);
                      std::vector<std::vector<double>> cosine;
                      for (std::size_t i = begin; i < end; ++i) cosine.push_back(cosines(facets, sides[i], directions));
                      for (std::size_t d = 0; d < directions.size(); ++d) {
                        if (directions[d][2] <= 0.0) continue;
                        for (std::size_t i = begin; i < end; ++i) {
                          const double c = cosine[i - begin][d];
                          if (c <= -bend[d] || (c <= 0.0 && facing_neighbour(cosine[i - begin], d) != d)) continue;
                          const Vector normal = (sides[i].back ? -1.0 : 1.0) * facets.facet[sides[i].facet].normal;
                          const Vector towards = c > 0.0 ? directions[d] : unit(directions[d] - c * normal);
                          if (!(towards[2] > 0.0)) continue;
                          for (std::size_t p = 0; p < points; ++p)
                            shadow_rays.add(rays.embree().single(starts[(i - begin) * points + p], towards),
                                            i * directions.size() + d);
                        }
                        shadow_rays.trace();
                      }
                      for (std::size_t i = begin; i < end; ++i)
                        for (std::size_t d = 0; d < directions.size(); ++d)
                          if (cosine[i - begin][d] <= 0.0 && directions[d][2] > 0.0)
                            if (const std::size_t from = facing_neighbour(cosine[i - begin], d); from != d)
                              sun.lit[i * directions.size() + d] = sun.lit[i * directions.size() + from];
                    });
  return sun;
}

}  // namespace radiometry::scene
