// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "radiometry/heat/depth/depth_grid.h"
#include "radiometry/heat/solve.h"
#include "tests/expect_error.h"
#include "tests/radiometry/heat/exact_cases.h"
#include "tests/radiometry/heat/random_facets.h"

namespace radiometry::heat::test {
namespace {

const Layer kSteel{45.0, 7800.0, 480.0, 0.005};

TEST(Construction, NamesTheValueThatIsNotPhysical) {
  const Construction good{{kSteel, kSteel}, 0.9, McAdams{}, Adiabatic{}};
  EXPECT_NO_THROW(require_valid(good, "material[0]"));
  const auto broken = [&](auto change) {
    Construction construction = good;
    change(construction);
    return construction;
  };
  const auto refused = [](const Construction& construction, std::initializer_list<std::string_view> parts) {
    expect_refused(parts, [&] { require_valid(construction, "material[0]"); });
  };
  refused(broken([](Construction& c) { c.layers[1].density_kg_m3 = 0.0; }),
          {"material[0]", "layers[1]", "density", "0"});
  refused(broken([](Construction& c) { c.layers[0].thickness_m = -0.01; }), {"layers[0]", "thickness", "-0.01"});
  refused(broken([](Construction& c) { c.layers[0].conductivity_w_m_k = HUGE_VAL; }), {"conductivity"});
  refused(broken([](Construction& c) { c.layers[0].heat_capacity_j_kg_k = std::nan(""); }), {"heat_capacity"});
  refused(broken([](Construction& c) { c.layers.clear(); }), {"without layers"});
  refused(broken([](Construction& c) { c.emissivity = 1.2; }), {"emissivity", "1.2"});
  refused(broken([](Construction& c) { c.convection = LinearConvection{-1.0, 0.0}; }), {"h0", "-1"});
  refused(broken([](Construction& c) { c.inside = InnerFilm{-2.0}; }), {"inside h", "-2"});
  refused(broken([](Construction& c) { c.inside = Sheet{-0.1, McAdams{}}; }), {"inside emissivity"});
  refused(broken([](Construction& c) { c.inside = Sheet{0.5, Tarp{.roughness = -1.0}}; }), {"inside", "roughness"});
}

TEST(Construction, BatchesAndTolerancesAreChecked) {
  const Construction steel{{kSteel}, 0.9, McAdams{}, Adiabatic{}};
  const Timeline hour{0.0, 3600.0, {3600.0}, {}};
  const auto run = [&](const Batch& batch, const Timeline& timeline, double tolerance_k) {
    solve(batch, SteadyForcing{}, timeline, UniformStart{290.0}, tolerance_k);
  };
  expect_refused({"without facets"}, [&] { run({steel, 0, {}}, hour, 0.1); });
  expect_refused({"`up`", "2 values"}, [&] { run({steel, 1, {0.0, 0.0}}, hour, 0.1); });
  expect_refused({"`up`", "1.5"}, [&] { run({steel, 1, {1.5}}, hour, 0.1); });
  expect_refused({"tolerance"}, [&] { run({steel, 1, {}}, hour, 0.0); });
  expect_refused({"end of the timeline"}, [&] { run({steel, 1, {}}, {10.0, 0.0, {}, {}}, 0.1); });
  expect_refused({"end of the timeline"}, [&] { run({steel, 1, {}}, {10.0, 10.0, {}, {}}, 0.1); });
  expect_refused({"outputs do not rise"}, [&] { run({steel, 1, {}}, {0.0, 10.0, {5.0, 2.0}, {}}, 0.1); });
}

/// 5 mm of steel at 15 W/m2/K: 0.12 m; 1 mm: 55 mm.
TEST(Construction, InPlaneLength) {
  EXPECT_NEAR(in_plane_length_m({{kSteel}, 0.9, McAdams{}, Adiabatic{}}, 15.0), 0.1225, 1e-4);
  EXPECT_NEAR(in_plane_length_m({{{45.0, 7800.0, 480.0, 0.001}}, 0.9, McAdams{}, Adiabatic{}}, 15.0), 0.0548, 1e-4);
}

TEST(Convection, Closures) {
  EXPECT_EQ(forced_coefficient(NoConvection{}, 10.0), 0.0);
  EXPECT_DOUBLE_EQ(forced_coefficient(LinearConvection{5.0, 3.0}, 4.0), 17.0);
  EXPECT_DOUBLE_EQ(forced_coefficient(McAdams{}, 4.0), 20.9);
  EXPECT_DOUBLE_EQ(forced_coefficient(Tarp{1.5, 4.0}, 4.0), 2.537 * 1.5 * 4.0);
  EXPECT_EQ(name_of(Tarp{}), "tarp");
  // Vertical, then a roof: warm air rises from it, cold air rests on it; a ceiling seen from below the other way round.
  EXPECT_EQ(natural_coefficient(Tarp{}, 0.0).warm, 1.31);
  EXPECT_DOUBLE_EQ(natural_coefficient(Tarp{}, 1.0).warm, 9.482 / 6.283);
  EXPECT_DOUBLE_EQ(natural_coefficient(Tarp{}, 1.0).cold, 1.810 / 2.382);
  EXPECT_DOUBLE_EQ(natural_coefficient(Tarp{}, -1.0).warm, natural_coefficient(Tarp{}, 1.0).cold);
  EXPECT_EQ(natural_coefficient(McAdams{}, 1.0).warm, 0.0);
}

TEST(HeatGrid, KeepsCapacityResistanceAndInterfaces) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    Construction construction = random_facet(seed).batch.construction;
    construction.inside = Adiabatic{};
    const Grids grids = make_grids(construction, {.short_time_s = 60.0, .density = 0.3 + 0.1 * seed});
    for (const Grid* grid : {&grids.fine, &grids.coarse}) {
      const double total = std::accumulate(grid->capacity.begin(), grid->capacity.end(), 0.0);
      EXPECT_NEAR(total, capacity(construction), 1e-12 * total);
      double through = 0.0;
      for (const double g : grid->conductance) through += 1.0 / g;
      EXPECT_NEAR(through, resistance(construction), 1e-12 * through);
      double depth = 0.0;
      for (const Layer& layer : construction.layers) {
        depth += layer.thickness_m;
        const auto near = [&](double at) { return std::abs(at - depth) < 1e-12 * depth; };
        EXPECT_TRUE(std::any_of(grid->depth_m.begin(), grid->depth_m.end(), near));
      }
    }
    EXPECT_EQ(grids.fine.nodes(), 2 * grids.coarse.nodes() - 1);
    for (std::size_t i = 0; i < grids.coarse.nodes(); ++i)
      EXPECT_NEAR(grids.fine.depth_m[2 * i], grids.coarse.depth_m[i], 1e-9 * grids.coarse.depth_m[i]);
  }
}

