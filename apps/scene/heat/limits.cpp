// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/limits.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/text/words.h"
#include "radiometry/atmosphere/spectral_path.h"
#include "radiometry/heat/evaporation.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

std::string number(double value, std::string_view unit) { return significant(value, 5) + " " + std::string(unit); }

/// "convection mcadams: wind of 60 m/s, from 2026-06-21T12:00:00Z on ...".
std::string text_of(const heat::Validity& validity, const heat::Beyond& beyond, double start_s,
                    const std::string& where) {
  return std::string(validity.closure) + ": " + where + "the " + std::string(validity.quantity) + " is outside of " +
         number(validity.lo, validity.unit) + " ... " + number(validity.hi, validity.unit) + ", first at " +
         heat::instant_text(start_s + beyond.first_s) + ", and comes to " + number(beyond.extreme, validity.unit) +
         ": " + std::string(validity.beyond);
}

/// The air of [sky] longwave = "atmosphere" where it is coldest, warmest and most humid.
std::vector<std::string> air_limits(const SceneFile& file, const Surroundings& s) {
  if (file.sky.longwave != LongwaveModel::atmosphere || !file.atmosphere) return {};
  constexpr radiometry::Interval kThermal_um{5.0, 15.0};
  const ClearSkyFlux model(*file.atmosphere, file.place.altitude_m);
  const auto [coldest, warmest] = std::ranges::minmax_element(s.air_k);
  std::vector<std::string> texts;
  std::set<std::string> said;  // rules
  for (const auto node : {coldest - s.air_k.begin(), warmest - s.air_k.begin(),
                          std::ranges::max_element(s.vapour_pa) - s.vapour_pa.begin()}) {
    const auto k = static_cast<std::size_t>(node);
    for (const std::string& limit : limits_of(model.air_at(s.air_k[k], s.vapour_pa[k]), kThermal_um))
      if (said.insert(limit.substr(0, limit.find(';'))).second)
        texts.push_back("[atmosphere], as the weather has it at " +
                        heat::instant_text(file.time.start_s + s.time_s[k]) + ": " + limit);
  }
  return texts;
}

}  // namespace

std::vector<std::string> weather_limits(const SceneFile& file, const std::vector<Surface>& material,
                                        const Surroundings& s) {
  std::vector<std::string> texts = air_limits(file, s);
  std::set<std::string> seen;  // closures
  for (const Surface& one : material) {
    const auto validity = heat::wind_validity(one.construction.convection);
    if (!validity || !seen.insert(name_of(one.construction.convection)).second) continue;
    heat::Beyond beyond;
    for (std::size_t k = 0; k < s.nodes(); ++k) beyond.see(*validity, s.wind_m_s[k], s.time_s[k]);
    if (beyond.values > 0) texts.push_back(text_of(*validity, beyond, file.time.start_s, ""));
  }
  return texts;
}

SurfaceLimits::SurfaceLimits(const HeatScene& scene) : scene_(scene) {
  for (std::uint32_t f = 0; f < scene.region.size(); ++f)
    if (const RegionSection& region = scene.region_of(f);
        region.material && !region.temperature && scene.material[scene.material_of(f)].construction.is_wet())
      wet_.push_back(f);
}

void SurfaceLimits::see(const HeatOutput& output) {
  for (const std::uint32_t f : wet_)
    for (const auto& side : {output.front_k, output.back_k})
      if (!side.empty() && !std::isnan(side[f]))
        of_region_[scene_.region[f]].see(heat::kSaturationValidity, side[f], output.time_s, f);
}

std::vector<std::string> SurfaceLimits::texts() const {
  std::vector<std::string> texts;
  for (const auto& [region, beyond] : of_region_)
    if (beyond.values > 0)
      texts.push_back(text_of(heat::kSaturationValidity, beyond, scene_.file.time.start_s,
                              "region '" + one_line(scene_.file.regions[region].name) + "', facet " +
                                  std::to_string(beyond.first_place) + ": "));
  return texts;
}

}  // namespace apps::scene
