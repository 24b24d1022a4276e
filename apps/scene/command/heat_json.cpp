// SPDX-License-Identifier: Apache-2.0

#include "apps/scene/command/heat_files.h"
#include "apps/text/json.h"
#include "mtf/version.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr const char* kEvaporation = "bulk, w h / gamma (e_s(T) - e), h of the wind, FAO-56 gamma, Magnus over water";

Json closures(const SceneFile& file, const HeatScene& scene) {
  Json materials = Json::array();
  for (std::size_t i = 0; i < file.materials.size(); ++i) {
    const Material& material = scene.material[i];
    materials.push_back({{"material", material.name},
                         {"convection", name_of(material.construction.convection)},
                         {"inside", kInsideNames.at(static_cast<std::size_t>(file.materials[i].inside.kind))},
                         {"solar_absorptance", material.solar_absorptance},
                         {"emissivity", material.construction.emissivity},
                         {"evaporation", material.construction.is_wet() ? kEvaporation : "none"},
                         {"wet_fraction", material.construction.wet_fraction}});
  }
  const std::optional<GroundSection>& ground = file.ground;
  return {{"materials", materials},
          {"sky_longwave", kLongwaveNames.at(static_cast<std::size_t>(file.sky.longwave))},
          {"cloud", kCloudNames.at(static_cast<std::size_t>(file.sky.cloud))},
          {"sky_radiance", "isotropic"},
          {"sun", "point, visibility linear in time between the directions of the table"},
          {"ground", !ground               ? "black, at the temperature of the air"
                     : ground->temperature ? "of given temperature"
                                           : "solved"},
          {"left_out", {"conduction along surfaces", "drying and wetting", "half shadow of the sun's disc"}}};
}

Json promise(const heat::Promise& promised) {
  return {{"steps_K", promised.steps_k},
          {"grid_K", promised.grid_k},
          {"depth_K", promised.depth_k},
          {"start_K", promised.start_k}};
}

Json error_json(const radiometry::scene::TableError& error) {
  return {{"rms", error.rms}, {"percentile_95", error.percentile_95}, {"count", error.count}};
}

/// null where all facets are asked for.
Json seen_json(const HeatReport& report) {
  if (!report.left_out) return nullptr;
  return {{"facets", report.facets - report.left_out->facets},
          {"facets_left_out", report.left_out->facets},
          {"classes_left_out", report.left_out->units},
          {"error_K",
           {{"rms", report.left_out->error_k.rms},
            {"percentile_95", report.left_out->error_k.percentile_95},
            {"largest", report.left_out->largest_k},
            {"count", report.left_out->error_k.count}}}};
}

Json realised_json(const HeatScene& scene, const RealisedError& error) {
  return {{"rms_K", error.rms_k},
          {"percentile_95_K", error.percentile_95_k},
          {"percentile_99_9_K", error.percentile_999_k},
          {"largest_K", error.largest_k},
          {"facet", error.facet},
          {"time", heat::instant_text(scene.input.start_s + error.time_s)},
          {"count", error.count},
          {"truth_promises_K", error.promised_k}};
}

/// null where it was not asked for.
Json verified_json(const HeatScene& scene, const HeatReport& report) {
  if (!report.verified) return nullptr;
  return {{"as_classes", realised_json(scene, report.verified->as_units)},
          {"each_facet", realised_json(scene, report.verified->by_itself)}};
}

}  // namespace

std::string heat_json(const SceneFile& file, const HeatScene& scene, const HeatReport& report,
                      const HeatOptions& options) {
  Json materials = Json::array();
  double residual = 0.0;
  std::int64_t steps = 0;
  for (const MaterialRun& run : report.materials) {
    materials.push_back({{"material", run.name},
                         {"classes", run.units},
                         {"nodes", run.nodes},
                         {"promised", promise(run.promised)},
                         {"facet_steps", run.steps.facet_steps},
                         {"steps_refused", run.steps.refused},
                         {"residual_K", run.promised.start_k},
                         {"energy_drift", run.drift}});
    residual = std::max(residual, run.promised.start_k);
    steps += run.steps.facet_steps;
  }
  const HeatPromise& p = report.promised;
  const Json json = {{"scene", file.file},
                     {"scene_sha256", file.sha256},
                     {"version", mtf::version},
                     {"commit", mtf::git_commit},
                     {"start", heat::instant_text(file.time.start_s)},
                     {"end", heat::instant_text(file.time.end_s)},
                     {"outputs", report.outputs},
                     {"finished", report.outputs == scene.surroundings.outputs.size()},
                     {"facets", report.facets},
                     {"classes", report.units},
                     {"patches", report.patches},
                     {"covered_facets", Json::object(covered_by_region(scene, report))},
                     {"seen", seen_json(report)},
                     {"steps", steps},
                     {"tolerance_K", options.tolerance_k},
                     {"promised_K", p.total_k()},
                     {"promised",
                      {{"solver", promise(p.solver)},
                       {"ground_K", p.ground_k},
                       {"classes_K", p.units_k},
                       {"exchange_K", p.exchange_k},
                       {"feedback", p.feedback}}},
                     {"realised", verified_json(scene, report)},
                     {"residual_K", residual},
                     {"exchange_iterations", report.iterations},
                     {"tables",
                      {{"sun_directions", scene.surroundings.shadow_to_sun.size()},
                       {"sun_points", options.sun_points},
                       {"sun_share_error", error_json(report.sun_error.of_directions)},
                       {"sun_share_error_of_facets", error_json(report.sun_error.of_sides)},
                       {"view_rays", options.rays_of(report.facets)},
                       {"sky_share_error", error_json(report.view_error.sky)},
                       {"surfaces_share_error", error_json(report.view_error.surfaces)},
                       {"view_of_facets_against_classes_K",
                        {{"rms", report.view_spread.error_k.rms},
                         {"percentile_95", report.view_spread.error_k.percentile_95},
                         {"largest", report.view_spread.largest_k},
                         {"count", report.view_spread.error_k.count}}}}},
                     {"closures", closures(file, scene)},
                     {"materials", materials},
                     {"timing_ms", Json::object(report.timing_ms)},
                     {"warnings", report.warnings}};
  return json_document(json);
}

}  // namespace apps::scene
