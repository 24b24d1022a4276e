// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/heat_run.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/scene/heat/ground.h"
#include "apps/scene/heat/stopwatch.h"
#include "radiometry/light/constants.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

/// What a surface of the scene gives off for each kelvin, at least: the film in the weakest wind and radiation at the
/// coldest air.
double least_loss(const HeatScene& scene) {
  const Surroundings& s = scene.surroundings;
  const double coldest = *std::min_element(s.air_k.begin(), s.air_k.end());
  const double calmest = *std::min_element(s.wind_m_s.begin(), s.wind_m_s.end());
  double least = std::numeric_limits<double>::infinity();
  for (const Surface& material : scene.material) {
    const heat::Construction& c = material.construction;
    const double radiation = 4.0 * c.emissivity * radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(coldest, 3);
    least = std::min(least, forced_coefficient(c.convection, calmest) + radiation);
  }
  return std::isfinite(least) ? std::max(least, 0.1) : 1.0;
}

/// Shares of the tolerance.
struct Shares {
  double solver_k, ground_k, units_k, exchange_k;
};
Shares shares_of(double tolerance_k) {
  return {0.35 * tolerance_k, 0.05 * tolerance_k, 0.3 * tolerance_k, 0.05 * tolerance_k};
}

}  // namespace

HeatReport run_heat(const HeatScene& scene, const HeatOptions& options,
                    const std::function<void(const HeatOutput&)>& output,
                    const std::function<void(const std::string&, double)>& progress) {
  const Surroundings& s = scene.surroundings;
  const Shares shares = shares_of(options.tolerance_k);
  const double loss = least_loss(scene);
  HeatReport report;
  report.timing_ms = scene.timing_ms;
  report.warnings = scene.warnings;

  progress("rays", 0.0);
  const Units units = units_of(scene, options, shares.units_k * loss);
  report.timing_ms.emplace_back("rays", units.rays_ms);
  report.timing_ms.emplace_back("table errors", units.error_ms);

  const Stopwatch watch;
  const Ground ground = ground_of(scene, shares.ground_k);
  HeatBatches batches(scene, units, ground.light, shares.solver_k, options.threads);
  const std::vector<Window> windows = windows_of(s);
  std::vector<double> front(scene.region.size()), back(units.has_sheets() ? scene.region.size() : 0);
  const auto emit = [&](std::size_t node) {
    for (std::size_t f = 0; f < front.size(); ++f) {
      const Unit& unit = units.unit[units.unit_of[f]];
      front[f] = batches.receiver_k(node, unit.receiver);
      if (!back.empty())
        back[f] = unit.back ? batches.receiver_k(node, unit.receiver + 1) : std::numeric_limits<double>::quiet_NaN();
    }
    output({s.time_s[node], front, back});
    ++report.outputs;
  };
  auto next = s.outputs.begin();
  for (std::size_t w = 0; w < windows.size() && next != s.outputs.end(); ++w) {
    progress("heat", static_cast<double>(w) / static_cast<double>(windows.size()));
    const Relaxed relaxed = batches.solve(windows[w], w == 0, shares.exchange_k, loss);
    report.iterations = std::max(report.iterations, relaxed.iterations);
    report.promised.exchange_k = std::max(report.promised.exchange_k, relaxed.error_k);
    report.promised.feedback = std::max(report.promised.feedback, 1.0 / (1.0 - relaxed.ratio));
    for (; next != s.outputs.end() && *next <= windows[w].last; ++next) emit(*next);
  }
  report.timing_ms.emplace_back("heat", watch.ms());

  report.materials = batches.materials();
  for (const MaterialRun& run : report.materials)
    if (run.promised.total_k() > report.promised.solver.total_k()) report.promised.solver = run.promised;
  if (ground.run) {
    report.promised.ground_k = ground.run->promised.total_k();
    report.materials.push_back(*ground.run);
  }
  report.promised.units_k = units.bound_w_m2 / loss;
  report.facets = scene.region.size();
  report.units = units.unit.size();
  report.patches = units.exchange.patches();
  report.view_error = units.view_error;
  report.sun_error = units.sun_error;
  return report;
}

}  // namespace apps::scene
