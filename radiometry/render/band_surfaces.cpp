// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/band_surfaces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "radiometry/render/backdrop.h"
#include "radiometry/render/mirror_rays.h"

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

/// `emissivity` of each finish at the nodes along the normal, `hemispherical` its means over the hemisphere;
/// `with_sides`: mirrors show sides.
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

/// What finishes give off to all sides, at the nodes.
std::vector<std::vector<double>> hemispherical_emissivity(const RenderScene& scene,
                                                          std::span<const std::vector<double>> emissivity) {
  std::vector<std::vector<double>> out(emissivity.begin(), emissivity.end());
  for (std::size_t m = 0; m < out.size(); ++m)
    if (!scene.finish[m].by_angle.empty())
      for (double& value : out[m]) value *= hemispherical_mean(scene.finish[m].by_angle);
  return out;
}

/// The light of a mirror of that reflectance: a finish of `reflected`, and the one made for it with the finish that it
/// shows.
SixValues mirrored(const BandSurfaces& surfaces, const BandTables& tables, std::size_t node, std::size_t reflected,
                   bool white, std::size_t finish, const InMirror& mirror) {
  SixValues sum{};
  if (mirror.finish == scene::kNone) {
    const double elevation = std::asin(std::clamp(mirror.rise, -1.0, 1.0));
    if (elevation < 0.0) {
      tables.add_reflected(reflected, surfaces.sources.ground(), 1.0, node, sum);
      return sum;
    }
    const CubicPlace place = elevation_place(elevation);
    for (std::size_t i = 0; i < 4; ++i)
      tables.add_reflected(reflected, surfaces.sources.first_elevation + place.first + i, place.weight[i], node, sum);
    return sum;
  }
  const std::size_t made =
      white ? surfaces.angular.mirrored_in_white(mirror.finish) : surfaces.angular.mirrored(finish, mirror.finish);
  tables.add_reflected(reflected, surfaces.sources.patch(mirror.patch), 1.0, node, sum);
  add(1.0, tables.emitted(made, mirror.temperature_k, node), sum);
  add(-1.0, tables.emitted(made, surfaces.patch_k[mirror.patch], node), sum);
  if (tables.sunny()) add(mirror.sun, tables.sunlit(made, node), sum);
  return sum;
}

}  // namespace

BandSurfaces::BandSurfaces(const SpectralCamera& camera, const RenderScene& scene, const Patches& patches,
                           const scene::Views& views, std::vector<KelvinRange> of_finishes, double ground_m) {
  for (const Finish& finish : scene.finish) curves.push_back(finish.emissivity);
  nodes = band_nodes(camera, curves);
  for (const Spectrum& curve : curves) emissivity.push_back(at_nodes(nodes, curve));
  const std::vector<std::vector<double>> all_sides = hemispherical_emissivity(scene, emissivity);
  angular = angular_finishes(scene, emissivity, all_sides, views.size() > 0);
  emits = emissivity;
  for (const MadeFinish& made : angular.made) emits.push_back(made.emits);
  cover(std::move(of_finishes));
  std::optional<AirView> sky;
  if (scene.air && scene.air->profile.levels.size() > 1) sky.emplace(*scene.air, nodes, scene.altitude_m, ground_m);
  const AirView* above = sky ? &*sky : nullptr;
  patch_k = patch_temperatures_k(scene, patches);
  sources = light_sources(scene, nodes, all_sides, patches, patch_k, views, above);
  if (std::none_of(scene.finish.begin(), scene.finish.end(), [](const Finish& one) { return one.gloss > 0.0; })) return;
  sources.first_elevation = sources.radiance.size();
  for (std::size_t k = 0; k < kSkyElevations; ++k)
    sources.radiance.push_back(sky_at(scene.sky, nodes, above, 0.5 * std::numbers::pi - sky_elevation(k)));
}

/// Finishes that were made for angles have the temperatures of those that they show.
void BandSurfaces::cover(std::vector<KelvinRange> of_finishes) {
  range = std::move(of_finishes);
  std::vector<KelvinRange> ranges = range;
  for (const std::uint32_t like : angular.like)
    ranges.push_back(like == scene::kNone ? KelvinRange{300.0, 300.0} : range[like]);
  folds.emplace(nodes, emits, ranges);
}

BandTables BandSurfaces::tables(const PathGrid& grid, const AirView* view) const {
  return BandTables(nodes, *folds, emissivity, sources, grid, view != nullptr ? view->reference_k() : 300.0,
                    angular.made);
}

SixValues BandSurfaces::seen(const BandTables& tables, std::size_t node, std::size_t finish, const SurfaceLight& light,
                             const SeenAt& at) const {
  const double g = at.relative, gloss = at.gloss;
  const std::size_t white = angular.white();
  SixValues sum = tables.path(node);
  add(g, light.emitted, sum);
  add(g * (1.0 - gloss), light.diffuse, sum);
  add((1.0 - g) * (1.0 - gloss), light.white, sum);
  if (const double sun = (1.0 - gloss) * at.sun; tables.sunny() && sun > 0.0) {
    add(g * sun, tables.sunlit(finish, node), sum);
    add((1.0 - g) * sun, tables.sunlit(white, node), sum);
  }
  if (gloss <= 0.0) return sum;
  if (tables.reflects(finish)) add(g * gloss, mirrored(*this, tables, node, finish, false, finish, at.mirror), sum);
  if (g != 1.0) add((1.0 - g) * gloss, mirrored(*this, tables, node, white, true, finish, at.mirror), sum);
  return sum;
}

}  // namespace radiometry::render
