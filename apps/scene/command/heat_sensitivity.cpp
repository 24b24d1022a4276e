// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/heat_sensitivity.h"

#include <algorithm>
#include <cmath>

#include "apps/terminal/text_table.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr double kMore = 1.1;       ///< + 10 %
constexpr double kSky_w_m2 = 10.0;  ///< of long wave
constexpr double kFinish = 0.02;    ///< of absorptance and emissivity
constexpr double kMcAdamsStill = 5.7, kMcAdamsWind = 3.8;

heat::Convection stronger(const heat::Convection& convection) {
  if (std::holds_alternative<heat::McAdams>(convection))
    return heat::LinearConvection{kMore * kMcAdamsStill, kMore * kMcAdamsWind};
  heat::Convection more = convection;
  if (auto* linear = std::get_if<heat::LinearConvection>(&more)) {
    linear->h0_w_m2_k *= kMore;
    linear->h1_j_m3_k *= kMore;
  }
  if (auto* tarp = std::get_if<heat::Tarp>(&more)) tarp->roughness *= kMore;
  return more;
}

struct Change {
  std::string name;
  std::function<void(Material&)> of_material;
  double sky_w_m2 = 0.0;
};

std::vector<Change> changes() {
  const auto both = [](double value, double step) { return std::clamp(value + step, 0.0, 1.0); };
  return {{"convection +10 %",
           [](Material& s) {
             s.construction.convection = stronger(s.construction.convection);
             if (auto* sheet = std::get_if<heat::Sheet>(&s.construction.inside))
               sheet->convection = stronger(sheet->convection);
           }},
          {"long wave of the sky +10 W/m2", {}, kSky_w_m2},
          {"solar absorptance +0.02",
           [both](Material& s) {
             s.solar_absorptance = both(s.solar_absorptance, kFinish);
             s.back_solar_absorptance = both(s.back_solar_absorptance, kFinish);
           }},
          {"emissivity -0.02",
           [both](Material& s) {
             s.construction.emissivity = both(s.construction.emissivity, -kFinish);
             if (auto* sheet = std::get_if<heat::Sheet>(&s.construction.inside))
               sheet->emissivity = both(sheet->emissivity, -kFinish);
           }},
          {"conductivity +10 %",
           [](Material& s) {
             for (heat::Layer& layer : s.construction.layers) layer.conductivity_w_m_k *= kMore;
           }},
          {"heat capacity +10 %", [](Material& s) {
             for (heat::Layer& layer : s.construction.layers) layer.heat_capacity_j_kg_k *= kMore;
           }}};
}

std::vector<double> means_of(const HeatScene& scene, std::span<const double> facet_k) {
  std::vector<double> sum(scene.input.regions.size(), 0.0), area(sum.size(), 0.0);
  for (std::size_t f = 0; f < facet_k.size(); ++f) {
    if (std::isnan(facet_k[f])) continue;  // not asked for
    const double of_facet = scene.facets().facet[f].area_m2;
    sum[scene.input.region_of[f]] += of_facet * facet_k[f];
    area[scene.input.region_of[f]] += of_facet;
  }
  for (std::size_t r = 0; r < sum.size(); ++r) sum[r] /= area[r];
  return sum;
}

std::vector<RegionChange> difference(const RegionMeans& changed, const RegionMeans& base) {
  std::vector<RegionChange> regions(base.front().size());
  for (std::size_t i = 0; i < base.size(); ++i)
    for (std::size_t r = 0; r < regions.size(); ++r) {
      const double kelvin = changed[i][r] - base[i][r];
      regions[r].mean_k += kelvin / static_cast<double>(base.size());
      if (!(std::abs(kelvin) <= std::abs(regions[r].largest_k))) regions[r].largest_k = kelvin;
    }
  return regions;
}

std::string signed_text(double kelvin) {
  return std::isnan(kelvin) ? "not seen" : (kelvin < 0.0 ? "" : "+") + fixed(kelvin, 2);
}

}  // namespace

std::vector<Sensitivity> sensitivities(HeatScene& scene, const HeatOptions& options, const RegionMeans& base,
                                       const std::function<void(const std::string&, double)>& progress) {
  std::vector<Sensitivity> all;
  for (const Change& change : changes()) {
    progress(change.name, static_cast<double>(all.size()) / 6.0);
    const std::vector<Material> materials = scene.material;
    const std::vector<double> sky = scene.surroundings.sky_longwave_w_m2;
    if (change.of_material)
      for (Material& material : scene.material) change.of_material(material);
    for (double& longwave : scene.surroundings.sky_longwave_w_m2) longwave += change.sky_w_m2;
    RegionMeans means;
    run_heat(
        scene, options, [&](const HeatOutput& output) { means.push_back(means_of(scene, output.front_k)); },
        [](const std::string&, double) {});
    scene.material = materials;
    scene.surroundings.sky_longwave_w_m2 = sky;
    if (means.size() < base.size()) break;  // interrupted
    all.push_back({change.name, difference(means, base)});
  }
  return all;
}

std::string sensitivity_table(const HeatScene& scene, const std::vector<Sensitivity>& all) {
  std::vector<std::string> header{"change of the mean [K], largest in brackets"};
  std::vector<Align> align{Align::left};
  for (const Region& region : scene.input.regions) {
    header.push_back(one_line(region.name));
    align.push_back(Align::right);
  }
  TextTable table(std::move(header));
  for (const Sensitivity& one : all) {
    std::vector<std::string> row{one.change};
    for (const RegionChange& region : one.regions)
      row.push_back(signed_text(region.mean_k) + " (" + signed_text(region.largest_k) + ")");
    table.add(std::move(row));
  }
  return table.aligned(align);
}

std::string sensitivity_csv(const HeatScene& scene, const std::vector<Sensitivity>& all) {
  std::string text = "change,region,mean_K,largest_K\n";
  for (const Sensitivity& one : all)
    for (std::size_t r = 0; r < one.regions.size(); ++r)
      text += csv_field(one.change) + "," + csv_field(scene.input.regions[r].name) + "," +
              csv_number(one.regions[r].mean_k) + "," + csv_number(one.regions[r].largest_k) + "\n";
  return text;
}

}  // namespace apps::scene
