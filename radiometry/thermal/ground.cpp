// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/ground.h"

#include "mtf/error.h"
#include "mtf/words.h"
#include "radiometry/heat/solve.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sky.h"

namespace radiometry::thermal {
namespace {

/// One unit that faces the zenith and sees nothing but the sky.
Units level_unit(const Material& surface) {
  Units units;
  Unit unit;
  unit.front.normal = {0.0, 0.0, 1.0};
  unit.front.absorptance = surface.solar_absorptance;
  unit.front.emissivity = surface.construction.emissivity;
  unit.front.source_w_m2 = surface.source_w_m2;
  units.unit.push_back(unit);
  units.exchange.area_m2 = units.exchange.receiver_area_m2 = {1.0};
  units.exchange.patch_of = {0};
  units.exchange.rows.first = {0, 0};
  return units;
}

/// The plan for another construction with the same cells per length and steps.
heat::Plan plan_like(const heat::Plan& like, const heat::Batch& batch) {
  heat::Plan plan = like;
  plan.batch = batch;
  heat::Grids grids = make_grids(batch.construction, like.request);
  plan.fine = std::move(grids.fine);
  plan.coarse = std::move(grids.coarse);
  return plan;
}

heat::Solution solve_like(const heat::Plan& like, const heat::Batch& batch, const heat::GroupForcing& forcing,
                          const heat::Timeline& timeline, double tolerance_k) {
  constexpr double kStartShare = 0.1;
  heat::Plan plan = plan_like(like, batch);
  heat::Timeline day = timeline;
  day.end_s = timeline.start_s + heat::kDay_s;
  const heat::PeriodicStart start = periodic_start(plan, forcing, day, kStartShare * tolerance_k);
  heat::Run run = advance(plan, start.state, forcing, timeline);
  run.promised.start_k = start.error_k;
  return {std::move(plan), std::move(run)};
}

}  // namespace

LevelRun level_run(const Surroundings& s, double utc_s, const Material& surface, double tolerance_k,
                   const heat::Plan* like) {
  Units units = level_unit(surface);
  units.sun = {1, s.shadow_to_sun.size(), std::vector<std::uint8_t>(s.shadow_to_sun.size(), 1)};
  const GroundLight none{std::vector<double>(s.nodes(), 0.0), std::vector<double>(s.nodes(), 0.0)};
  const PatchLight dark = make_patch_light(units, 0, s.nodes() - 1);
  const heat::GroupForcing forcing =
      forcing_of({{&units.unit.front()}, 0, s.nodes() - 1}, units, s, none, dark, surface, utc_s);
  const heat::Timeline timeline{s.time_s.front(), s.time_s.back(), s.time_s, s.time_s, {}, /*least_lag_s=*/kUsualLag_s};
  const heat::Batch batch{surface.construction, 1, {1.0}};
  std::optional<heat::Solution> solution;
  if (like != nullptr && like->fine.nodes() > 1) {
    solution = solve_like(*like, batch, forcing, timeline, tolerance_k);
    if (solution->run.promised.total_k() > 2.0 * tolerance_k) solution.reset();
  }
  if (!solution) solution = solve(batch, forcing, timeline, heat::RepeatingStart{heat::kDay_s}, tolerance_k);
  LevelRun level;
  level.kelvin = std::move(solution->run.front_k);
  level.run.name = "ground (" + surface.name + ")";
  level.run.units = 1;
  level.run.nodes = solution->plan.fine.nodes();
  level.run.promised = solution->run.promised;
  level.run.steps = solution->run.steps;
  level.run.drift = solution->run.balance.front().relative_drift();
  level.plan = std::move(solution->plan);
  return level;
}

Ground ground_of(const HeatScene& scene, double tolerance_k) {
  const Surroundings& s = scene.surroundings;
  const std::optional<LevelGround>& given = scene.input.ground;
  const Material* surface = given && given->material ? &scene.material[*given->material] : nullptr;
  if (surface != nullptr && surface->construction.is_sheet())
    throw mtf::UsageError("[ground]: material '" + mtf::one_line(surface->name) +
                          "' is a sheet, whose back is exposed; the ground needs another inside, such as adiabatic");
  const double emissivity = surface != nullptr ? surface->construction.emissivity : 1.0;
  const double absorptance = surface != nullptr ? surface->solar_absorptance : 1.0;
  Ground ground;
  std::vector<double> kelvin = s.air_k;
  if (given && !given->temperature.value.empty()) {
    for (std::size_t k = 0; k < kelvin.size(); ++k)
      kelvin[k] = value_at(given->temperature, scene.input.start_s + s.time_s[k]);
  } else if (surface != nullptr) {
    LevelRun level = level_run(s, scene.input.start_s, *surface, tolerance_k);
    kelvin = std::move(level.kelvin);
    ground.run = std::move(level.run);
  }
  for (std::size_t k = 0; k < kelvin.size(); ++k) {
    ground.light.longwave_w_m2.push_back(emissivity * heat::blackbody_w_m2(kelvin[k]) +
                                         (1.0 - emissivity) * s.sky_longwave_w_m2[k]);
    ground.light.solar_w_m2.push_back((1.0 - absorptance) * s.global_w_m2[k]);
  }
  return ground;
}

}  // namespace radiometry::thermal
