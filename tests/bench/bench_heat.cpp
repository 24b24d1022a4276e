// SPDX-License-Identifier: Apache-2.0

// Surface temperatures of 2000 facets over 48 h in outputs of 10 min: processor time of one thread, beside SUNDIALS
// CVODE (backward differences, banded analytic Jacobian, restarts at the jumps of each facet alone) on the same grid
// and at the same realised error of the time steps. Six constructions in equal shares, random orientation and sky, sun
// and wind that rise and fall over the day, shadows that jump in 6 % of the intervals: of every facet on its own, or of
// 16 neighbours together.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "mtf/version.h"
#include "radiometry/heat/solve.h"
#include "tests/radiometry/heat/oracle.h"

namespace {

using namespace radiometry::heat;

constexpr double kDay_s = 86400.0, kInterval_s = 600.0, kEnd_s = 2.0 * kDay_s, kTolerance_k = 0.1;
constexpr std::size_t kIntervals = 288, kFacets = 2000;
constexpr double kStart_k = 285.0;

double seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Named {
  const char* name;
  Layer layer;
};
const Named kConstructions[] = {
    {"foil 0.1 mm", {237.0, 2700.0, 900.0, 1e-4}}, {"steel 1 mm", {45.0, 7800.0, 480.0, 1e-3}},
    {"steel 20 mm", {45.0, 7800.0, 480.0, 0.02}},  {"concrete 0.3 m", {1.5, 2300.0, 880.0, 0.3}},
    {"rock 1 m", {2.5, 2600.0, 800.0, 1.0}},       {"foam 50 mm", {0.03, 40.0, 1400.0, 0.05}}};

/// One construction with its facets under the sun.
struct Scene {
  Batch batch;
  Timeline timeline;
  std::vector<double> facing, sky;  ///< per facet
  std::vector<double> lit;          ///< 1 or 0: [interval * facets + facet]
  Forcing forcing;

  bool flips(std::size_t interval, std::size_t facet) const {
    return lit[interval * batch.facets + facet] != lit[(interval - 1) * batch.facets + facet];
  }
  Timeline timeline_of(std::size_t facet) const {
    Timeline own = timeline;
    own.breaks_s.clear();
    for (std::size_t i = 1; i < kIntervals; ++i)
      if (flips(i, facet)) own.breaks_s.push_back(kInterval_s * static_cast<double>(i));
    return own;
  }
};

Scene scene_of(const Layer& layer, std::size_t facets, std::size_t neighbours, std::uint32_t seed) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  Scene scene{.batch = {{{layer}, 0.9, McAdams{}, Adiabatic{}}, facets, {}},
              .timeline = {0.0, kEnd_s, {}, {}},
              .facing = {},
              .sky = {},
              .lit = {},
              .forcing = {}};
  for (std::size_t i = 1; i <= kIntervals; ++i)
    scene.timeline.outputs_s.push_back(kInterval_s * static_cast<double>(i));
  scene.lit.assign(kIntervals * facets, 1.0);
  for (std::size_t facet = 0; facet < facets; ++facet) {
    scene.facing.push_back(800.0 * uniform());
    scene.sky.push_back(250.0 + 100.0 * uniform());
    double now = 1.0;
    for (std::size_t i = 0; i < kIntervals; ++i) {
      if (facet % neighbours == 0) now = uniform() < 0.06 ? 1.0 - now : now;
      scene.lit[i * facets + facet] = facet % neighbours == 0 ? now : scene.lit[i * facets + facet - 1];
    }
  }
  for (std::size_t i = 1; i < kIntervals; ++i) {
    bool any = false;
    for (std::size_t facet = 0; facet < facets; ++facet) any |= scene.flips(i, facet);
    if (any) scene.timeline.breaks_s.push_back(kInterval_s * static_cast<double>(i));
  }
  return scene;
}

Forcing forcing_of(const Scene& scene) {
  return [&scene](Instant at, std::size_t first, ForcingValues& values) {
    const double turn = 2.0 * std::numbers::pi * at.time_s / kDay_s, sine = std::sin(turn);
    const double sun = std::max(0.0, sine) * sine;  // smooth at sunrise
    const double interval = at.time_s / kInterval_s;
    auto i = static_cast<std::size_t>(interval);
    if (at.limit == Instant::Limit::before && interval == static_cast<double>(i)) --i;
    i = std::min(i, kIntervals - 1);
    const double* lit = &scene.lit[i * scene.batch.facets + first];
    for (std::size_t l = 0; l < values.front.absorbed_w_m2.size(); ++l)
      values.front.absorbed_w_m2[l] = scene.sky[first + l] + lit[l] * sun * scene.facing[first + l];
    values.front.air_k = 285.0 + 5.0 * sine;
    values.front.wind_m_s = 3.0 + 2.0 * sine;
  };
}

double worst(const std::vector<double>& run, std::size_t facets, std::size_t facet, const std::vector<double>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    largest = std::max(largest, std::abs(run[i * facets + facet] - truth[i]));
  return largest;
}

