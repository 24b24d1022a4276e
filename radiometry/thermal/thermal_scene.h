// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene as its heat balance has it, in plain values: where and when, the weather, facets with the region that each
// belongs to, what materials are made of, the ground beyond.
//
//   ThermalScene --prepare_heat (heat_scene.h)--> HeatScene --run_heat (run/heat_run.h)--> temperatures of all facets
//
// SI units; times in seconds of UTC (radiometry/weather/instant.h); x and y level, z up, +y at the azimuth `north_rad`.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "radiometry/heat/construction.h"
#include "radiometry/scene/facets.h"
#include "radiometry/thermal/temperature_rows.h"
#include "radiometry/weather/instant.h"
#include "radiometry/weather/sun.h"
#include "radiometry/weather/weather_series.h"

namespace radiometry::thermal {

/// How a surface absorbs and emits, and what lies below it.
struct Material {
  std::string name;
  heat::Construction construction;
  double solar_absorptance = 0.0, back_solar_absorptance = 0.0;  ///< 0 to 1; the second of the back of a sheet
  /// Heat generated in the layers that comes out of the front and of the back, W/m2 (heat/construction.h).
  double source_w_m2 = 0.0, back_source_w_m2 = 0.0;
  /// Of each layer, W/m3, where one changes with time: then the solver has them and the two above are 0. Else empty.
  std::vector<heat::Schedule> sources{};
  /// Walls of a closed shell, whose construction is a sheet: the longest distance of opposite faces, m; else 0.
  double pair_m = 0.0;
  heat::Schedule inside{};  ///< K or W/m2, what the construction's inside asks for; empty: nothing

  /// Whether the back is exposed too, and is not the inner side of a wall.
  bool is_sheet() const { return construction.is_sheet() && pair_m == 0.0; }
  double emissivity(bool back) const;
  double absorptance(bool back) const { return back ? back_solar_absorptance : solar_absorptance; }
};

/// Throws UsageError "material 'name': ..." for what heat::require_valid refuses, absorptances outside of 0 ... 1, an
/// inside without its schedule, pairs of what is not a sheet, sources that are not one a layer, and what gives off next
/// to nothing, whose temperature nothing determines.
void require_valid(const Material& material);

/// Facets of one kind: solved by their material; or of given temperature, where the material, if there is one, tells
/// what they absorb and emit, and they are black without.
struct Region {
  std::string name;
  std::optional<std::size_t> material{};           ///< an index into ThermalScene::materials
  heat::Schedule temperature{};                    ///< K, of all its facets; empty where they are solved, or in a table
  std::shared_ptr<const TemperatureRows> table{};  ///< of single facets, by their fronts; copies of a scene share it

  bool is_given() const { return table != nullptr || !temperature.value.empty(); }
  bool is_solved() const { return !is_given(); }
  /// The given temperature of a facet, K. Throws UsageError for a time that its table does not cover.
  double given_k(std::uint32_t facet, double utc_s) const;
};

/// A level surface that goes on for ever, which rays see that leave the scene below the horizon: of given temperature,
/// or solved by its material.
struct LevelGround {
  std::optional<std::size_t> material{};  ///< an index into ThermalScene::materials; absent: black
  heat::Schedule temperature{};           ///< K; empty where it is solved
};

/// Long-wave irradiance of a level surface by the sky, W/m2, and the columns of the weather that it follows from.
/// Empty: the weather's longwave_down.
struct LongwaveSky {
  std::vector<heat::WeatherQuantity> columns{};
  std::function<double(const heat::WeatherAt&)> w_m2{};
};

struct ThermalScene {
  std::string name = "the scene";     ///< as messages call it
  double start_s = 0.0, end_s = 0.0;  ///< UTC
  double step_s = 600.0;              ///< between outputs; a divisor of the time from start to end
  heat::Place place{};
  double north_rad = 0.0;  ///< azimuth of +y, from north, clockwise
  /// Air temperature, wind speed, direct normal and diffuse irradiance, what the sky follows from, and vapour pressure
  /// where a material is wet; for a day at least, since a run starts from the state that repeats its first day.
  heat::WeatherSeries weather{};
  LongwaveSky sky{};
  scene::Facets facets{};
  std::vector<std::uint32_t> region_of{};  ///< of each facet, an index into `regions`
  std::vector<Region> regions{};
  std::vector<Material> materials{};
  std::optional<LevelGround> ground{};     ///< absent: black, and as warm as the air
  std::optional<scene::Point> camera_m{};  ///< for HeatOptions::seen

  /// Until when a run takes weather and what is given: a day at least, which its start repeats.
  double last_s() const { return std::max(end_s, start_s + heat::kDay_s); }
  bool evaporates() const;
  /// Those that are not empty: of temperatures that are given (K), and all, fluxes and sources too.
  std::vector<const heat::Schedule*> temperature_schedules() const;
  std::vector<const heat::Schedule*> schedules() const;
  /// The least and the largest of all temperatures that are given, K; the first is the larger one where none is.
  std::array<double, 2> given_range_k() const;
};

/// What the regions are given at a time: one row, NaN for facets that are solved. Throws as Region::given_k.
TemperatureRows given_rows(const ThermalScene& scene, double utc_s);

/// Throws UsageError, with the name of the scene: for no facets, or not one region for each; for regions, materials and
/// ground that refer to what is not there, or have neither material nor temperature; for tables of another number of
/// facets, without one of their region, or that do not cover the run and its first day; for an end before the start, a
/// step that does not divide the time between, and more than a million outputs; and as require_valid of a material
/// does.
void require_valid(const ThermalScene& scene);

}  // namespace radiometry::thermal
