// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/frame_layers.h"

#include <cmath>
#include <limits>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

using scene::kNone, scene::kPencilRays;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// An image of value(ray).
template <class Value>
mtf::Image made(const Camera& camera, int threads, const Value& value) {
  mtf::Image image(camera.width, camera.height);
  const std::int64_t tiles = (camera.width + 3) / 4;
  mtf::parallel_for((camera.height + 3) / 4, 8, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = 4 * begin; y < std::min(4 * end, camera.height); ++y)
      for (std::int64_t x = 0; x < camera.width; ++x) {
        const std::int64_t ray = (y / 4 * tiles + x / 4) * static_cast<std::int64_t>(kPencilRays) + y % 4 * 4 + x % 4;
        image.at(x, y) = value(static_cast<std::size_t>(ray), x, y);
      }
  });
  return image;
}

/// The emissivity of each visible side, where it was asked for.
std::vector<float> emissivities(const LayerInputs& in) {
  std::vector<float> out(in.sides.size());
  for (std::size_t n = 0; n < out.size(); ++n) {
    const std::uint32_t side = in.sides.side(n);
    out[n] = static_cast<float>(
        in.shader.emissivity(in.scene.finish_of[side], static_cast<double>(in.scene.temperature_k[side])));
  }
  return out;
}

}  // namespace

mtf::Image image_of(const Camera& camera, const std::vector<float>& of_rays, int threads) {
  return made(camera, threads, [&](std::size_t ray, std::int64_t, std::int64_t) { return of_rays[ray]; });
}

std::vector<NamedLayer> layers_of(const LayerInputs& in) {
  std::vector<NamedLayer> layers;
  const auto add = [&](const std::string& name, const auto& of_facet, float otherwise) {
    layers.push_back({name, made(in.camera, in.threads, [&](std::size_t ray, std::int64_t x, std::int64_t y) {
                        return in.hits.side[ray] == kNone ? otherwise : of_facet(ray, x, y);
                      })});
  };
  const auto side = [&](std::size_t ray) { return in.hits.side[ray]; };
  using Index = std::int64_t;
  if (in.choice.temperature)
    add(
        "temperature", [&](std::size_t ray, Index, Index) { return in.scene.temperature_k[side(ray)]; }, kNan);
  if (in.choice.emissivity) {
    const std::vector<float> value = emissivities(in);
    add(
        "emissivity",
        [&](std::size_t ray, Index x, Index y) {
          const float along_normal = value[in.sides.number(side(ray))];
          const AngularEmissivity& curve = in.scene.finish[in.scene.finish_of[side(ray)]].by_angle;
          if (curve.empty()) return along_normal;
          const Vector d = in.camera.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
          const double cosine =
              std::abs(scene::dot(d, in.scene.facets().facet[side(ray) / 2].normal)) / scene::length(d);
          return static_cast<float>(relative_emissivity(curve, cosine)) * along_normal;
        },
        kNan);
  }
  if (in.choice.range)
    layers.push_back(
        {"Z", made(in.camera, in.threads, [&](std::size_t ray, Index x, Index y) {
           if (side(ray) == kNone)
             return static_cast<float>(in.shader.backdrop().range_m(static_cast<double>(in.hits.height_m[ray])));
           const Vector d = in.camera.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
           return static_cast<float>(
               scene::length(d) * scene::distance_to(in.scene.facets(), in.hits.triangle[ray], in.camera.position, d));
         })});
  if (in.choice.facet)
    add(
        "facet", [&](std::size_t ray, Index, Index) { return static_cast<float>(side(ray) / 2); }, -1.0F);
  if (in.choice.finish)
    add(
        "material", [&](std::size_t ray, Index, Index) { return static_cast<float>(in.scene.finish_of[side(ray)]); },
        -1.0F);
  for (std::size_t axis = 0; in.choice.normal && axis < 3; ++axis)
    add(
        std::string("normal.") + "XYZ"[axis],
        [&](std::size_t ray, Index, Index) {
          const double value = in.scene.facets().facet[side(ray) / 2].normal[axis];
          return static_cast<float>(side(ray) % 2 == 1 ? -value : value);
        },
        0.0F);
  if (in.surface == nullptr) return layers;
  std::vector<float> before;
  in.surface->radiance(in.hits, in.sides, before, in.threads);
  in.surface->add_angles(in.mirrors, in.hits, in.sides, before, in.threads);
  const auto above = [&](std::size_t ray) { return side(ray) == kNone && in.hits.height_m[ray] >= 0.0F; };
  if (in.choice.surface)
    layers.push_back({"surface", made(in.camera, in.threads,
                                      [&](std::size_t ray, Index, Index) { return above(ray) ? 0.0F : before[ray]; })});
  if (in.choice.transmittance)
    layers.push_back(
        {"transmittance", made(in.camera, in.threads, [&](std::size_t ray, Index, Index) {
           if (above(ray)) return 0.0F;
           const auto height = static_cast<double>(in.hits.height_m[ray]);
           const double path = side(ray) == kNone
                                   ? in.shader.backdrop().path_radiance(height)
                                   : in.shader.path_radiance(static_cast<double>(in.hits.range_m[ray]), height);
           return static_cast<float>((static_cast<double>(in.radiance[ray]) - path) / static_cast<double>(before[ray]));
         })});
  return layers;
}

}  // namespace radiometry::render
