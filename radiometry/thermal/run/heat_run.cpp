// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/run/heat_run.h"

#include "radiometry/thermal/limits.h"

namespace radiometry::thermal {

HeatReport run_heat(const HeatScene& scene, const HeatOptions& options, const HeatOutputs& output,
                    const HeatProgress& progress) {
  progress("rays", 0.0);
  const Units units =
      units_of(scene, options, options.every_facet ? 0.0 : units_tolerance_w_m2(scene, options.tolerance_k));
  KeptOutputs kept;
  SurfaceLimits limits(scene);
  HeatReport report{solve_units(
      scene, units, options,
      [&](const HeatOutput& at) {
        if (options.verify) kept.keep(at);
        limits.see(at);
        output(at);
      },
      progress)};
  report.warnings = scene.warnings;
  for (std::string& text : limits.texts()) report.warnings.push_back(std::move(text));
  report.timing_ms = scene.timing_ms;
  for (const auto& [name, ms] : {std::pair{"rays", units.rays_ms},
                                 {"classes", units.classes_ms},
                                 {"table errors", units.error_ms},
                                 {"heat", report.ms}})
    report.timing_ms.emplace_back(name, ms);
  report.facets = scene.facets().size();
  report.units = units.unit.size();
  report.patches = units.exchange.patches();
  report.covered = units.covered;
  report.view_error = units.view_error;
  report.sun_error = units.sun_error;
  // A run that is continued has not all outputs at hand.
  if (options.verify && options.from == nullptr && report.outputs == scene.surroundings.outputs.size())
    report.verified = verify_heat(scene, units, options, kept, progress);
  if (report.verified) report.timing_ms.emplace_back("verification", report.verified->ms);
  return report;
}

}  // namespace radiometry::thermal