struct Sum {
  double solver_s = 0.0, with_plan_s = 0.0, cvode_s = 0.0;
};

void compare(const Named& named, std::size_t neighbours, Sum& sum) {
  constexpr std::size_t kShare = kFacets / std::size(kConstructions), kChecked = 24;
  Scene scene = scene_of(named.layer, kShare, neighbours, 1);
  const Forcing forcing = forcing_of(scene);
  double start = seconds();
  const Plan plan = make_plan(scene.batch, forcing, scene.timeline, UniformStart{kStart_k}, kTolerance_k);
  const double plan_s = seconds() - start;
  const State state = uniform_state(plan, 0.0, kStart_k);
  start = seconds();
  const Run run = advance(plan, state, forcing, scene.timeline);
  const double solver_s = seconds() - start;

  const auto cvode = [&](std::size_t facet, double relative) {
    return test::oracle(scene.batch, facet, plan.fine, forcing, scene.timeline_of(facet),
                        std::vector<double>(plan.fine.nodes(), kStart_k), relative, 1e-2 * relative * kStart_k);
  };
  double realised = 0.0;
  std::vector<std::vector<double>> truth;
  for (std::size_t i = 0; i < kChecked; ++i) {
    const std::size_t facet = i * kShare / kChecked;
    truth.push_back(cvode(facet, 1e-10).front_k);
    realised = std::max(realised, worst(run.front_k, kShare, facet, truth.back()));
  }
  // The loosest tolerance of CVODE, in steps of 10^(1/4), with at most our error.
  double relative = 1e-2, rival = HUGE_VAL;
  for (; rival > realised && relative > 1e-9; relative /= rival > realised ? std::pow(10.0, 0.25) : 1.0) {
    rival = 0.0;
    for (std::size_t i = 0; i < kChecked && rival <= realised; ++i) {
      const std::size_t facet = i * kShare / kChecked;
      rival = std::max(rival, worst(cvode(facet, relative).front_k, 1, 0, truth[i]));
    }
  }
  start = seconds();
  for (std::size_t facet = 0; facet < kShare; ++facet) cvode(facet, relative);
  const double cvode_s = seconds() - start;
  sum.solver_s += solver_s;
  sum.with_plan_s += solver_s + plan_s;
  sum.cvode_s += cvode_s;
  const double facet_steps = static_cast<double>(run.steps.facet_steps);
  std::printf("%-15s %5zu  %8.4f %8.4f  %8.4f %8.1e  %8.3f %8.3f %9.1f  %8.3f %7.1f\n", named.name, plan.fine.nodes(),
              run.promised.steps_k, run.promised.grid_k, realised, relative, solver_s, plan_s,
              1e9 * solver_s / facet_steps, cvode_s, cvode_s / solver_s);
}

/// One TR-BDF2 step of one facet, by nodes.
void steps_alone() {
  std::printf("\nns a facet-step by nodes, the forcing included:");
  for (const double density : {0.35, 0.7, 1.4, 2.8}) {
    Scene scene = scene_of(kConstructions[3].layer, 1024, 1024, 2);
    std::fill(scene.lit.begin(), scene.lit.end(), 1.0);
    scene.timeline.breaks_s.clear();
    Grids grids = make_grids(scene.batch.construction, {.short_time_s = kInterval_s, .density = density});
    const Plan plan{scene.batch, grids.fine, grids.fine, {}, 1e9, 0.0};
    const State state = uniform_state(plan, 0.0, kStart_k);
    const Forcing forcing = forcing_of(scene);
    double best = HUGE_VAL, count = 0.0;
    for (int repeat = 0; repeat < 3; ++repeat) {
      const double start = seconds();
      count = static_cast<double>(advance(plan, state, forcing, scene.timeline).steps.facet_steps);
      best = std::min(best, seconds() - start);
    }
    std::printf("  %zu: %.1f", grids.fine.nodes(), 1e9 * best / count);
  }
  std::printf("\n");
}

}  // namespace

int main() {
  std::printf("mtfkit %s (%s); one thread, %zu facets, 48 h, tolerance %g K\n", mtf::version, mtf::git_commit, kFacets,
              kTolerance_k);
  for (const std::size_t neighbours : {1, 16}) {
    std::printf(
        "\nshadows of %zu facets together: errors of the steps and the grid promised, of the steps realised, K; "
        "times in s\n",
        neighbours);
    std::printf("%-15s %5s  %8s %8s  %8s %8s  %8s %8s %9s  %8s %7s\n", "construction", "nodes", "steps", "grid",
                "realised", "rtol", "solver", "plan", "ns/step", "cvode", "ratio");
    Sum sum;
    for (const Named& named : kConstructions) compare(named, neighbours, sum);
    std::printf("all: solver %.3f s (with plans %.3f s), cvode %.3f s: %.1f times (%.1f with plans)\n", sum.solver_s,
                sum.with_plan_s, sum.cvode_s, sum.cvode_s / sum.solver_s, sum.cvode_s / sum.with_plan_s);
  }
  steps_alone();
  return 0;
}
