// SPDX-License-Identifier: Apache-2.0
#include "apps/budget_table.h"

#include <cmath>

#include "apps/figures/otf_map.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_place.h"
#include "mtf/error.h"
#include "mtf/words.h"
#include "radiometry/chain/chain.h"
#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/sensor_numbers.h"
#include "radiometry/performance/condition_lines.h"

namespace apps {

// What an observer makes of the noise of a budget: MRTD and MDTD (radiometry/performance/target_at_range.h) as two more
// rows of `mtf budget`, for photon and thermal detectors alike. The noise is the NETD and the spatial NETD of the
// budget; the observer has the defaults of a study. Studies have the same figures as the metrics `mrtd` and `mdtd`,
// with any observer and derivatives.

std::string observer_gap(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                         const radiometry::Budget<double>& budget) {
  if (const std::string refused = refusal_of(budget, budget.netd_k); !refused.empty()) return refused;
  if (!budget.dither.dithered()) return words(budget.dither);
  constexpr double kMost_k = 1e6;  // of MrtdInput
  if (!(budget.netd_k <= kMost_k && budget.spatial_netd_k <= kMost_k))
    return "the light of this temperature hardly reaches the detector: the NETD is " +
           mtf::three_digits(budget.netd_k) + " K, the spatial one " + mtf::three_digits(budget.spatial_netd_k) + " K";
  if (!(system.frame.focal_length_mm > 0.0)) return "no [frame] focal_length";
  const auto& frame = sensor.settings.frame;
  if (sensor.settings.thermal && !(frame && frame->frame_time_s)) return "no [frame] frame_time";
  return "";
}

BarView bar_view(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                 const radiometry::Budget<double>& budget) {
  mtf::ResolutionNeeds needs;
  needs.curves = true;
  needs.tolerance = 1e-6;
  const auto resolution =
      std::make_shared<const mtf::Resolution<double>>(mtf::ResolutionMeter<double>(needs).measure(system));
  return {.resolution = resolution,
          .observer = {system, {}, frame_time_s(system, sensor.settings)},
          .sensor = {.netd_k = budget.netd_k,
                     .spatial_netd_k = budget.spatial_netd_k,
                     .otf = radiometry::seen_otf(resolution, system.frame)},
          .cutoff_cy_mrad = radiometry::counted_cy_mrad(system, resolution->cutoff_cy_mm)};
}

std::vector<std::string> observer_lines(const mtf::System<double>& system, const radiometry::Sensor& sensor) {
  const std::string air = air_words(sensor.settings);
  return radiometry::condition_lines(
      {.bars = true}, {}, {}, air.empty() ? "" : air + "; temperature differences are those of the scene behind it",
      frame_rate_words(system, sensor.settings));
}

namespace {

/// Both at half of the Nyquist frequency, bars and a square of 1 / Nyquist; `system` has the electron rate of its band.
/// A row without a value says why.
std::vector<radiometry::BudgetRow> observer_rows(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                                                 const radiometry::Budget<double>& budget) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  radiometry::BudgetRow mrtd{"mrtd", "mK", none, "minimum resolvable temperature difference at half of Nyquist, 2-D"},
      mdtd{"mdtd", "mK", none, "minimum detectable temperature difference of a square of 1 / Nyquist"};
  mrtd.refused = mdtd.refused = observer_gap(system, sensor, budget);
  mrtd.saturated = mdtd.saturated = is_saturated(budget, budget.netd_k);
  if (!mrtd.refused.empty()) return {mrtd, mdtd};
  try {
    const BarView view = bar_view(system, sensor, budget);
    const double nyquist = view.observer.nyquist_cy_mrad();
    mrtd.value = 1e3 * view.observer.mrtd_k(view.sensor, 0.5 * nyquist);
    mdtd.value = 1e3 * view.observer.mdtd_k(view.sensor, 1.0 / nyquist, view.cutoff_cy_mrad);
    for (radiometry::BudgetRow* row : {&mrtd, &mdtd})
      if (!std::isfinite(row->value)) row->refused = radiometry::kNotResolved;
  } catch (const mtf::Error& error) {
    mrtd.refused = mdtd.refused = error.what();
  }
  return {mrtd, mdtd};
}

using Rows = std::vector<radiometry::BudgetRow>;

/// What the path lets through of the light of the surface, and of that of a small difference of its temperature. A
/// band average of the transmission alone would be another number.
void add_path_rows(const radiometry::Sensor& sensor, double temperature_k, Rows& rows) {
  const double reflected_k = sensor.settings.scene ? sensor.settings.scene->surroundings_k.value_or(0.0) : 0.0;
  const radiometry::Surface surface{temperature_k, sensor.emissivity, reflected_k};
  const auto add = [&](const char* name, const char* doc, const auto& light) {
    const double clear = light(sensor.curves, surface, radiometry::Path{});
    radiometry::BudgetRow row{name, "", light(sensor.curves, surface, sensor.path) / clear, doc};
    if (!(clear > 0.0)) row.refused = "no light of the scene makes electrons";
    radiometry::add_rows(rows, radiometry::BudgetGroup::signal, {std::move(row)});
  };
  add("path_share", "share of the scene's light that the path lets through", radiometry::scene_radiance);
  add("contrast_share", "the same of a small temperature difference", radiometry::scene_derivative);
}

}  // namespace

