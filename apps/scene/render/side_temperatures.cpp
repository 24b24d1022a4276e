// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/side_temperatures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "apps/scene/heat/tables/facet_table.h"
#include "apps/scene/heat/tables/npy_rows.h"
#include "apps/text/words.h"
#include "mtf/error.h"
#include "radiometry/heat/weather/instant.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
namespace heat = radiometry::heat;

/// Two rows, and how much of the second.
struct Between {
  std::uint64_t row = 0, next = 0;
  double share = 0.0;
};

Between between(const std::vector<double>& times, double utc_s, const std::string& folder) {
  if (!(utc_s >= times.front() && utc_s <= times.back()))
    throw mtf::UsageError("--time: " + heat::instant_text(utc_s) + " is outside of the temperatures of " +
                          one_line(folder) + ", which go from " + heat::instant_text(times.front()) + " to " +
                          heat::instant_text(times.back()));
  const auto above = std::upper_bound(times.begin(), times.end(), utc_s);
  const auto row = static_cast<std::uint64_t>(above - times.begin()) - 1;
  if (above == times.end()) return {row, row, 0.0};
  return {row, row + 1, (utc_s - times[row]) / (times[row + 1] - times[row])};
}

std::vector<float> row_at(const std::string& path, std::size_t facets, const Between& place) {
  NpyRows table(path);
  if (table.columns() != facets)
    throw mtf::UsageError(one_line(path) + ": has " + std::to_string(table.columns()) + " facets, the scene " +
                          std::to_string(facets) + "; it belongs to another scene");
  std::vector<float> values = table.row(place.row);
  if (place.next == place.row) return values;
  const std::vector<float> next = table.row(place.next);
  for (std::size_t f = 0; f < facets; ++f)
    values[f] = static_cast<float>((1.0 - place.share) * static_cast<double>(values[f]) +
                                   place.share * static_cast<double>(next[f]));
  return values;
}

FacetTemperatures from_folder(const std::string& folder, std::size_t facets, std::optional<double> utc_s) {
  const std::string front = folder + "/temperatures.npy", back = folder + "/temperatures_back.npy";
  const std::vector<double> times = read_output_times(folder + "/times.csv", NpyRows(front).rows());
  FacetTemperatures out;
  out.utc_s = utc_s.value_or(times.back());
  const Between place = between(times, out.utc_s, folder);
  out.front = row_at(front, facets, place);
  std::error_code ignored;
  if (fs::exists(back, ignored)) out.back = row_at(back, facets, place);
  return out;
}

FacetTemperatures from_table(const std::string& path, std::size_t facets, double utc_s) {
  const FacetTable table = read_facet_table(path, facets);
  FacetTemperatures out{.front = {}, .back = {}, .utc_s = utc_s};
  for (std::uint32_t f = 0; f < facets; ++f) out.front.push_back(static_cast<float>(table.at(f, utc_s)));
  return out;
}

FacetTemperatures from_regions(const SceneFile& file, const Surfaces& surfaces, double utc_s) {
  std::string missing;
  for (const RegionSection& region : file.regions)
    if (!region.temperature) missing += (missing.empty() ? "'" : ", '") + one_line(region.name) + "'";
  if (!missing.empty())
    throw mtf::UsageError(one_line(file.file) + ": no temperature is given for the regions " + missing +
                          "; name the folder that `mtf heat` wrote with --temperatures, or give each region a "
                          "temperature");
  const std::size_t facets = surfaces.facets.size();
  std::vector<std::optional<FacetTable>> tables;
  for (const RegionSection& region : file.regions)
    tables.push_back(region.temperature->table.empty()
                         ? std::nullopt
                         : std::optional(read_facet_table(region.temperature->table, facets)));
  FacetTemperatures out{.front = {}, .back = {}, .utc_s = utc_s};
  for (std::uint32_t f = 0; f < facets; ++f) {
    const std::uint32_t region = surfaces.region[f];
    const auto& table = tables[region];
    out.front.push_back(
        static_cast<float>(table ? table->at(f, utc_s) : value_at(file.regions[region].temperature->schedule, utc_s)));
  }
  return out;
}

}  // namespace

