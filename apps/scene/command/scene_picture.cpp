// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/scene_picture.h"

#include <algorithm>

#include "apps/figures/picture.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/image.h"

namespace apps::scene {
namespace {

namespace geometry = radiometry::scene;
using geometry::Vector;

constexpr std::int64_t kWidth = 1280, kHeight = 960;
constexpr double kHalfWidth = 0.364;  // tan 20 deg

Vector unit(const Vector& v) {
  const double size = geometry::length(v);
  return {v[0] / size, v[1] / size, v[2] / size};
}

std::vector<geometry::Ray> camera_rays(const std::string& name, const CameraSection& camera) {
  using geometry::operator-, geometry::operator+, geometry::operator*;
  const Vector forward = camera.look_at_m - camera.position_m;
  const Vector across = geometry::cross(forward, camera.up);
  if (!(geometry::length(forward) > 0.0) || !(geometry::length(across) > 0.0))
    throw mtf::UsageError(one_line(name) +
                          ": [camera]: it looks at itself or along `up`; move look_at or choose another up");
  const Vector ahead = unit(forward), right = unit(across), up = geometry::cross(right, ahead);
  std::vector<geometry::Ray> rays;
  for (std::int64_t y = 0; y < kHeight; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x) {
      const double u = (2.0 * (static_cast<double>(x) + 0.5) / kWidth - 1.0) * kHalfWidth;
      const double v = (1.0 - 2.0 * (static_cast<double>(y) + 0.5) / kHeight) * kHalfWidth * kHeight / kWidth;
      rays.push_back({camera.position_m, ahead + u * right + v * up});
    }
  return rays;
}

}  // namespace

std::vector<geometry::Hit> camera_hits(const HeatScene& scene, const CameraSection& camera) {
  const std::vector<geometry::Ray> rays = camera_rays(scene.input.name, camera);
  std::vector<geometry::Hit> hits(rays.size());
  scene.rays.first_hits(rays, hits);
  if (std::none_of(hits.begin(), hits.end(), [](const geometry::Hit& hit) { return geometry::hits(hit); })) return {};
  return hits;
}

std::optional<std::string> mesh_around_camera(const HeatScene& scene, std::span<const geometry::Hit> hits) {
  const geometry::Facets& facets = scene.facets();
  std::vector<std::size_t> inside(facets.report.size(), 0);
  for (const geometry::Hit& hit : hits)
    if (geometry::hits(hit) && hit.back && facets.shells[facets.facet[hit.facet].shell].closed)
      ++inside[facets.facet[hit.facet].mesh];
  const auto most = std::max_element(inside.begin(), inside.end());
  if (most == inside.end() || 2 * *most <= hits.size()) return std::nullopt;
  return facets.report[static_cast<std::size_t>(most - inside.begin())].name;
}

void write_scene_picture(const std::string& path, std::span<const geometry::Hit> hits, std::span<const double> facet_k,
                         const std::string& caption) {
  std::vector<float> seen;
  for (const geometry::Hit& hit : hits)
    if (geometry::hits(hit)) seen.push_back(static_cast<float>(facet_k[hit.facet]));
  // A hundredth of the pixels may be clipped at each end: single hot facets would take all of the colours.
  std::sort(seen.begin(), seen.end());
  const double low = seen[seen.size() / 100], high = seen[seen.size() - 1 - seen.size() / 100];
  mtf::Image image(kWidth, kHeight);
  for (std::int64_t y = 0; y < kHeight; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x) {
      const geometry::Hit& hit = hits[static_cast<std::size_t>(y * kWidth + x)];
      image.at(x, y) = geometry::hits(hit) ? static_cast<float>(facet_k[hit.facet]) : static_cast<float>(low);
    }
  write_picture(path, std::array{Panel{caption, image.view(), 1, low, std::max(high, low + 0.1), ""}}, true);
}

}  // namespace apps::scene
