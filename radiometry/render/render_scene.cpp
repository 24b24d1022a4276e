// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/render_scene.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/units.h"

namespace radiometry::render {
namespace {

constexpr double kHottest_k = 3000.0;

[[noreturn]] void refuse(const std::string& what) { throw mtf::UsageError("render: " + what); }

void require_temperature(double kelvin, const char* what) {
  if (!(kelvin >= 0.0 && kelvin <= kHottest_k))
    refuse(std::string(what) + " of " + mtf::format_double(kelvin) + " K; a temperature is from 0 to " +
           mtf::format_double(kHottest_k) + " K");
}

}  // namespace

void require_valid_surroundings(const RenderScene& scene) {
  for (const Finish& finish : scene.finish) {
    make_spectrum(finish.name + ": emissivity", finish.emissivity.wavelength_um, finish.emissivity.value, 1.0);
    if (!(finish.gloss >= 0.0 && finish.gloss <= 1.0))
      refuse(finish.name + ": a gloss of " + mtf::format_double(finish.gloss) + "; it is from 0 to 1");
    const double most = *std::max_element(finish.emissivity.value.begin(), finish.emissivity.value.end());
    if (largest(finish.by_angle) * most > 1.0 + 1e-6)
      refuse(finish.name + ": its emissivity by angle reaches " + mtf::format_double(largest(finish.by_angle)) +
             " times " + mtf::format_double(most) + ", which is above 1");
  }
  if (scene.ground.finish >= scene.finish.size()) refuse("the ground has no finish");
  require_temperature(scene.ground.temperature_k, "a ground");
  require_temperature(scene.sky.cloud_k, "clouds");
  if (!(scene.sky.cloud_cover >= 0.0 && scene.sky.cloud_cover <= 1.0))
    refuse("a cloud cover of " + mtf::format_double(scene.sky.cloud_cover) + "; it is from 0 to 1");
  if (!(scene.sky.longwave_w_m2 >= 0.0 && std::isfinite(scene.sky.longwave_w_m2)))
    refuse("a sky of " + mtf::format_double(scene.sky.longwave_w_m2) + " W/m2; it has to be 0 or more");
  if (!scene.sun) return;
  if (!(scene.sun->direct_w_m2 >= 0.0 && std::isfinite(scene.sun->direct_w_m2)))
    refuse("a sun of " + mtf::format_double(scene.sun->direct_w_m2) + " W/m2; it has to be 0 or more");
  if (!scene::finite(scene.sun->to_sun) || !(scene.sun->to_sun[2] > 0.0))
    refuse("the direction to the sun is not finite, or below the horizon");
}

void require_valid(const RenderScene& scene) {
  if (scene.rays == nullptr) refuse("there are no facets");
  const std::size_t sides = 2 * scene.facets().size();
  if (scene.finish_of.size() != sides || scene.temperature_k.size() != sides)
    refuse("there are " + std::to_string(sides) + " sides, " + std::to_string(scene.finish_of.size()) +
           " finishes and " + std::to_string(scene.temperature_k.size()) + " temperatures of sides");
  for (std::size_t s = 0; s < sides; ++s) {
    const auto kelvin = static_cast<double>(scene.temperature_k[s]);
    if (scene.finish_of[s] >= scene.finish.size())
      refuse("facet " + std::to_string(s / 2) + " has finish " + std::to_string(scene.finish_of[s]) + " of " +
             std::to_string(scene.finish.size()));
    if (!std::isnan(kelvin))
      require_temperature(kelvin, ("facet " + std::to_string(s / 2) + " with a temperature").c_str());
  }
  require_valid_surroundings(scene);
}

void require_outside(const RenderScene& scene, const scene::Point& camera) {
  // At an outline single precision may meet the inner side of a facet that faces away, and something else may stand in
  // the solid too.
  constexpr int kLeast = 3;
  int inside = 0;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const scene::Hit hit = scene.rays->first_hit({camera, {x + 0.1, y + 0.02, z + 0.003}});
        if (!scene::hits(hit) || !std::isnan(scene.temperature_k[scene::index({hit.facet, hit.back})])) continue;
        if (++inside < kLeast) continue;
        throw mtf::UsageError("the camera stands in a solid, of mesh '" +
                              scene.facets().report[scene.facets().facet[hit.facet].mesh].name + "': it sees facet " +
                              std::to_string(hit.facet) + " from the inside; move the camera out");
      }
}

}  // namespace radiometry::render
