// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/mirror_rays.h"

#include <algorithm>
#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/scene/rays.h"

namespace radiometry::render {

using scene::kNone, scene::Ray, scene::Hit;
using scene::operator+, scene::operator-, scene::operator*;

bool has_angles(const Finish& finish) { return !finish.by_angle.empty() || finish.gloss > 0.0; }

bool has_angles(const RenderScene& scene) {
  return std::any_of(scene.finish.begin(), scene.finish.end(), [](const Finish& one) { return has_angles(one); });
}

MirrorRays mirror_rays(const RenderScene& scene, const Camera& camera, const VisibleParts& parts, int threads) {
  std::vector<bool> wanted;
  for (const Finish& finish : scene.finish) wanted.push_back(has_angles(finish));
  MirrorRays out;
  for (std::uint32_t band = 0; band < parts.band.size(); ++band)
    for (std::uint32_t i = 0; i < parts.band[band].size(); ++i) {
      const std::uint32_t side = parts.band[band][i].side;
      if (side != kNone && wanted[scene.finish_of[side]]) out.of.push_back({band, i});
    }
  out.relative.resize(out.size());
  out.side.assign(out.size(), kNone);
  out.rise.resize(out.size());
  if (out.size() == 0) return out;
  const scene::Beam up(*scene.rays, {0.0, 0.0, 1.0});  // for its lift above surfaces
  std::vector<Ray> rays(out.size());
  mtf::parallel_for_each(static_cast<std::int64_t>(out.size()), 1 << 12, threads, [&](std::size_t k) {
    const SamplePart& part = parts.band[out.of[k].band][out.of[k].part];
    const PlaceInScene place = place_of(scene, camera, part, parts.n);
    const double cosine = std::max(0.0, -scene::dot(place.direction, place.normal));
    out.relative[k] =
        static_cast<float>(relative_emissivity(scene.finish[scene.finish_of[part.side]].by_angle, cosine));
    const Vector mirrored = place.direction + (2.0 * cosine) * place.normal;
    out.rise[k] = static_cast<float>(mirrored[2]);
    rays[k] = {place.point + up.lift_m() * place.normal, mirrored};
  });
  std::vector<Hit> met(out.size());
  scene.rays->first_hits(rays, met, threads);
  for (std::size_t k = 0; k < out.size(); ++k) {
    const std::uint32_t own = parts.band[out.of[k].band][out.of[k].part].side;
    if (!scene::hits(met[k]) || scene.finish[scene.finish_of[own]].gloss <= 0.0) continue;
    std::uint32_t side = 2 * met[k].facet + (met[k].back ? 1U : 0U);
    // The inner side of a solid, which a ray in single precision may meet at an outline: the outer one is meant.
    if (met[k].back && std::isnan(scene.temperature_k[side])) --side;
    out.side[k] = side;
  }
  return out;
}

}  // namespace radiometry::render
