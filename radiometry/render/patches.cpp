// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace radiometry::render {
namespace {

using Key = std::array<std::int64_t, 4>;  // finish, mesh, front or back, step of temperature

Key key_of(const RenderScene& scene, std::size_t side, double step_k) {
  return {scene.finish_of[side], scene.facets().facet[side / 2].mesh, static_cast<std::int64_t>(side % 2),
          static_cast<std::int64_t>(std::floor(static_cast<double>(scene.temperature_k[side]) / step_k))};
}

/// The number of each patch by its key, in the order of keys.
std::map<Key, std::uint32_t> numbered(const RenderScene& scene, double step_k) {
  std::map<Key, std::uint32_t> number;
  for (std::size_t s = 0; s < scene.temperature_k.size(); ++s)
    if (!std::isnan(scene.temperature_k[s])) number.try_emplace(key_of(scene, s, step_k));
  std::uint32_t next = 0;
  for (auto& [key, value] : number) value = next++;
  return number;
}

}  // namespace

Patches patches_by_temperature(const RenderScene& scene, std::size_t most) {
  constexpr double kLeast_k = 1.0, kMost_k = 1e4;
  Patches patches{.step_k = kLeast_k};
  std::map<Key, std::uint32_t> number = numbered(scene, patches.step_k);
  while (number.size() > most && patches.step_k < kMost_k) {
    patches.step_k *= 2.0;
    number = numbered(scene, patches.step_k);
  }
  for (const auto& [key, value] : number) patches.finish.push_back(static_cast<std::uint32_t>(key[0]));
  std::vector<scene::Side> sides;
  std::vector<std::uint32_t> set_of;
  patches.patch_of.assign(scene.temperature_k.size(), scene::kNone);
  for (std::size_t s = 0; s < patches.patch_of.size(); ++s) {
    if (std::isnan(scene.temperature_k[s])) continue;
    patches.patch_of[s] = number.at(key_of(scene, s, patches.step_k));
    sides.push_back({static_cast<std::uint32_t>(s / 2), s % 2 == 1});
    set_of.push_back(patches.patch_of[s]);
  }
  patches.sides = scene::sets_of_sides(sides, set_of, patches.size());
  return patches;
}

std::vector<double> patch_temperatures_k(const RenderScene& scene, const Patches& patches) {
  std::vector<double> mean_k;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    // About the first one: patches of one temperature have exactly that.
    const double first_k = scene.temperature_k[index(patches.sides[p].front())];
    double area = 0.0, sum = 0.0;
    for (const scene::Side& side : patches.sides[p]) {
      const double of = scene.facets().facet[side.facet].area_m2;
      area += of;
      sum += of * (static_cast<double>(scene.temperature_k[index(side)]) - first_k);
    }
    mean_k.push_back(first_k + sum / area);
  }
  return mean_k;
}

bool still_alike(const RenderScene& scene, const Patches& patches) {
  constexpr double kLeast_k = 2.0;
  constexpr std::size_t kMost = 100;  // one in so many may be farther
  const double limit = std::max(patches.step_k, kLeast_k);
  const std::vector<double> mean_k = patch_temperatures_k(scene, patches);
  std::size_t sides = 0, far = 0;
  for (std::size_t s = 0; s < patches.patch_of.size(); ++s) {
    if (patches.patch_of[s] == scene::kNone) continue;
    ++sides;
    far += std::abs(static_cast<double>(scene.temperature_k[s]) - mean_k[patches.patch_of[s]]) > limit ? 1 : 0;
  }
  return kMost * far <= sides;
}

}  // namespace radiometry::render
