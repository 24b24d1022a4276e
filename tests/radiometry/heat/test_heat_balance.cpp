// SPDX-License-Identifier: Apache-2.0

// Conservation and stability: enclosures in equilibrium, heat that goes nowhere, and the cases in which conduction
// codes of buildings are known to fail (issues of EnergyPlus by number).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "mtf/error.h"
#include "radiometry/heat/surface_loss.h"
#include "radiometry/light/constants.h"
#include "tests/expect_error.h"
#include "tests/radiometry/heat/exact_cases.h"
#include "tests/radiometry/heat/oracle.h"
#include "tests/radiometry/heat/random_facets.h"

namespace radiometry::heat::test {
namespace {

constexpr double kDay_s = 86400.0;
const Layer kAluminium{237.0, 2700.0, 900.0, 0.1}, kConcrete{1.5, 2300.0, 880.0, 0.3}, kFoam{0.02, 15.0, 1400.0, 0.3};

std::vector<double> every(double step_s, double end_s) {
  std::vector<double> times;
  for (int i = 1; i * step_s <= end_s; ++i) times.push_back(i * step_s);
  return times;
}

TEST(HeatBalance, AnIsothermalEnclosureStaysIsothermalForAWeek) {
  for (const double t : {120.0, 287.3, 600.0})
    for (const Inside& inside :
         {Inside{Adiabatic{}}, Inside{FixedTemperature{}}, Inside{InnerFilm{8.0}}, Inside{Sheet{0.3, Tarp{}}}})
      for (const double emissivity : {0.02, 0.97}) {
        const Construction construction{{kFoam, kConcrete}, emissivity, Tarp{}, inside};
        const double sink = kStefanBoltzmann_w_m2_k4 * std::pow(t, 4);
        SteadyForcing forcing{.absorbed_w_m2 = emissivity * sink, .air_k = t, .inside = t};
        forcing.back_w_m2 = 0.3 * sink;
        const Timeline week{0.0, 7.0 * kDay_s, every(kDay_s / 4.0, 7.0 * kDay_s), {}};
        const Solution solution = solve({construction, 1, {}}, forcing, week, UniformStart{t}, 0.1);
        for (const double front : solution.run.front_k) EXPECT_NEAR(front, t, 1e-9);
        for (const double back : solution.run.back_k) EXPECT_NEAR(back, t, 1e-9);
      }
}

/// #8234: what leaves and what enters differ and the difference grows.
TEST(HeatBalance, TheDriftOfADayIsBelow1e12OfTheExchangedHeat) {
  for (std::uint32_t seed = 300; seed < 340; ++seed) {
    RandomFacet facet = random_facet(seed);
    facet.timeline.end_s = kDay_s;
    const Solution solution = solve(facet.batch, facet.forcing, facet.timeline, UniformStart{facet.start_k}, 0.1);
    const HeatBalance& balance = solution.run.balance.front();
    EXPECT_GT(balance.exchanged(), 0.0);
    EXPECT_LT(std::abs(balance.drift()), 1e-12 * balance.exchanged()) << "seed " << seed;
  }
}

TEST(HeatBalance, AnInsulatedBodyKeepsItsHeat) {
  const Construction construction{{kConcrete, kFoam}, 0.0, NoConvection{}, Adiabatic{}};
  const auto hour_of_sun = [](Instant at, std::size_t, ForcingValues& values) {
    const bool lit = at.limit == Instant::Limit::after ? at.time_s < 3600.0 : at.time_s <= 3600.0;
    values.front.absorbed_w_m2[0] = lit ? 800.0 : 0.0;
  };
  const Timeline days{0.0, 3.0 * kDay_s, every(3600.0, 3.0 * kDay_s), {3600.0}};
  const Solution solution = solve({construction, 1, {}}, hour_of_sun, days, UniformStart{290.0}, 0.1);
  const HeatBalance& balance = solution.run.balance.front();
  EXPECT_NEAR(balance.absorbed, 800.0 * 3600.0, 1e-6);
  EXPECT_NEAR(balance.stored, balance.absorbed, 1e-12 * balance.absorbed * 3.0);
}

/// #2872 (a step of the air makes the temperatures oscillate), #172 and #18 (thin aluminium bounces).
TEST(HeatBalance, AStepOfTheAirIsNotOvershot) {
  const std::vector<double> air_k{273.15, 293.15, 343.15, 323.15, 273.15};
  const double hold_s = 4.0 * 3600.0;
  const auto air = [&](Instant at, std::size_t, ForcingValues& values) {
    const double held = at.time_s / hold_s;
    const auto after = static_cast<std::size_t>(held);
    const std::size_t i = at.limit == Instant::Limit::before && held == static_cast<double>(after) ? after - 1 : after;
    values.front.absorbed_w_m2[0] = 0.0;
    values.front.air_k = air_k[std::min(i, air_k.size() - 1)];
  };
  Timeline timeline{0.0, 5.0 * hold_s, every(60.0, 5.0 * hold_s), {}};
  for (int i = 1; i < 5; ++i) timeline.breaks_s.push_back(i * hold_s);
  for (const double thickness_m : {5e-5, 1e-3, 0.1})
    for (const double tolerance_k : {1.0, 0.01}) {
      Layer metal = kAluminium;
      metal.thickness_m = thickness_m;
      const Construction construction{{metal}, 0.0, LinearConvection{25.0, 0.0}, Adiabatic{}};
      const Solution solution = solve({construction, 1, {}}, air, timeline, UniformStart{273.15}, tolerance_k);
      const std::vector<double>& t = solution.run.front_k;
      for (std::size_t i = 1; i < t.size(); ++i) {
        const auto interval =
            std::min(static_cast<std::size_t>(static_cast<double>(i) * 60.0 / hold_s), air_k.size() - 1);
        const double target = air_k[interval];
        if (t[i - 1] < target - tolerance_k) {
          EXPECT_GE(t[i], t[i - 1]) << thickness_m << ' ' << i;
        }
        if (t[i - 1] > target + tolerance_k) {
          EXPECT_LE(t[i], t[i - 1]) << thickness_m << ' ' << i;
        }
        EXPECT_GT(t[i], 273.15 - tolerance_k);
        EXPECT_LT(t[i], 343.15 + tolerance_k);
      }
    }
}

/// #2604 (heavy and resistive layers overflow), #7819 (thin layers of high conductivity crash).
TEST(HeatBalance, StiffConstructionsAgreeWithTheOracle) {
  Layer foil{400.0, 8960.0, 385.0, 5e-5}, heavy = kConcrete;
  heavy.thickness_m = 1.0;
  for (const std::vector<Layer>& layers :
       {std::vector{heavy, kFoam, heavy}, {foil}, {foil, kFoam, foil}, {kFoam, foil, heavy}, {heavy, foil}}) {
    RandomFacet facet = random_facet(7);
    facet.batch.construction.layers = layers;
    const double tolerance_k = 0.1;
    const Solution solution =
        solve(facet.batch, facet.forcing, facet.timeline, UniformStart{facet.start_k}, tolerance_k);
    GridRequest request = solution.plan.request;
    request.density = std::max(4.0, 4.0 * request.density);
    const OracleRun truth =
        oracle_extrapolated(facet.batch, 0, request, facet.forcing, facet.timeline, facet.start_k, 1e-9);
    for (std::size_t i = 0; i < truth.front_k.size(); ++i)
      EXPECT_NEAR(solution.run.front_k[i], truth.front_k[i], solution.run.promised.total_k());
  }
}

/// Facets of one batch that differ in their sun alone.
const Forcing kManySuns = [](Instant at, std::size_t first, ForcingValues& values) {
  for (std::size_t i = 0; i < values.front.absorbed_w_m2.size(); ++i)
    values.front.absorbed_w_m2[i] =
        300.0 + 5.0 * static_cast<double>(first + i) * std::max(0.0, std::sin(at.time_s * 2.0 * M_PI / kDay_s));
  values.front.air_k = 285.0;
  values.front.wind_m_s = 2.0;
};

TEST(HeatSolver, AnIntervalCanBeTakenAgainAndThreadsChangeNothing) {
  const Batch batch{{{kConcrete}, 0.9, McAdams{}, Adiabatic{}}, 150, {}};
  const Timeline day{0.0, kDay_s, every(1800.0, kDay_s), {0.5 * kDay_s}};
  const Plan plan = make_plan(batch, kManySuns, day, UniformStart{290.0}, 0.1);
  const auto whole = advance(plan, uniform_state(plan, 0.0, 290.0), kManySuns, day, 2);

  Timeline half = day;
  half.end_s = 0.5 * kDay_s;
  const auto first = advance(plan, uniform_state(plan, 0.0, 290.0), kManySuns, half, 1);
  half = day;
  half.start_s = 0.5 * kDay_s;
  const auto second = advance(plan, first.end, kManySuns, half, 1),
             again = advance(plan, first.end, kManySuns, half, 2);
  EXPECT_EQ(second.front_k, again.front_k);
  EXPECT_EQ(second.end.fine, whole.end.fine);
  EXPECT_EQ(second.end.coarse, whole.end.coarse);
  EXPECT_EQ(
      std::vector<double>(whole.front_k.end() - static_cast<std::ptrdiff_t>(batch.facets), whole.front_k.end()),
      std::vector<double>(second.front_k.end() - static_cast<std::ptrdiff_t>(batch.facets), second.front_k.end()));
}

/// The trial runs 32 of 150 facets; the promise is kept by all of them, and they are as if solved alone.
TEST(HeatSolver, ABatchKeepsTheToleranceOfEveryFacet) {
  const Batch batch{{{kConcrete}, 0.9, McAdams{}, Adiabatic{}}, 150, {}};
  const Timeline day{0.0, kDay_s, every(1800.0, kDay_s), {0.5 * kDay_s}};
  const Solution all = solve(batch, kManySuns, day, UniformStart{290.0}, 0.05);
  EXPECT_LE(all.run.promised.total_k(), 0.05);
  for (const std::size_t facet : {0, 77, 149}) {
    const Forcing one = [&](Instant at, std::size_t, ForcingValues& values) { kManySuns(at, facet, values); };
    const Solution alone = solve({batch.construction, 1, {}}, one, day, UniformStart{290.0}, 1e-3);
    for (std::size_t i = 0; i < alone.run.front_k.size(); ++i)
      EXPECT_NEAR(all.run.front_k[i * batch.facets + facet], alone.run.front_k[i],
                  all.run.promised.total_k() + alone.run.promised.total_k());
  }
}

/// A plate of one node under a flux q cos(w t) and a linear film: T - T_air = Re[q / (h + i w C) exp(i w t)]. Twice as
/// many steps make the errors of step ends, and of outputs within steps, at least 3 times smaller (4 in the limit).
TEST(HeatSolver, OutputsWithinStepsAreAsGoodAsTheirEnds) {
  const double h = 20.0, q = 400.0, capacity = kAluminium.density_kg_m3 * kAluminium.heat_capacity_j_kg_k * 0.02;
  const Batch batch{{{{237.0, 2700.0, 900.0, 0.02}}, 0.0, LinearConvection{h, 0.0}, Adiabatic{}}, 40, {}};
  const double omega = 2.0 * M_PI / kDay_s;
  const auto exact = [&](double time_s) {
    return 290.0 + (q / std::complex<double>(h, omega * capacity) * std::polar(1.0, omega * time_s)).real();
  };
  const Forcing forcing = [&](Instant at, std::size_t, ForcingValues& values) {
    std::fill(values.front.absorbed_w_m2.begin(), values.front.absorbed_w_m2.end(), q * std::cos(omega * at.time_s));
    values.front.air_k = 290.0;
  };
  std::vector<double> worst_at_ends, worst_within;
  for (const double step_s : {7200.0, 3600.0}) {
    Timeline day{0.0, kDay_s, every(step_s, kDay_s), {}};
    Plan plan = make_plan(batch, forcing, day, UniformStart{exact(0.0)}, 50.0);
    plan.step_tolerance_k = 100.0;
    for (const double share : {0.1, 0.5, 0.9})
      for (double begin = 0.0; begin < kDay_s; begin += step_s) day.between_s.push_back(begin + share * step_s);
    const auto kept = advance(plan, uniform_state(plan, 0.0, exact(0.0), Runs::one), forcing, day);
    ASSERT_EQ(kept.outputs_s.size(), day.outputs_s.size() + day.between_s.size());
    ASSERT_TRUE(std::is_sorted(kept.outputs_s.begin(), kept.outputs_s.end()));
    ASSERT_EQ(kept.steps.taken, 2 * static_cast<std::int64_t>(day.outputs_s.size()));  // of two groups of facets
    double at_ends = 0.0, within = 0.0;
    for (std::size_t i = 0; i < kept.outputs_s.size(); ++i) {
      const bool end = std::fmod(kept.outputs_s[i] + 1.0, step_s) < 2.0;
      double& worst = end ? at_ends : within;
      worst = std::max(worst, std::abs(kept.front_k[i * batch.facets + 39] - exact(kept.outputs_s[i])));
    }
    EXPECT_LT(within, 1.5 * at_ends);
    worst_at_ends.push_back(at_ends);
    worst_within.push_back(within);

    std::vector<double> given(kept.front_k.size(), 0.0);
    const auto sunk = advance(
        plan, uniform_state(plan, 0.0, exact(0.0), Runs::one), for_all_groups(forcing), day, 2,
        [&](std::size_t output, std::size_t first, std::span<const double> front, std::span<const double> back) {
          EXPECT_TRUE(back.empty());
          for (std::size_t i = 0; i < front.size(); ++i) given[output * batch.facets + first + i] = front[i];
        });
    EXPECT_TRUE(sunk.front_k.empty());
    EXPECT_EQ(given, kept.front_k);
  }
  EXPECT_GT(worst_at_ends[0], 3.0 * worst_at_ends[1]);
  EXPECT_GT(worst_within[0], 3.0 * worst_within[1]);
}

/// T^4 overflows: an error and not a search without end.
TEST(HeatSolver, AnAbsurdFluxIsRefused) {
  const Batch batch{{{kConcrete}, 0.9, McAdams{}, Adiabatic{}}, 1, {}};
  const Timeline day{0.0, kDay_s, {kDay_s}, {}};
  const Plan plan = make_plan(batch, SteadyForcing{}, day, UniformStart{290.0}, 1.0);
  EXPECT_THROW(advance(plan, uniform_state(plan, 0.0, 290.0), SteadyForcing{.absorbed_w_m2 = 1e300}, day),
               mtf::RuntimeError);
}

TEST(HeatSolver, AForcingThatIsNotANumberIsNamed) {
  const Batch batch{{{kConcrete}, 0.9, McAdams{}, Adiabatic{}}, 1, {}};
  const Timeline day{0.0, kDay_s, {kDay_s}, {}};
  Plan plan = make_plan(batch, SteadyForcing{}, day, UniformStart{290.0}, 1.0);
  const Forcing broken = [](Instant at, std::size_t, ForcingValues& values) {
    values.front.absorbed_w_m2[0] = at.time_s > 40000.0 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  };
  try {
    advance(plan, uniform_state(plan, 0.0, 290.0), broken, day);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const mtf::RuntimeError& error) {
    EXPECT_TRUE(says(error.what(), "not finite")) << error.what();
  }
}

// Full wind on a wet insulated surface in the dark: it comes to the wet-bulb temperature, where h (T_air - T) pays for
// the evaporation: T_air - T = (e_s(T) - e) / gamma. At 20 degC, 1013.25 hPa and 50 % that is 13.7 to 13.8 degC
// (psychrometric tables of the WMO's guide, ventilated by 0.665e-3 P).
TEST(HeatBalance, AWetSurfaceComesToItsWetBulbTemperature) {
  const Construction felt{.layers = {{0.2, 600.0, 1500.0, 0.001}},
                          .emissivity = 0.0,
                          .convection = LinearConvection{25.0, 0.0},
                          .inside = Adiabatic{},
                          .wet_fraction = 1.0};
  const double vapour_pa = 0.5 * saturation(293.15).pressure_pa;
  const Forcing air = [=](Instant, std::size_t, ForcingValues& values) {
    std::fill(values.front.absorbed_w_m2.begin(), values.front.absorbed_w_m2.end(), 0.0);
    values.front.air_k = 293.15;
    values.front.vapour_pa = vapour_pa;
  };
  const Timeline hours{.start_s = 0.0, .end_s = 36000.0, .outputs_s = {36000.0}, .breaks_s = {}};
  const Solution solution = solve({felt, 1, {}}, air, hours, UniformStart{293.15}, 1e-4);
  const double t = solution.run.front_k.back();
  EXPECT_NEAR(293.15 - t, (saturation(t).pressure_pa - vapour_pa) / (0.665e-3 * 101325.0), 0.01);
  EXPECT_NEAR(t - 273.15, 13.75, 0.15);
  EXPECT_LT(std::abs(solution.run.balance.front().relative_drift()), 1e-12);
  const Solution repeating = solve({felt, 1, {}}, air, hours, RepeatingStart{36000.0}, 1e-4);
  EXPECT_NEAR(repeating.run.front_k.back(), t, 1e-3);
}

// Monotone everywhere, with the slope it says: Newton's method has one solution to find.
TEST(HeatBalance, SaturationRises) {
  double before = saturation(-100.0).pressure_pa;
  for (double t = -95.0; t < 1200.0; t += 5.0) {
    const Vapour here = saturation(t);
    EXPECT_GE(here.pressure_pa, before) << t;
    EXPECT_NEAR(here.slope_pa_k, (saturation(t + 1e-3).pressure_pa - saturation(t - 1e-3).pressure_pa) / 2e-3,
                1e-5 * std::abs(here.slope_pa_k) + 1e-9)
        << t;
    before = here.pressure_pa;
  }
  EXPECT_NEAR(saturation(293.15).pressure_pa, 2338.8, 0.01 * 2338.8);  // IAPWS-95
}

}  // namespace
}  // namespace radiometry::heat::test
