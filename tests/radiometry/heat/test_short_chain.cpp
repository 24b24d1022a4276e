// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/depth/depth_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "radiometry/heat/depth/elimination.h"
#include "radiometry/heat/solver.h"

namespace radiometry::heat::test {
namespace {

constexpr double kDay_s = 86400.0, kFlux_w_m2 = 900.0;
const Layer kSoil{0.3, 1600.0, 800.0, 1.0};
const Layer kRubber{0.16, 1150.0, 2000.0, 0.01};
const Layer kSteel{45.0, 7800.0, 480.0, 0.03};
const Layer kFoam{0.035, 30.0, 1400.0, 0.1};
const Layer kConcrete{1.5, 2300.0, 880.0, 0.2};

double capacity_of(const Grid& grid) { return std::accumulate(grid.capacity.begin(), grid.capacity.end(), 0.0); }

double admittance(const Grid& grid, double s) {
  const Elimination<double> e = eliminate(grid, false, 1.0 / s);
  return e.own / e.a;
}

/// Below its surface a slab gives sqrt(k rho c s) tanh(L sqrt(s / alpha)): Carslaw and Jaeger, Conduction of Heat in
/// Solids, 2nd ed., section 3.7. The grid has errors of its own, of second order, which are the larger ones.
TEST(ShortChain, HasTheAdmittanceOfASlab) {
  const Construction soil{{kSoil}, 0.95, McAdams{}, Adiabatic{}};
  const Grid grid = make_grids(soil, {.short_time_s = 600.0, .density = 20.0}).fine;
  const ShortChain chain = shortened(grid, kFlux_w_m2, kDay_s, 1e-4);
  EXPECT_GT(grid.nodes(), 200u);
  EXPECT_LT(chain.grid.nodes(), 30u);
  EXPECT_GT(chain.error_k, 0.0);
  EXPECT_LE(chain.error_k, 1e-4);
  EXPECT_NEAR(capacity_of(chain.grid), capacity_of(grid), 1e-9 * capacity_of(grid));
  for (const double s : {1e-5, 1e-4, 1e-3}) {
    const double root = std::sqrt(s / kSoil.diffusivity());
    const double slab = kSoil.conductivity_w_m_k * root * std::tanh(kSoil.thickness_m * root);
    EXPECT_NEAR(admittance(chain.grid, s), slab, 1e-3 * slab) << s;
    EXPECT_NEAR(admittance(chain.grid, s), admittance(grid, s), 1e-6 * slab) << s;
  }
}

/// Surface temperatures under flux that jumps every hour, by the same steps on both.
double largest_difference_k(const Construction& construction, const Grid& grid, const Grid& chain) {
  const Forcing jumps = [](Instant at, std::size_t, ForcingValues& values) {
    auto hour = static_cast<int>(at.time_s / 3600.0 + (at.limit == Instant::Limit::before ? -1e-9 : 1e-9));
    std::ranges::fill(values.front.absorbed_w_m2, hour * 7 % 3 == 0 ? 300.0 + kFlux_w_m2 : 300.0);
    values.front.air_k = 285.0;
    values.front.wind_m_s = 1.0;
  };
  Timeline day{.start_s = 0.0, .end_s = kDay_s, .outputs_s = {}, .breaks_s = {}};
  for (double t = 0.0; t <= kDay_s; t += 60.0) day.outputs_s.push_back(t);
  const auto run = [&](const Grid& on) {
    const Plan plan{{construction, 1, {}}, on, on, {}, 1e9, 0.0};
    return advance(plan, uniform_state(plan, 0.0, 290.0, Runs::one), jumps, day).front_k;
  };
  const std::vector<double> a = run(grid), b = run(chain);
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(ShortChain, KeepsItsErrorOverTime) {
  int shorter = 0;
  for (const std::vector<Layer>& layers : std::vector<std::vector<Layer>>{
           {kSoil}, {kRubber, kSteel}, {kSteel, kFoam, kConcrete}, {kFoam, kSteel}, {kConcrete, kSoil}})
    for (const double density : {2.0, 10.0, 40.0})
      for (const double error_k : {1e-2, 1e-3, 1e-4}) {
        const Construction construction{layers, 0.9, McAdams{}, Adiabatic{}};
        const Grid grid = make_grids(construction, {.short_time_s = 600.0, .density = density}).fine;
        const ShortChain chain = shortened(grid, kFlux_w_m2, kDay_s, error_k);
        EXPECT_LE(chain.error_k, error_k);
        EXPECT_LE(chain.grid.nodes(), grid.nodes());
        const double most = largest_difference_k(construction, grid, chain.grid);
        EXPECT_LE(most, chain.error_k) << layers.size() << " layers, density " << density;
        if (chain.grid.nodes() < grid.nodes()) {
          ++shorter;
          EXPECT_GT(most, 0.0);
        }
      }
  EXPECT_GE(shorter, 35);
}

TEST(ShortChain, LeavesGridsThatAreShortAlready) {
  const Construction steel{{kSteel}, 0.9, McAdams{}, Adiabatic{}};
  const Grid grid = make_grids(steel, {.short_time_s = 600.0, .density = 0.5}).fine;
  const ShortChain chain = shortened(grid, kFlux_w_m2, kDay_s, 1e-4);
  EXPECT_EQ(chain.grid.capacity, grid.capacity);
  EXPECT_EQ(chain.grid.depth_m, grid.depth_m);
  EXPECT_EQ(chain.error_k, 0.0);
}

}  // namespace
}  // namespace radiometry::heat::test
