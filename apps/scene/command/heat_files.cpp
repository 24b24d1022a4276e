// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/heat_files.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
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

HeatFiles::HeatFiles(std::string folder, std::string kept, const SceneFile& file, const HeatScene& scene)
    : folder_(std::move(folder)),
      kept_(std::move(kept)),
      file_(file),
      scene_(scene),
      region_area_m2_(file.regions.size(), 0.0) {
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f)
    if (scene.is_seen(f)) region_area_m2_[scene.input.region_of[f]] += scene.facets().facet[f].area_m2;
  front_ = std::make_unique<NpyFile>(at("temperatures.npy"), scene.facets().size());
  for (std::uint32_t f = 0; f < scene.facets().size() && !back_; ++f)
    if (scene.is_sheet(f)) back_ = std::make_unique<NpyFile>(at("temperatures_back.npy"), scene.facets().size());
}

void HeatFiles::take_over(const EarlierOutputs& earlier) {
  const std::size_t outputs = earlier.times_s.size();
  // Without second names of files only Ctrl-C leaves an unfinished run, with all that is finished in place.
  const auto table = [&](const std::string& kept, const std::string& own) {
    return kept_ + "/" + (std::filesystem::exists(kept_ + "/" + kept) ? kept : own);
  };
  copy_rows(table("unfinished.npy", "temperatures.npy"), outputs, *front_);
  if (back_) copy_rows(table("unfinished_back.npy", "temperatures_back.npy"), outputs, *back_);
  times_s_ = earlier.times_s;
  regions_ = earlier.regions;
}

std::string HeatFiles::instant(double time_s) const {
  return radiometry::heat::instant_text(file_.time.start_s + time_s);
}

void HeatFiles::append(const HeatOutput& output) {
  front_->append(std::vector<float>(output.front_k.begin(), output.front_k.end()));
  if (back_) back_->append(std::vector<float>(output.back_k.begin(), output.back_k.end()));
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<RegionTemperature> regions(file_.regions.size(), {kInfinity, 0.0, -kInfinity});
  for (std::size_t f = 0; f < output.front_k.size(); ++f) {
    RegionTemperature& region = regions[scene_.input.region_of[f]];
    const double kelvin = output.front_k[f], area = scene_.facets().facet[f].area_m2;
    if (std::isnan(kelvin)) continue;  // not asked for
    region.least_k = std::min(region.least_k, kelvin);
    region.most_k = std::max(region.most_k, kelvin);
    region.mean_k += area * kelvin;
  }
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    regions[r].mean_k /= region_area_m2_[r];
    if (region_area_m2_[r] == 0.0) regions[r] = {kUnknown, kUnknown, kUnknown};
  }
  regions_.push_back(std::move(regions));
  times_s_.push_back(output.time_s);
}

bool HeatFiles::keep() {
  return front_->keep_as(kept_ + "/unfinished.npy") && (!back_ || back_->keep_as(kept_ + "/unfinished_back.npy"));
}

std::vector<std::string> heat_names() {
  return {"temperatures.npy", "temperatures_back.npy", "facets.csv", "times.csv",  "regions.csv", "heat.json",
          "regions.svg",      "regions.svg.csv",       "scene.png",  "facets.ply", "facets.vtk",  "sensitivity.csv"};
}

std::vector<std::pair<std::string, std::size_t>> covered_by_region(const HeatScene& scene, const HeatReport& report) {
  std::vector<std::size_t> count(scene.input.regions.size(), 0);
  for (const std::uint32_t facet : report.covered) ++count[scene.input.region_of[facet]];
  std::vector<std::pair<std::string, std::size_t>> named;
  for (std::size_t r = 0; r < count.size(); ++r)
    if (count[r] > 0) named.emplace_back(scene.input.regions[r].name, count[r]);
  return named;
}

std::string HeatFiles::facets_csv() const {
  std::string text = "facet,mesh,region,material,area_m2,centre_x_m,centre_y_m,centre_z_m,normal_x,normal_y,normal_z\n";
  const auto& facets = scene_.facets().facet;
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const Region& region = scene_.region_of(f);
    text += std::to_string(f) + "," + csv_field(file_.meshes[facets[f].mesh].name) + "," + csv_field(region.name) +
            "," + (region.material ? csv_field(file_.materials[*region.material].name) : "") + "," +
            significant(facets[f].area_m2, 9);
    for (const double value : facets[f].centre) text += "," + significant(value, 9);
    for (const double value : facets[f].normal) text += "," + significant(value, 9);
    text += "\n";
  }
  return text;
}

void HeatFiles::write(const HeatReport& report, const HeatOptions& options) {
  std::string times = "output,time,time_s\n", regions = "time,region,min_K,mean_K,max_K\n";
  for (std::size_t i = 0; i < times_s_.size(); ++i) {
    const std::string when = instant(times_s_[i]);
    times += std::to_string(i) + "," + when + "," + csv_number(times_s_[i]) + "\n";
    for (std::size_t r = 0; r < regions_[i].size(); ++r) {
      const RegionTemperature& region = regions_[i][r];
      regions += when + "," + csv_field(file_.regions[r].name);
      for (const double kelvin : {region.least_k, region.mean_k, region.most_k})
        regions += "," + (std::isnan(kelvin) ? std::string() : fixed(kelvin, 4));
      regions += "\n";
    }
  }
  front_->commit();
  if (back_) back_->commit();
  emit(at("facets.csv"), facets_csv());
  emit(at("times.csv"), times);
  emit(at("regions.csv"), regions);
  emit(at("heat.json"), heat_json(file_, scene_, report, options));
}

}  // namespace apps::scene
