// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/run/heat_run.h"

#include "radiometry/thermal/limits.h"

namespace radiometry::thermal {

HeatReport run_heat(const HeatScene& scene, const HeatOptions& options, const HeatOutputs& output,
                    const HeatProgress& progress) {
  HeatReport report;
  report.timing_ms = scene.timing_ms;
  report.warnings = scene.warnings;

  progress("rays", 0.0);
  const Units units =
      units_of(scene, options, options.every_facet ? 0.0 : units_tolerance_w_m2(scene, options.tolerance_k));
  report.timing_ms.emplace_back("rays", units.rays_ms);
  report.timing_ms.emplace_back("classes", units.classes_ms);
  report.timing_ms.emplace_back("table errors", units.error_ms);

  KeptOutputs kept;
  SurfaceLimits limits(scene);
  UnitsRun solved = solve_units(
      scene, units, options,
      [&](const HeatOutput& at) {
        if (options.verify) kept.keep(at);
        limits.see(at);
        output(at);
      },
      progress);
  for (std::string& text : limits.texts()) report.warnings.push_back(std::move(text));
  report.timing_ms.emplace_back("heat", solved.ms);
  report.promised = solved.promised;
  report.materials = solved.materials;
  report.outputs = solved.outputs;
  report.iterations = solved.iterations;
  report.view_spread = solved.view_spread;
  report.checkpoint = std::move(solved.checkpoint);
  report.facets = scene.facets().size();
  report.units = units.unit.size();
  report.patches = units.exchange.patches();
  report.left_out = solved.left_out;
  report.covered = units.covered;
  report.view_error = units.view_error;
  report.sun_error = units.sun_error;
  // A run that is continued has not all outputs at hand.
  if (options.verify && options.from == nullptr && solved.outputs == scene.surroundings.outputs.size())
    report.verified = verify_heat(scene, units, options, kept, progress);
  if (report.verified) report.timing_ms.emplace_back("verification", report.verified->ms);
  return report;
}

}  // namespace radiometry::thermal
