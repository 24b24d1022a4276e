// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/frame_layers.h"

#include <cmath>
#include <limits>

#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

using scene::kNone;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// An image of value(part).
template <class Value>
mtf::Image made(const LayerInputs& in, const Value& value) {
  mtf::Image image(in.camera.width, in.camera.height);
  mtf::parallel_for(static_cast<std::int64_t>(in.middles.band.size()), 1, in.threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      for (std::int64_t b = begin; b < end; ++b)
                        for (const SamplePart& part : in.middles.band[static_cast<std::size_t>(b)])
                          image.at(part.column, part.row) = value(part);
                    });
  return image;
}

/// Along the ray through the middle of a sample to the plane of the facet that it shows.
double range_of(const LayerInputs& in, const SamplePart& part) {
  using scene::operator-;
  return scene::length(place_of(in.scene, in.camera, part, 1).point - in.camera.position);
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

std::vector<NamedLayer> layers_of(const LayerInputs& in) {
  std::vector<NamedLayer> layers;
  using Part = SamplePart;
  const auto add = [&](const std::string& name, float otherwise, const auto& of_facet) {
    layers.push_back(
        {name, made(in, [&](const Part& part) { return part.side == kNone ? otherwise : of_facet(part); })});
  };
  if (in.choice.temperature)
    add("temperature", kNan, [&](const Part& part) { return in.scene.temperature_k[part.side]; });
  if (in.choice.emissivity) {
    const std::vector<float> value = emissivities(in);
    add("emissivity", kNan, [&](const Part& part) {
      const float along_normal = value[in.sides.number(part.side)];
      const AngularEmissivity& curve = in.scene.finish[in.scene.finish_of[part.side]].by_angle;
      if (curve.empty()) return along_normal;
      const Vector d = in.camera.direction(part.column + 0.5, part.row + 0.5);
      const double cosine = std::abs(scene::dot(d, in.scene.facets().facet[part.side / 2].normal)) / scene::length(d);
      return static_cast<float>(relative_emissivity(curve, cosine)) * along_normal;
    });
  }
  if (in.choice.range)
    layers.push_back({"Z", made(in, [&](const Part& part) {
                        return static_cast<float>(part.side == kNone
                                                      ? in.shader.backdrop().range_m(static_cast<double>(part.height_m))
                                                      : range_of(in, part));
                      })});
  if (in.choice.facet) add("facet", -1.0F, [&](const Part& part) { return static_cast<float>(part.side / 2); });
  if (in.choice.finish)
    add("material", -1.0F, [&](const Part& part) { return static_cast<float>(in.scene.finish_of[part.side]); });
  for (std::size_t axis = 0; in.choice.normal && axis < 3; ++axis)
    add(std::string("normal.") + "XYZ"[axis], 0.0F, [&](const Part& part) {
      const double value = in.scene.facets().facet[part.side / 2].normal[axis];
      return static_cast<float>(part.side % 2 == 1 ? -value : value);
    });
  if (in.surface == nullptr) return layers;
  mtf::Image before(in.camera.width, in.camera.height);
  in.surface->radiance(in.middles, in.sides, in.mirrors, in.shadows, before, in.threads);
  const auto above = [&](const Part& part) { return part.side == kNone && part.height_m >= 0.0F; };
  if (in.choice.surface)
    layers.push_back(
        {"surface", made(in, [&](const Part& part) { return above(part) ? 0.0F : before.at(part.column, part.row); })});
  if (in.choice.transmittance)
    layers.push_back({"transmittance", made(in, [&](const Part& part) {
                        if (above(part)) return 0.0F;
                        const auto height = static_cast<double>(part.height_m);
                        const double path = part.side == kNone
                                                ? in.shader.backdrop().path_radiance(height)
                                                : in.shader.path_radiance(static_cast<double>(part.range_m), height);
                        return static_cast<float>((static_cast<double>(in.radiance.at(part.column, part.row)) - path) /
                                                  static_cast<double>(before.at(part.column, part.row)));
                      })});
  return layers;
}

}  // namespace radiometry::render
