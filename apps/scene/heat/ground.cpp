// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/ground.h"

#include <cmath>

#include "apps/text/words.h"
#include "mtf/error.h"
#include "radiometry/heat/solve.h"
#include "radiometry/heat/weather/instant.h"
#include "radiometry/heat/weather/sky.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

/// One unit that faces the zenith and sees nothing but the sky.
Units level_unit(const Surface& surface) {
  Units units;
  Unit unit;
  unit.front.normal = {0.0, 0.0, 1.0};
  unit.front.absorptance = surface.solar_absorptance;
  unit.front.emissivity = surface.construction.emissivity;
  units.unit.push_back(unit);
  units.exchange.area_m2 = units.exchange.receiver_area_m2 = {1.0};
  units.exchange.patch_of = {0};
  units.exchange.rows.first = {0, 0};
  return units;
}

std::vector<double> solved_temperatures(const HeatScene& scene, const Surface& surface, double tolerance_k,
                                        MaterialRun& run) {
  const Surroundings& s = scene.surroundings;
  Units units = level_unit(surface);
  units.sun = {1, s.shadow_to_sun.size(), std::vector<std::uint8_t>(s.shadow_to_sun.size(), 1)};
  const GroundLight none{std::vector<double>(s.nodes(), 0.0), std::vector<double>(s.nodes(), 0.0)};
  const PatchLight dark = make_patch_light(units, 0, s.nodes() - 1);
  const heat::GroupForcing forcing = forcing_of({{&units.unit.front()}, 0, s.nodes() - 1}, units, s, none, dark,
                                                surface.inside, scene.file.time.start_s);
  const heat::Timeline timeline{s.time_s.front(), s.time_s.back(), s.time_s, s.time_s};
  const heat::Solution solution =
      solve({surface.construction, 1, {1.0}}, forcing, timeline, heat::RepeatingStart{heat::kDay_s}, tolerance_k);
  run.name = "ground (" + surface.name + ")";
  run.units = 1;
  run.nodes = solution.plan.fine.nodes();
  run.promised = solution.run.promised;
  run.steps = solution.run.steps;
  run.start_residual_k = solution.residual_k;
  run.drift = solution.run.balance.front().relative_drift();
  return solution.run.front_k;
}

}  // namespace

Ground ground_of(const HeatScene& scene, double tolerance_k) {
  const Surroundings& s = scene.surroundings;
  const std::optional<GroundSection>& section = scene.file.ground;
  const Surface* surface = section && section->material ? &scene.material[*section->material] : nullptr;
  if (surface != nullptr && surface->construction.is_sheet())
    throw mtf::UsageError("[ground]: material '" + one_line(surface->name) +
                          "' is a sheet, whose back is exposed; the ground needs another inside, such as adiabatic");
  const double emissivity = surface != nullptr ? surface->construction.emissivity : 1.0;
  const double absorptance = surface != nullptr ? surface->solar_absorptance : 1.0;
  Ground ground;
  std::vector<double> kelvin = s.air_k;
  if (section && section->temperature) {
    for (std::size_t k = 0; k < kelvin.size(); ++k)
      kelvin[k] = value_at(section->temperature->schedule, scene.file.time.start_s + s.time_s[k]);
  } else if (surface != nullptr) {
    kelvin = solved_temperatures(scene, *surface, tolerance_k, ground.run.emplace());
  }
  for (std::size_t k = 0; k < kelvin.size(); ++k) {
    ground.light.longwave_w_m2.push_back(emissivity * heat::blackbody_w_m2(kelvin[k]) +
                                         (1.0 - emissivity) * s.sky_longwave_w_m2[k]);
    ground.light.solar_w_m2.push_back((1.0 - absorptance) * s.global_w_m2[k]);
  }
  return ground;
}

}  // namespace apps::scene
