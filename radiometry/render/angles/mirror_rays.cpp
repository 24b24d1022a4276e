// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/angles/mirror_rays.h"

#include <algorithm>
#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/scene/pencil.h"

namespace radiometry::render {
namespace {

using scene::kNone, scene::kPencilRays, scene::Ray, scene::Hit;
using scene::operator+, scene::operator-, scene::operator*;

constexpr double kRangeError = 1e-6;  // of a range in single precision, with room

bool has_angles(const Finish& finish) { return !finish.by_angle.empty() || finish.gloss > 0.0; }

}  // namespace

bool has_angles(const RenderScene& scene) {
  return std::any_of(scene.finish.begin(), scene.finish.end(), [](const Finish& one) { return has_angles(one); });
}

MirrorRays mirror_rays(const RenderScene& scene, const Camera& camera, const RayPlan& plan, std::size_t first,
                       const RayHits& hits, int threads) {
  std::vector<bool> wanted;
  for (const Finish& finish : scene.finish) wanted.push_back(has_angles(finish));
  MirrorRays out;
  for (std::size_t i = 0; i < hits.side.size(); ++i)
    if (hits.side[i] != kNone && wanted[scene.finish_of[hits.side[i]]])
      out.ray.push_back(static_cast<std::uint32_t>(i));
  out.relative.resize(out.size());
  out.met.side.assign(out.size(), kNone);
  out.met.height_m.resize(out.size());
  if (out.size() == 0) return out;
  const scene::Beam up(*scene.rays, {0.0, 0.0, 1.0});  // for its lift above surfaces
  std::vector<Ray> rays(out.size());
  mtf::parallel_for(static_cast<std::int64_t>(out.size()), 1 << 12, threads, [&](std::int64_t begin, std::int64_t end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
      const std::size_t i = out.ray[k];
      const RayPlan::Place place = plan.place(first + i / kPencilRays, i % kPencilRays);
      Vector d = camera.direction(place.x, place.y);
      d = (1.0 / scene::length(d)) * d;
      const std::uint32_t side = hits.side[i];
      const Vector normal = (side % 2 == 1 ? -1.0 : 1.0) * scene.facets().facet[side / 2].normal;
      const double cosine = std::max(0.0, -scene::dot(d, normal));
      out.relative[k] = static_cast<float>(relative_emissivity(scene.finish[scene.finish_of[side]].by_angle, cosine));
      const Vector mirrored = d + (2.0 * cosine) * normal;
      out.met.height_m[k] = static_cast<float>(mirrored[2]);
      const auto range_m = static_cast<double>(hits.range_m[i]);
      rays[k] = {camera.position + range_m * d + (up.lift_m() + kRangeError * range_m) * normal, mirrored};
    }
  });
  std::vector<Hit> met(out.size());
  scene.rays->first_hits(rays, met, threads);
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (!scene::hits(met[k]) || scene.finish[scene.finish_of[hits.side[out.ray[k]]]].gloss <= 0.0) continue;
    std::uint32_t side = 2 * met[k].facet + (met[k].back ? 1U : 0U);
    // The inner side of a solid, at an outline: as the rays of the camera (renderer.cpp).
    if (met[k].back && std::isnan(scene.temperature_k[side])) --side;
    out.met.side[k] = side;
  }
  return out;
}

}  // namespace radiometry::render
