// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/thermal_scene.h"

#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/words.h"
#include "radiometry/light/constants.h"

namespace radiometry::thermal {
namespace {

/// Throws UsageError for a schedule of temperatures or fluxes that make_schedule would not make.
void require_schedule(const heat::Schedule& schedule, const std::string& where) {
  heat::make_schedule(where + ": a schedule", schedule.time_s, schedule.value);
}

std::string of_count(std::size_t index, std::size_t count, const std::string& word) {
  return " refers to " + word + " " + std::to_string(index) + ", and there " + (count == 1 ? "is " : "are ") +
         mtf::plural(static_cast<std::int64_t>(count), word) + " (the first one is 0)";
}

void require_times(const ThermalScene& scene, const std::string& where) {
  const double span_s = scene.end_s - scene.start_s;
  if (!(span_s > 0.0) || !std::isfinite(span_s))
    throw mtf::UsageError(where + "the end of the run has to be after its start");
  const double steps = span_s / scene.step_s;
  if (!(scene.step_s > 0.0 && steps > 0.5 && std::abs(steps - std::round(steps)) <= 1e-6))
    throw mtf::UsageError(where + "outputs every " + mtf::significant(scene.step_s, 6) +
                          " s do not divide the run of " + mtf::significant(span_s, 9) + " s; choose a divisor of it");
  constexpr double kMost = 1e6;
  if (steps > kMost)
    throw mtf::UsageError(where + mtf::significant(steps, 3) + " outputs are more than " + mtf::significant(kMost, 7) +
                          "; choose a longer step, or a shorter run");
}

void require_table(const ThermalScene& scene, const Region& region, const std::string& where) {
  const TemperatureRows& table = *region.table;
  require_valid(table, scene.facets.size(), where);
  if (!table.covers(scene.start_s, scene.last_s()))
    throw mtf::UsageError(where + ": " + mtf::one_line(table.source) + " has temperatures " + table.span_text() +
                          ", and the run takes them from " + heat::instant_text(scene.start_s) + " to " +
                          heat::instant_text(scene.last_s()) +
                          ", a day at least, since its start repeats the first one; give " +
                          "the table rows for all of that, or one row, which holds at all times");
}

}  // namespace

double Material::emissivity(bool back) const {
  const auto* sheet = std::get_if<heat::Sheet>(&construction.inside);
  return back && sheet != nullptr ? sheet->emissivity : construction.emissivity;
}

void require_valid(const Material& material) {
  const std::string where = "material '" + mtf::one_line(material.name) + "'";
  const heat::Construction& c = material.construction;
  require_valid(c, where);
  for (const double absorptance : {material.solar_absorptance, material.back_solar_absorptance})
    if (!(absorptance >= 0.0 && absorptance <= 1.0))
      throw mtf::UsageError(where + ": solar absorptance is " + mtf::significant(absorptance, 6) +
                            ", has to be between 0 and 1");
  if (!(material.pair_m >= 0.0 && std::isfinite(material.pair_m)) || (material.pair_m > 0.0 && !c.is_sheet()))
    throw mtf::UsageError(where + ": the longest distance of opposite faces is " +
                          mtf::significant(material.pair_m, 6) +
                          " m; it has to be above 0 for walls whose inside is a sheet, and 0 for all others");
  for (const double source : {material.source_w_m2, material.back_source_w_m2})
    if (!std::isfinite(source) || (c.generates && source != 0.0))
      throw mtf::UsageError(where + ": heat of " + mtf::significant(source, 6) +
                            " W/m2 comes out of its layers; it has " +
                            (c.generates ? "to be 0 beside `sources`" : "to be finite"));
  const bool driven = !std::holds_alternative<heat::Adiabatic>(c.inside) && !c.is_sheet();
  if (driven == material.inside.value.empty())
    throw mtf::UsageError(where + (driven ? ": its inside needs a schedule of temperature or flux"
                                          : ": nothing at its inside takes a schedule; leave it out"));
  if (c.generates == material.sources.empty() || (c.generates && material.sources.size() != c.layers.size()))
    throw mtf::UsageError(where + ": it has " + mtf::plural(static_cast<std::int64_t>(c.layers.size()), "layer") +
                          " and " + mtf::plural(static_cast<std::int64_t>(material.sources.size()), "schedule") +
                          " of sources; give one a layer and set `generates`, or none");
  constexpr double kLeast_w_m2_k = 1e-3;  // about a thousandth of what a black surface radiates at 200 K
  constexpr double kWind_m_s = 1.0, kKelvin = 300.0;
  const auto* film = std::get_if<heat::InnerFilm>(&c.inside);
  const double gives = 4.0 * c.emissivity * kStefanBoltzmann_w_m2_k4 * std::pow(kKelvin, 3) +
                       forced_coefficient(c.convection, kWind_m_s) + (film != nullptr ? film->h_w_m2_k : 0.0);
  if (!(gives > kLeast_w_m2_k || std::holds_alternative<heat::FixedTemperature>(c.inside)))
    throw mtf::UsageError(where +
                          ": radiation, convection and film give off next to nothing, so that nothing "
                          "determines its temperature; give an emissivity, or convection");
}

double Region::given_k(std::uint32_t facet, double utc_s) const {
  return table ? table->front_at(facet, utc_s) : value_at(temperature, utc_s);
}

bool ThermalScene::evaporates() const {
  return std::ranges::any_of(materials, [](const Material& material) { return material.construction.is_wet(); });
}

std::vector<const heat::Schedule*> ThermalScene::temperature_schedules() const {
  std::vector<const heat::Schedule*> all;
  for (const Material& material : materials)
    if (!std::holds_alternative<heat::InnerFlux>(material.construction.inside)) all.push_back(&material.inside);
  for (const Region& region : regions) all.push_back(&region.temperature);
  if (ground) all.push_back(&ground->temperature);
  std::erase_if(all, [](const heat::Schedule* schedule) { return schedule->value.empty(); });
  return all;
}

std::vector<const heat::Schedule*> ThermalScene::schedules() const {
  std::vector<const heat::Schedule*> all = temperature_schedules();
  for (const Material& material : materials) {
    if (std::holds_alternative<heat::InnerFlux>(material.construction.inside)) all.push_back(&material.inside);
    for (const heat::Schedule& source : material.sources) all.push_back(&source);
  }
  return all;
}

std::array<double, 2> ThermalScene::given_range_k() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::array range{kInfinity, -kInfinity};
  const auto widen = [&](double kelvin) {
    if (!std::isnan(kelvin)) range = {std::min(range[0], kelvin), std::max(range[1], kelvin)};
  };
  for (const heat::Schedule* schedule : temperature_schedules()) std::ranges::for_each(schedule->value, widen);
  for (const Region& region : regions)
    if (region.table) std::ranges::for_each(region.table->front_k, widen);
  return range;
}

