// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/angles/angular_finishes.h"

#include "radiometry/render/angles/mirror_rays.h"

namespace radiometry::render {
namespace {

using Values = std::vector<double>;

/// What a finish of that emissivity adds where a mirror with `reflects` shows it.
MadeFinish seen_in(const Values& reflects, const Values& emissivity) {
  MadeFinish out;
  for (std::size_t k = 0; k < reflects.size(); ++k) {
    out.emits.push_back(reflects[k] * emissivity[k]);
    out.reflects.push_back(reflects[k] * (1.0 - emissivity[k]));
  }
  return out;
}

}  // namespace

AngularFinishes angular_finishes(const RenderScene& scene, std::span<const std::vector<double>> emissivity,
                                 std::span<const std::vector<double>> hemispherical, bool with_sides) {
  AngularFinishes out;
  if (!has_angles(scene)) return out;
  out.finishes = scene.finish.size();
  const std::size_t nodes = emissivity.front().size();
  const Values ones(nodes, 1.0);
  out.made.push_back({Values(nodes, 0.0), ones, true});
  out.like.push_back(scene::kNone);
  if (!with_sides) return out;
  const auto add = [&](const Values& reflects) {
    for (std::size_t f = 0; f < out.finishes; ++f) {
      out.made.push_back(seen_in(reflects, hemispherical[f]));
      out.like.push_back(static_cast<std::uint32_t>(f));
    }
  };
  std::size_t rows = 0;
  for (std::size_t m = 0; m < out.finishes; ++m) {
    if (scene.finish[m].gloss <= 0.0) {
      out.row.push_back(~std::size_t{0});
      continue;
    }
    out.row.push_back(rows++);
    Values missing;
    for (const double value : emissivity[m]) missing.push_back(1.0 - value);
    add(missing);
  }
  if (rows > 0) add(ones);
  return out;
}

std::vector<std::vector<double>> hemispherical_emissivity(const RenderScene& scene,
                                                          std::span<const std::vector<double>> emissivity) {
  std::vector<std::vector<double>> out(emissivity.begin(), emissivity.end());
  for (std::size_t m = 0; m < out.size(); ++m)
    if (!scene.finish[m].by_angle.empty())
      for (double& value : out[m]) value *= hemispherical_mean(scene.finish[m].by_angle);
  return out;
}

}  // namespace radiometry::render