BudgetTable budget_table(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, double temperature_k) {
  const radiometry::Budget<double> budget =
      at_its_place(config, [&] { return budget_of(config.system, loaded.sensor, temperature_k); });
  BudgetTable table{.rows = budget_rows(config.system, loaded.sensor, budget),
                    .numbers = budget,
                    .notes = budget_notes(loaded.sensor, budget),
                    .observer = observer_lines(config.system, loaded.sensor),
                    .spatial_gap = spatial_gap(loaded.sensor.settings, budget),
                    .air = loaded.paths                        ? ""
                           : loaded.sensor.settings.path       ? "[path]"
                           : loaded.sensor.settings.atmosphere ? "[atmosphere]"
                                                               : "",
                    .without_path = static_cast<bool>(loaded.paths)};
  for (radiometry::BudgetRow& row : observer_rows(with_electron_rate(config.system, loaded), loaded.sensor, budget))
    table.rows.push_back(std::move(row));
  if (!table.air.empty()) add_path_rows(loaded.sensor, temperature_k, table.rows);
  return table;
}

std::vector<radiometry::BudgetRow> nyquist_rows(const mtf::System<double>& system, const LoadedSensor& loaded) {
  const mtf::System<double> rated = with_electron_rate(system, loaded);
  std::vector<radiometry::BudgetRow> rows;
  for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y}) {
    const std::string name = axis == mtf::Axis::x ? "x" : "y";
    const Direction direction = make_direction(system.frame, "cy/px", axis == mtf::Axis::x ? 0.0 : 90.0);
    const OtfColumn nyquist = otf_curves(rated, {0.5}, direction).system;
    rows.push_back({"mtf_nyquist_" + name, "", std::hypot(nyquist.otf.front().re, nyquist.otf.front().im),
                    "MTF of the whole system at Nyquist along " + name + ", " +
                        mtf::significant(system.frame.nyquist_cy_mm(axis), 4) + " cy/mm"});
    if (nyquist.has_coarse_average())
      rows.back().doc += "; its average over the band errs by up to " + mtf::significant(nyquist.error.front(), 2);
    if (system.settled)
      rows.back().doc += ", at the field point (" + mtf::significant(system.point.x, 3) + ", " +
                         mtf::significant(system.point.y, 3) + ")";
    if (system.is_isoplanatic() || system.frame.columns == 0 || system.frame.rows == 0) continue;
    rows.back().doc += ", on the optical axis";
    const OtfMap map = otf_map(rated, "mtf@nyquist", direction);
    rows.push_back({"mtf_nyquist_" + name + ".mean", "", map.mean,
                    "over the image, to about " + mtf::significant(map.mean_error, 1)});
    rows.push_back({"mtf_nyquist_" + name + ".worst", "", map.worst().value,
                    "lowest of " + std::to_string(map.places.size()) + " places, at pixel (" +
                        mtf::significant(map.worst().x_px, 5) + ", " + mtf::significant(map.worst().y_px, 5) + ")"});
  }
  return rows;
}

}  // namespace apps
