// SPDX-License-Identifier: Apache-2.0
#include "apps/budget_table.h"

#include "apps/sensor/observer_rows.h"
#include "apps/sensor/sensor_place.h"
#include "radiometry/chain/sensor_budget.h"

namespace apps {
namespace {

using Rows = std::vector<radiometry::BudgetRow>;

/// What the path lets through of the light of the surface, and of that of a small difference of its temperature. A
/// band average of the transmission alone would be another number.
void add_path_rows(const radiometry::Sensor& sensor, double temperature_k, Rows& rows) {
  if (!sensor.settings.path && !sensor.settings.atmosphere) return;
  const double reflected_k = sensor.settings.scene ? sensor.settings.scene->surroundings_k.value_or(0.0) : 0.0;
  const radiometry::Surface surface{temperature_k, sensor.emissivity, reflected_k};
  const auto add = [&](const char* name, const char* doc, const auto& light) {
    const double clear = light(sensor.curves, surface, radiometry::Path{});
    radiometry::BudgetRow row{name, "", light(sensor.curves, surface, sensor.path) / clear, doc};
    if (!(clear > 0.0)) row.refused = "no light of the scene makes electrons";
    rows.push_back(std::move(row));
  };
  add("path_share", "share of the scene's light that the path lets through", radiometry::scene_radiance);
  add("contrast_share", "the same of a small temperature difference", radiometry::scene_derivative);
}

}  // namespace

BudgetTable budget_table(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, double temperature_k) {
  const radiometry::Budget<double> budget =
      at_its_place(config, [&] { return budget_of(config.system, loaded.sensor, temperature_k); });
  BudgetTable table{.rows = budget_rows(config.system, loaded.sensor, budget),
                    .saturation = budget.saturation,
                    .notes = budget_notes(loaded.sensor, budget),
                    .observer = observer_lines(loaded.sensor),
                    .spatial_gap = spatial_gap(loaded.sensor.settings, budget),
                    .without_path = static_cast<bool>(loaded.paths)};
  for (radiometry::BudgetRow& row : observer_rows(with_electron_rate(config.system, loaded), loaded.sensor, budget))
    table.rows.push_back(std::move(row));
  if (!loaded.paths) add_path_rows(loaded.sensor, temperature_k, table.rows);
  return table;
}

}  // namespace apps