TemperatureRows given_rows(const ThermalScene& scene, double utc_s) {
  TemperatureRows rows{.source = scene.name, .facets = scene.region_of.size()};
  for (std::uint32_t f = 0; f < rows.facets; ++f) {
    const Region& region = scene.regions[scene.region_of[f]];
    rows.front_k.push_back(region.is_given() ? static_cast<float>(region.given_k(f, utc_s))
                                             : std::numeric_limits<float>::quiet_NaN());
  }
  return rows;
}

void require_valid(const ThermalScene& scene) {
  const std::string where = mtf::one_line(scene.name) + ": ";
  const auto refuse = [&](const std::string& text) { throw mtf::UsageError(where + text); };
  const std::size_t facets = scene.facets.size();
  if (facets == 0) refuse("it has no facets; make them of meshes with facets_of");
  if (scene.region_of.size() != facets)
    refuse(std::to_string(facets) + " facets, and regions of " + std::to_string(scene.region_of.size()) +
           "; each facet belongs to one region");
  require_times(scene, where);
  if (!std::isfinite(scene.north_rad)) refuse("the azimuth of north is not finite");
  if (scene.weather.node_s.empty()) refuse("it has no weather; make_series prepares records");
  for (const Material& material : scene.materials) require_valid(material);
  for (const heat::Schedule* schedule : scene.schedules()) require_schedule(*schedule, mtf::one_line(scene.name));
  const auto require_surface = [&](const std::string& name, std::optional<std::size_t> material, bool given) {
    if (material && *material >= scene.materials.size())
      refuse(name + of_count(*material, scene.materials.size(), "material"));
    if (!material && !given) refuse(name + " needs a material, or a temperature");
  };
  for (const Region& region : scene.regions) {
    const std::string name = "region '" + mtf::one_line(region.name) + "'";
    require_surface(name, region.material, region.is_given());
    if (region.table) require_table(scene, region, where + name);
    if (region.table && !region.temperature.value.empty())
      refuse(name + " has a temperature and a table; remove one of them");
  }
  if (scene.ground) require_surface("the ground", scene.ground->material, !scene.ground->temperature.value.empty());
  for (const heat::Schedule* schedule : scene.temperature_schedules())
    for (const double kelvin : schedule->value)
      if (!(kelvin > 0.0)) refuse("a schedule has a temperature of " + mtf::significant(kelvin, 4) + " K");
  for (std::uint32_t f = 0; f < facets; ++f) {
    if (scene.region_of[f] >= scene.regions.size())
      refuse("facet " + std::to_string(f) + of_count(scene.region_of[f], scene.regions.size(), "region"));
    const Region& region = scene.regions[scene.region_of[f]];
    if (!region.table) continue;
    const std::vector<float>& kelvin = region.table->front_k;
    for (std::size_t i = f; i < kelvin.size(); i += facets)
      if (!(kelvin[i] > 0.0F && std::isfinite(kelvin[i])))
        throw mtf::UsageError(mtf::one_line(region.table->source) + ": facet " + std::to_string(f) + " of region '" +
                              mtf::one_line(region.name) + "' has " +
                              (std::isnan(kelvin[i])
                                   ? "no temperature"
                                   : mtf::significant(static_cast<double>(kelvin[i]), 4) + " K, which no surface has"));
  }
}

}  // namespace radiometry::thermal
