// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of both sides of all facets over time: what `mtf heat` wrote or worked out, a table from elsewhere, or
// what the regions of the scene file have. Straight lines between the times that are known.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"

namespace apps::scene {

/// Temperatures of all facets at some times.
struct HeatRows {
  std::vector<double> utc_s{};                      ///< rising
  std::vector<std::vector<float>> front{}, back{};  ///< K, [time][facet]; back: NaN, or empty, where it is not another
};

class SideTemperatures {
 public:
  /// `source`: the folder that `mtf heat` wrote, or a table of facets (read_facet_table.h); "": what the regions of the
  /// scene have, each of which has to have one.
  SideTemperatures(const ThermalScene& scene, const std::string& source);
  SideTemperatures(const ThermalScene& scene, HeatRows rows);
  ~SideTemperatures();
  SideTemperatures(SideTemperatures&&) noexcept;

  /// Of the last row; of the start of the run where there are no rows.
  double default_utc_s() const;
  /// The first and the last time that is known; nothing where they hold at all times.
  std::optional<std::array<double, 2>> span_utc_s() const;
  /// Throws UsageError for a time that the rows do not have.
  void require_time(double utc_s) const;
  /// Whether they change with time.
  bool change() const;
  /// Fills `kelvin` of radiometry::scene::index(side); NaN for the inside of solids. Throws UsageError for a time that
  /// the rows do not have, and for facets without a temperature, with their regions. Not from two threads at once.
  void at(double utc_s, std::vector<float>& kelvin);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The files that a `source` of SideTemperatures is read from.
std::vector<std::string> temperature_files(const std::string& source);

/// Whether the back of that facet is exposed and has a temperature of its own.
bool is_sheet(const ThermalScene& scene, std::uint32_t facet);

/// The regions of the file that have no temperature, as words: 'a', 'b'; "" where all have.
std::string regions_to_solve(const SceneFile& file);

}  // namespace apps::scene
