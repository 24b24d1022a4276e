// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/frame_rays.h"

#include <bit>
#include <cmath>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

using scene::kNone, scene::kPencilRays;
using scene::operator+, scene::operator*;

constexpr double kRangeError = 1e-6;  // of a range in single precision, with room: what starts there lies above it
constexpr std::int64_t kTile = 4;
constexpr std::int64_t kChunk = 256;  // packets
static_assert(kTile * kTile == kPencilRays);

}  // namespace

void RayHits::resize(std::size_t packets, bool triangles) {
  side.resize(packets * kPencilRays);
  range_m.resize(side.size());
  height_m.resize(side.size());
  triangle.resize(triangles ? side.size() : 0);
  lit.clear();
}

RayPlan RayPlan::tiles(const Camera& camera) {
  RayPlan plan;
  plan.width_ = camera.width;
  plan.height_ = camera.height;
  plan.tiles_ = (camera.width + kTile - 1) / kTile;
  plan.packets_ = static_cast<std::size_t>(plan.tiles_ * ((camera.height + kTile - 1) / kTile));
  return plan;
}

RayPlan RayPlan::further(const Camera& camera, std::vector<std::uint32_t> samples, int n) {
  RayPlan plan;
  plan.width_ = camera.width;
  plan.height_ = camera.height;
  plan.n_ = n;
  plan.samples_ = std::move(samples);
  const auto each = static_cast<std::size_t>(n * n);
  plan.packets_ = (plan.samples_.size() * each + kPencilRays - 1) / kPencilRays;
  return plan;
}

RayPlan::Place RayPlan::place(std::size_t packet, std::size_t lane) const {
  if (n_ == 1) {
    const auto tile = static_cast<std::int64_t>(packet), in = static_cast<std::int64_t>(lane);
    const std::int64_t x = tile % tiles_ * kTile + in % kTile, y = tile / tiles_ * kTile + in / kTile;
    const bool inside = x < width_ && y < height_;
    return {inside ? static_cast<std::uint32_t>(y * width_ + x) : kNone, static_cast<double>(x) + 0.5,
            static_cast<double>(y) + 0.5};
  }
  const std::size_t ray = packet * kPencilRays + lane, each = static_cast<std::size_t>(n_ * n_), at = ray / each;
  const std::uint32_t sample = samples_[std::min(at, samples_.size() - 1)];
  const auto part = static_cast<int>(ray % each);
  return {at < samples_.size() ? sample : kNone, static_cast<double>(sample % width_) + (part % n_ + 0.5) / n_,
          static_cast<double>(sample / width_) + (part / n_ + 0.5) / n_};
}

void trace_rays(const scene::Rays& rays, const Camera& camera, const RayPlan& plan, std::size_t first, RayHits& hits,
                int threads) {
  const scene::Pencil pencil(rays, camera.position);
  const scene::Facets& facets = rays.facets();
  const auto height = static_cast<float>(camera.position[2]);
  mtf::parallel_for(
      static_cast<std::int64_t>(hits.packets()), kChunk, threads, [&](std::int64_t begin, std::int64_t end) {
        scene::PencilDirections directions{.count = kPencilRays};
        scene::PencilHits met;
        for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p) {
          for (std::size_t lane = 0; lane < kPencilRays; ++lane) {
            const RayPlan::Place place = plan.place(first + p, lane);
            const Vector d = camera.direction(place.x, place.y);
            directions.x[lane] = static_cast<float>(d[0]);
            directions.y[lane] = static_cast<float>(d[1]);
            directions.z[lane] = static_cast<float>(d[2]);
          }
          pencil.trace(directions, met);
          for (std::size_t lane = 0; lane < kPencilRays; ++lane) {
            const std::size_t i = p * kPencilRays + lane;
            const float x = directions.x[lane], y = directions.y[lane], z = directions.z[lane];
            const float size = std::sqrt(x * x + y * y + z * z);
            const std::uint32_t triangle = met.triangle[lane];
            if (!hits.triangle.empty()) hits.triangle[i] = triangle;
            hits.range_m[i] = met.length[lane] * size;
            hits.side[i] = triangle == kNone ? kNone : 2 * facets.facet_of[triangle] + (met.back >> lane & 1U);
            hits.height_m[i] = triangle == kNone ? z / size : height + met.length[lane] * z;
          }
        }
      });
}

void trace_shadows(const scene::Rays& rays, const Camera& camera, const RayPlan& plan, std::size_t first,
                   const scene::Vector& to_sun, RayHits& hits, int threads) {
  const scene::Beam beam(rays, to_sun);
  const scene::Facets& facets = rays.facets();
  hits.lit.assign(hits.side.size(), 0);
  mtf::parallel_for(static_cast<std::int64_t>(hits.packets()), kChunk, threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      std::array<Point, kPencilRays> from;
                      std::array<std::size_t, kPencilRays> of{};
                      std::size_t count = 0;
                      const auto trace = [&] {
                        const std::uint32_t blocked = beam.blocked(std::span<const Point>(from).first(count));
                        for (std::size_t k = 0; k < count; ++k) hits.lit[of[k]] = (blocked >> k & 1U) == 0U ? 1 : 0;
                        count = 0;
                      };
                      for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p)
                        for (std::size_t lane = 0; lane < kPencilRays; ++lane) {
                          const std::size_t i = p * kPencilRays + lane;
                          if (hits.side[i] == kNone) continue;
                          const scene::Facet& facet = facets.facet[hits.side[i] / 2];
                          const double side = hits.side[i] % 2 == 1 ? -1.0 : 1.0;
                          if (!(side * scene::dot(facet.normal, beam.direction()) > 0.0)) continue;
                          const RayPlan::Place place = plan.place(first + p, lane);
                          const Vector d = camera.direction(place.x, place.y);
                          const auto range_m = static_cast<double>(hits.range_m[i]);
                          from[count] = camera.position + (range_m / scene::length(d)) * d +
                                        (side * (beam.lift_m() + kRangeError * range_m)) * facet.normal;
                          of[count++] = i;
                          if (count == kPencilRays) trace();
                        }
                      if (count > 0) trace();
                    });
}

}  // namespace radiometry::render