bool is_sheet(const SceneFile& file, const Surfaces& surfaces, std::uint32_t facet) {
  const RegionSection& region = file.regions[surfaces.region[facet]];
  if (!region.material) return false;
  const Surface& surface = surfaces.material[*region.material];
  return surface.construction.is_sheet() && surface.pair_m == 0.0;
}

FacetTemperatures solved_temperatures(const SceneFile& file, double utc_s, const HeatOptions& options,
                                      const HeatProgress& progress) {
  if (!(utc_s >= file.time.start_s && utc_s <= file.time.end_s))
    throw mtf::UsageError("--time: " + heat::instant_text(utc_s) + " is outside of the run of " + one_line(file.file) +
                          ", which goes from " + heat::instant_text(file.time.start_s) + " to " +
                          heat::instant_text(file.time.end_s));
  SceneFile until = file;
  const double steps = std::max(1.0, std::ceil((utc_s - file.time.start_s) / file.time.step_s - 1e-9));
  until.time.end_s = file.time.start_s + steps * file.time.step_s;
  const double at_s = utc_s - file.time.start_s;
  // Straight lines between the two outputs beside the time.
  const auto add = [](std::span<const double> kelvin, double weight, std::vector<float>& sum) {
    sum.resize(kelvin.size(), 0.0F);
    for (std::size_t f = 0; f < kelvin.size(); ++f) sum[f] += static_cast<float>(weight * kelvin[f]);
  };
  FacetTemperatures out{.front = {}, .back = {}, .utc_s = utc_s};
  run_heat(
      prepare_heat(until, options), options,
      [&](const HeatOutput& output) {
        const double weight = 1.0 - std::abs(output.time_s - at_s) / file.time.step_s;
        if (!(weight > 1e-9)) return;
        add(output.front_k, weight, out.front);
        if (!output.back_k.empty()) add(output.back_k, weight, out.back);
      },
      progress);
  return out;
}

SideTemperatures side_temperatures(const SceneFile& file, const Surfaces& surfaces, const std::string& source,
                                   std::optional<double> utc_s) {
  std::error_code ignored;
  const std::size_t facets = surfaces.facets.size();
  const double start_s = utc_s.value_or(file.time.start_s);
  return side_temperatures(file, surfaces,
                           source.empty()                      ? from_regions(file, surfaces, start_s)
                           : fs::is_directory(source, ignored) ? from_folder(source, facets, utc_s)
                                                               : from_table(source, facets, start_s),
                           source);
}

SideTemperatures side_temperatures(const SceneFile& file, const Surfaces& surfaces, const FacetTemperatures& of,
                                   const std::string& source) {
  const radiometry::scene::Facets& facets = surfaces.facets;
  SideTemperatures out{.kelvin = {}, .utc_s = of.utc_s};
  std::vector<std::size_t> unknown(file.regions.size(), 0);
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const float front = of.front[f];
    if (!(front > 0.0F)) ++unknown[surfaces.region[f]];
    const bool solid = facets.shells[facets.facet[f].shell].outward && !is_sheet(file, surfaces, f);
    const float own = of.back.empty() || !(of.back[f] > 0.0F) ? front : of.back[f];
    out.kelvin.push_back(front);
    out.kelvin.push_back(solid ? std::numeric_limits<float>::quiet_NaN() : own);
  }
  std::string missing;
  for (std::size_t r = 0; r < unknown.size(); ++r)
    if (unknown[r] > 0)
      missing += (missing.empty() ? "'" : ", '") + one_line(file.regions[r].name) + "' (" + std::to_string(unknown[r]) +
                 " facets)";
  if (!missing.empty())
    throw mtf::UsageError(one_line(source) + ": has no temperature for facets of the regions " + missing);
  return out;
}

}  // namespace apps::scene
