// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/light_sources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "radiometry/light/constants.h"

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

using Values = std::vector<double>;

/// Adds share x radiance.
void add(double share, const Values& radiance, Values& sum) {
  if (share == 0.0) return;
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += share * radiance[k];
}

/// eps B + (1 - eps) light.
Values given_off(const Values& emissivity, const Values& blackbody, const Values& light) {
  Values out(light.size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = std::lerp(light[k], blackbody[k], emissivity[k]);
  return out;
}

/// The light of rings and ground on the patch of that row.
Values outside_light(const LightSources& sources, const scene::Views& views, std::size_t row, std::size_t nodes) {
  Values light(nodes, 0.0);
  for (std::size_t r = 0; r < sources.ground(); ++r)
    add(views.sky[row * sources.ground() + r], sources.radiance[r], light);
  add(views.ground[row], sources.radiance[sources.ground()], light);
  return light;
}

double largest_change(const Values& before, const Values& after) {
  double change = 0.0;
  for (std::size_t k = 0; k < before.size(); ++k)
    if (after[k] > 0.0) change = std::max(change, std::abs(after[k] - before[k]) / after[k]);
  return change;
}

void solve_patches(LightSources& sources, const BandNodes& nodes, std::span<const std::vector<double>> emissivity,
                   const Patches& patches, std::span<const double> patch_k, const scene::Views& views) {
  constexpr int kMostIterations = 200;
  constexpr double kEnough = 1e-9;
  std::vector<Values> blackbody, outside;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    blackbody.push_back(blackbody_at(nodes, patch_k[p]));
    outside.push_back(outside_light(sources, views, p, nodes.size()));
    sources.radiance.push_back(blackbody.back());
  }
  for (int i = 0; i < kMostIterations; ++i) {
    sources.change = 0.0;
    for (std::size_t p = 0; p < patches.size(); ++p) {
      Values light = outside[p];
      for (std::uint64_t e = views.patches.first[p]; e < views.patches.first[p + 1]; ++e)
        add(views.patches.value[e], sources.radiance[sources.patch(views.patches.column[e])], light);
      Values next = given_off(emissivity[patches.finish[p]], blackbody[p], light);
      Values& now = sources.radiance[sources.patch(p)];
      sources.change = std::max(sources.change, largest_change(now, next));
      now = std::move(next);
    }
    if (sources.change <= kEnough) return;
  }
}

/// Irradiance per watt per square metre of the sun at the ground, at the nodes.
Values sunlight(const BandNodes& nodes, const AirView* air, const Sun& sun) {
  const double whole = kStefanBoltzmann_w_m2_k4 * std::pow(kSun_k, 4) / std::numbers::pi;
  Values out = blackbody_at(nodes, kSun_k);
  for (double& value : out) value *= sun.direct_w_m2 / whole;
  if (air == nullptr) return out;
  const double zenith = std::acos(std::min(1.0, sun.to_sun[2] / scene::length(sun.to_sun)));
  const auto sight = air->to_space(zenith);
  const double passed = sunlight_passed(air->air(), air->sensor_altitude_m(), zenith);
  const Values transmission = at_nodes(nodes, sight->transmission);
  for (std::size_t k = 0; k < out.size(); ++k) out[k] *= passed > 0.0 ? transmission[k] / passed : 0.0;
  return out;
}

}  // namespace

double sunlight_passed(const atmosphere::Air<double>& air, double altitude_m, double zenith_rad) {
  const auto all = spectral_path(air, atmosphere::Sight<double>(atmosphere::ToSpace<double>{altitude_m, zenith_rad}));
  double light = 0.0, passed = 0.0;
  for (std::size_t i = 0; i + 1 < all.wavenumber_cm.size(); ++i) {
    const double lo = 1e4 / all.wavenumber_cm[i + 1], hi = 1e4 / all.wavenumber_cm[i];
    const double part = (hi - lo) * planck(Flux::watts, 0.5 * (lo + hi), kSun_k);
    light += part;
    passed += part * 0.5 * (all.transmission[i] + all.transmission[i + 1]);
  }
  return passed / light;
}

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

std::vector<double> sky_at(const Sky& sky, const BandNodes& nodes, const AirView* air, double zenith_rad) {
  if (air == nullptr) return blackbody_at(nodes, std::pow(sky.longwave_w_m2 / kStefanBoltzmann_w_m2_k4, 0.25));
  Values clear = at_nodes(nodes, air->to_space(zenith_rad)->source);
  const Values unit = blackbody_at(nodes, air->reference_k()), cloud = blackbody_at(nodes, sky.cloud_k);
  for (std::size_t k = 0; k < clear.size(); ++k) clear[k] = std::lerp(clear[k] * unit[k], cloud[k], sky.cloud_cover);
  return clear;
}

LightSources light_sources(const RenderScene& scene, const BandNodes& nodes,
                           std::span<const std::vector<double>> emissivity, const Patches& patches,
                           std::span<const double> patch_k, const scene::Views& views, const AirView* sky) {
  LightSources sources{.rings = views.rings};
  const double width = 0.5 * std::numbers::pi / views.rings;
  Values whole(nodes.size(), 0.0);  // of the sky, as a level surface sees it
  for (int r = 0; r < views.rings; ++r) {
    sources.radiance.push_back(sky_at(scene.sky, nodes, sky, (r + 0.5) * width));
    add(std::pow(std::sin((r + 1) * width), 2) - std::pow(std::sin(r * width), 2), sources.radiance.back(), whole);
  }
  sources.radiance.push_back(
      given_off(emissivity[scene.ground.finish], blackbody_at(nodes, scene.ground.temperature_k), whole));
  if (views.size() > 0) solve_patches(sources, nodes, emissivity, patches, patch_k, views);
  if (scene.sun && scene.sun->direct_w_m2 > 0.0) sources.sun_irradiance = sunlight(nodes, sky, *scene.sun);
  return sources;
}

}  // namespace radiometry::render