/// What is cut off changes the surface by less than its bound.
TEST(HeatGrid, DepthIsCutWithinItsBound) {
  const Construction deep{{{1.5, 2300.0, 880.0, 5.0}}, 0.9, McAdams{}, Adiabatic{}};
  const double day_s = 86400.0;
  const Cut cut = cut_depth(deep, 50.0, 2.0 * day_s, 0.01);
  EXPECT_LE(cut.error_k, 0.01);
  EXPECT_LT(cut.construction.layers[0].thickness_m, 2.5);
  EXPECT_GT(cut.construction.layers[0].thickness_m, 0.5);
  const SteadyForcing sun{.absorbed_w_m2 = 700.0, .air_k = 290.0, .amplitude_w_m2 = 400.0};
  const Timeline days{0.0, 2.0 * day_s, {day_s, 1.5 * day_s, 2.0 * day_s}, {}};
  const Solution whole = solve({deep, 1, {}}, sun, days, UniformStart{290.0}, 1e-3);
  const Solution part = solve({cut.construction, 1, {}}, sun, days, UniformStart{290.0}, 1e-3);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(whole.run.front_k[i], part.run.front_k[i], cut.error_k + 2e-3);
}

/// A thin plate as one node is within its bound of the plate with layers.
TEST(HeatGrid, OneNodeIsWithinItsBound) {
  const SteadyForcing sun{
      .absorbed_w_m2 = 900.0, .air_k = 290.0, .inside = 320.0, .amplitude_w_m2 = 100.0, .period_s = 3600.0};
  const Timeline hours{0.0, 7200.0, {600.0, 1800.0, 7200.0}, {}};
  for (const Inside& inside :
       {Inside{Adiabatic{}}, Inside{InnerFilm{20.0}}, Inside{InnerFlux{}}, Inside{Sheet{0.9, McAdams{}}}}) {
    const Construction plate{{kSteel}, 0.9, McAdams{}, inside};
    const Solution thick = solve({plate, 1, {}}, sun, hours, UniformStart{290.0}, 1e-3);
    const Solution thin = solve({plate, 1, {}}, sun, hours, UniformStart{290.0}, 2.0);
    EXPECT_GT(thick.plan.fine.nodes(), 1u);
    EXPECT_EQ(thin.plan.fine.nodes(), 1u);
    EXPECT_GT(thin.run.promised.depth_k, 0.0);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(thin.run.front_k[i], thick.run.front_k[i], thin.run.promised.total_k() + 1e-3);
  }
}

}  // namespace
}  // namespace radiometry::heat::test
