// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/observer_rows.h"

#include <cmath>

#include "apps/sensor/air_course.h"
#include "mtf/error.h"
#include "mtf/metrics/resolution.h"
#include "radiometry/chain/sensor_numbers.h"
#include "radiometry/performance/condition_lines.h"
#include "radiometry/performance/target_at_range.h"

namespace apps {
namespace {

/// Why a sensor has neither, "" where it has both.
std::string gap_of(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                   const radiometry::Budget<double>& budget) {
  if (const std::string refused = refusal_of(budget, budget.netd_k); !refused.empty()) return refused;
  if (!budget.dither.dithered()) return words(budget.dither);
  constexpr double kMost_k = 1e6;  // of MrtdInput
  if (!(budget.netd_k <= kMost_k && budget.spatial_netd_k <= kMost_k))
    return "the noise is no temperature difference: an NETD of " + mtf::three_digits(budget.netd_k) +
           " K and a spatial one of " + mtf::three_digits(budget.spatial_netd_k) + " K";
  if (!(system.frame.focal_length_mm > 0.0)) return "no [frame] focal_length";
  const auto& frame = sensor.settings.frame;
  if (sensor.settings.thermal && !(frame && frame->frame_time_s)) return "no [frame] frame_time";
  return "";
}

}  // namespace

std::vector<std::string> observer_lines(const radiometry::Sensor& sensor) {
  const std::string air = air_words(sensor.settings);
  return radiometry::condition_lines(
      {.bars = true}, {}, {}, air.empty() ? "" : air + "; temperature differences are those of the scene behind it");
}

std::vector<radiometry::BudgetRow> observer_rows(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                                                 const radiometry::Budget<double>& budget) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  radiometry::BudgetRow mrtd{"mrtd", "mK", none, "minimum resolvable temperature difference at half of Nyquist, 2-D"},
      mdtd{"mdtd", "mK", none, "minimum detectable temperature difference of a square of 1 / Nyquist"};
  mrtd.refused = mdtd.refused = gap_of(system, sensor, budget);
  mrtd.saturated = mdtd.saturated = is_saturated(budget, budget.netd_k);
  if (!mrtd.refused.empty()) return {mrtd, mdtd};
  try {
    mtf::ResolutionNeeds needs;
    needs.curves = true;
    needs.tolerance = 1e-6;
    const auto resolution =
        std::make_shared<const mtf::Resolution<double>>(mtf::ResolutionMeter<double>(needs).measure(system));
    const radiometry::BarObserver<double> observer(system, {}, frame_time_s(system, sensor.settings));
    const radiometry::SensorAtRange<double> seen{.netd_k = budget.netd_k,
                                                 .spatial_netd_k = budget.spatial_netd_k,
                                                 .otf = radiometry::seen_otf(resolution, system.frame)};
    const double nyquist = observer.nyquist_cy_mrad();
    mrtd.value = 1e3 * observer.mrtd_k(seen, 0.5 * nyquist);
    mdtd.value =
        1e3 * observer.mdtd_k(seen, 1.0 / nyquist, radiometry::counted_cy_mrad(system, resolution->cutoff_cy_mm));
    for (radiometry::BudgetRow* row : {&mrtd, &mdtd})
      if (!std::isfinite(row->value)) row->refused = radiometry::kNotResolved;
  } catch (const mtf::Error& error) {
    mrtd.refused = mdtd.refused = error.what();
  }
  return {mrtd, mdtd};
}

}  // namespace apps
