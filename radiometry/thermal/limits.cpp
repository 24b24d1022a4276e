// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/limits.h"

#include <cmath>
#include <set>

#include "mtf/words.h"
#include "radiometry/heat/surface_loss.h"
#include "radiometry/weather/instant.h"

namespace radiometry::thermal {
namespace {

std::string number(double value, std::string_view unit) { return mtf::significant(value, 5) + " " + std::string(unit); }

/// "convection mcadams: wind of 60 m/s, from 2026-06-21T12:00:00Z on ...".
std::string text_of(const heat::Validity& validity, const heat::Beyond& beyond, double start_s,
                    const std::string& where) {
  return std::string(validity.closure) + ": " + where + "the " + std::string(validity.quantity) + " is outside of " +
         number(validity.lo, validity.unit) + " ... " + number(validity.hi, validity.unit) + ", first at " +
         heat::instant_text(start_s + beyond.first_s) + ", and comes to " + number(beyond.extreme, validity.unit) +
         ": " + std::string(validity.beyond);
}

}  // namespace

std::vector<std::string> wind_limits(const ThermalScene& scene, const Surroundings& s) {
  std::vector<std::string> texts;
  std::set<std::string> seen;  // closures
  for (const Material& one : scene.materials) {
    const auto validity = heat::wind_validity(one.construction.convection);
    if (!validity || !seen.insert(name_of(one.construction.convection)).second) continue;
    heat::Beyond beyond;
    for (std::size_t k = 0; k < s.nodes(); ++k) beyond.see(*validity, s.wind_m_s[k], s.time_s[k]);
    if (beyond.values > 0) texts.push_back(text_of(*validity, beyond, scene.start_s, ""));
  }
  return texts;
}

SurfaceLimits::SurfaceLimits(const HeatScene& scene) : scene_(scene) {
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f)
    if (const Region& region = scene.region_of(f);
        region.is_solved() && scene.material[scene.material_of(f)].construction.is_wet())
      wet_.push_back(f);
}

void SurfaceLimits::see(const HeatOutput& output) {
  for (const std::uint32_t f : wet_)
    for (const auto& side : {output.front_k, output.back_k})
      if (!side.empty() && !std::isnan(side[f]))
        of_region_[scene_.input.region_of[f]].see(heat::kSaturationValidity, side[f], output.time_s, f);
}

std::vector<std::string> SurfaceLimits::texts() const {
  std::vector<std::string> texts;
  for (const auto& [region, beyond] : of_region_)
    if (beyond.values > 0)
      texts.push_back(text_of(heat::kSaturationValidity, beyond, scene_.input.start_s,
                              "region '" + mtf::one_line(scene_.input.regions[region].name) + "', facet " +
                                  std::to_string(beyond.first_place) + ": "));
  return texts;
}

}  // namespace radiometry::thermal
