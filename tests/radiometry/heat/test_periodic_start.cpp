// SPDX-License-Identifier: Apache-2.0

// The periodic state by a second route: the exact admittance of layers for linear films, and many days one after
// another for the full balance.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "mtf/error.h"
#include "tests/radiometry/heat/exact_cases.h"
#include "tests/radiometry/heat/random_facets.h"

namespace radiometry::heat::test {
namespace {

using Complex = std::complex<double>;
constexpr double kDay_s = 86400.0;

/// Heat flow into the surface over its temperature at one frequency, layer after layer from the inside (thermal
/// quadrupoles: Carslaw & Jaeger, 3.7).
Complex admittance(const std::vector<Layer>& layers, double inner_film, double omega) {
  Complex y = inner_film;
  for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer) {
    const Complex wave = std::sqrt(Complex(0.0, omega / layer->diffusivity()));
    const Complex own = layer->conductivity_w_m_k * wave, t = std::tanh(wave * layer->thickness_m);
    y = (y + own * t) / (1.0 + y / own * t);
  }
  return y;
}

TEST(PeriodicStart, AgreesWithTheFourierSeriesOfLinearLayers) {
  const double film = 17.0, inner = 6.0;
  const std::vector<double> amplitude{200.0, 80.0, 30.0};  // of harmonics 1, 2 and 4
  const std::vector<double> order{1.0, 2.0, 4.0};
  const auto flux = [&](Instant at, std::size_t, ForcingValues& values) {
    double sum = 0.0;
    for (std::size_t k = 0; k < order.size(); ++k)
      sum += amplitude[k] * std::sin(2.0 * std::numbers::pi * order[k] * at.time_s / kDay_s);
    values.front.absorbed_w_m2[0] = sum;
    values.front.air_k = values.inside = 290.0;
  };
  Timeline day{0.0, kDay_s, {}, {}};
  for (int i = 0; i <= 48; ++i) day.outputs_s.push_back(kDay_s * i / 48.0);
  for (std::uint32_t seed = 500; seed < 512; ++seed) {
    Construction construction = random_facet(seed).batch.construction;
    construction.emissivity = 0.0;
    construction.convection = LinearConvection{film, 0.0};
    construction.inside = InnerFilm{inner};
    const Solution solution = solve({construction, 1, {}}, flux, day, RepeatingStart{}, 0.01);
    for (std::size_t i = 0; i < day.outputs_s.size(); ++i) {
      double exact = 290.0;
      for (std::size_t k = 0; k < order.size(); ++k) {
        const double omega = 2.0 * std::numbers::pi * order[k] / kDay_s;
        exact += (amplitude[k] / (film + admittance(construction.layers, inner, omega)) *
                  std::polar(1.0, omega * day.outputs_s[i]))
                     .imag();
      }
      EXPECT_NEAR(solution.run.front_k[i], exact, solution.run.promised.total_k()) << seed;
    }
  }
}

/// Sun by day, emission and natural convection, wind that rises in the afternoon.
const Forcing kRealDay = [](Instant at, std::size_t, ForcingValues& values) {
  const double turn = 2.0 * std::numbers::pi * at.time_s / kDay_s;
  std::fill(values.front.absorbed_w_m2.begin(), values.front.absorbed_w_m2.end(),
            250.0 + 700.0 * std::max(0.0, -std::cos(turn)));
  std::fill(values.back.absorbed_w_m2.begin(), values.back.absorbed_w_m2.end(), 300.0);
  values.front.air_k = values.back.air_k = 285.0 - 6.0 * std::cos(turn - 0.5);
  values.front.wind_m_s = values.back.wind_m_s = 2.0 - std::sin(turn);
  values.inside = 295.0;
};

Timeline real_day() {
  Timeline day{0.0, kDay_s, {}, {0.25 * kDay_s, 0.75 * kDay_s}};
  for (int i = 0; i <= 24; ++i) day.outputs_s.push_back(3600.0 * i);
  return day;
}

TEST(PeriodicStart, IsWhatManyDaysTendTo) {
  const Layer concrete{1.5, 2300.0, 880.0, 0.2};
  for (const Inside& inside :
       {Inside{Adiabatic{}}, Inside{InnerFilm{5.0}}, Inside{FixedTemperature{}}, Inside{Sheet{0.5, Tarp{}}}}) {
    const Batch batch{{{concrete}, 0.92, Tarp{}, inside}, 1, {0.3}};
    const Solution start = solve(batch, kRealDay, real_day(), RepeatingStart{}, 0.01);
    EXPECT_LE(start.run.promised.start_k, 0.0005);

    State state = uniform_state(start.plan, 0.0, 290.0);
    radiometry::heat::Run day;
    for (int i = 0; i < 20; ++i) {
      day = advance(start.plan, state, kRealDay, real_day());
      state = day.end;
      state.time_s = 0.0;
    }
    for (std::size_t i = 0; i < day.front_k.size(); ++i)
      EXPECT_NEAR(start.run.front_k[i], day.front_k[i], start.run.promised.total_k());
  }
}

/// 1 m of rock has a mode of 3.9 days: from a uniform start it changes for weeks.
TEST(PeriodicStart, TakesFewDaysForThickRock) {
  const Batch batch{{{{2.5, 2600.0, 800.0, 1.0}}, 0.95, McAdams{}, Adiabatic{}}, 1, {}};
  const Timeline day = real_day();
  const Plan plan = make_plan(batch, kRealDay, day, UniformStart{285.0}, 0.1);
  const PeriodicStart start = periodic_start(plan, kRealDay, day, 0.02);
  EXPECT_LE(start.error_k, 0.02);
  EXPECT_LE(start.periods, 4);
  const auto next = advance(plan, start.state, kRealDay, day);
  for (std::size_t i = 0; i < plan.fine.nodes(); ++i) EXPECT_NEAR(next.end.fine[i], start.state.fine[i], 0.02);
  const auto uniform = advance(plan, uniform_state(plan, 0.0, 285.0), kRealDay, day);
  EXPECT_GT(std::abs(uniform.end.fine.front() - next.end.fine.front()), 1.0);
}

/// A state that is 2 K too warm, as after another light: days alone take weeks, a correction takes one day.
TEST(PeriodicStart, IsCorrectedByWhatADayChanges) {
  const Batch batch{{{{2.5, 2600.0, 800.0, 1.0}}, 0.95, McAdams{}, Adiabatic{}}, 1, {}};
  const Timeline day = real_day();
  const Plan plan = make_plan(batch, kRealDay, day, UniformStart{285.0}, 0.1);
  const PeriodicStart start = periodic_start(plan, kRealDay, day, 0.001);
  State warm = start.state;
  for (double& t : warm.fine) t += 2.0;
  warm.doubled = {};
  warm.coarse = {};
  const auto residual = [&](const State& begin, State& end) {
    end = advance(plan, begin, for_all_groups(kRealDay), day).end;
    double most = 0.0;
    for (std::size_t i = 0; i < begin.fine.size(); ++i) most = std::max(most, std::abs(end.fine[i] - begin.fine[i]));
    return most;
  };
  State end, later;
  const double before = residual(warm, end);
  State next = end;
  next.time_s = 0.0;
  const double plain = residual(next, later);
  EXPECT_GT(plain, 0.2 * before);
  const State step = newton_step(plan, start.slopes, warm, end);
  for (std::size_t i = 0; i < step.fine.size(); ++i) {
    EXPECT_NEAR(step.fine[i], -2.0, 0.2);
    warm.fine[i] += step.fine[i];
  }
  const double corrected = residual(warm, later);
  EXPECT_LT(corrected, 0.09 * before);  // what the approximation of the correction leaves, at most
}

/// 2 m of rock behind a film of a quarter of a watt: its time constant is 192 days. What a day changes is a
/// two-hundredth of what the state is off by.
TEST(PeriodicStart, IsBoundedForABodyThatTakesHalfAYear) {
  const double film = 0.25, amplitude = 300.0, omega = 2.0 * std::numbers::pi / kDay_s;
  const Construction rock{
      .layers = {{2.5, 2600.0, 800.0, 2.0}}, .emissivity = 0.0, .convection = LinearConvection{film, 0.0}};
  const auto flux = [&](Instant at, std::size_t, ForcingValues& values) {
    values.front.absorbed_w_m2[0] = 5.0 + amplitude * std::sin(omega * at.time_s);
    values.front.air_k = 280.0;
  };
  Timeline day{0.0, kDay_s, {}, {}};
  for (int i = 0; i <= 24; ++i) day.outputs_s.push_back(3600.0 * i);
  for (const double tolerance_k : {0.1, 0.01}) {
    const Solution solution = solve({rock, 1, {}}, flux, day, RepeatingStart{}, tolerance_k);
    const Complex response = amplitude / (film + admittance(rock.layers, 0.0, omega));
    for (std::size_t i = 0; i < day.outputs_s.size(); ++i) {
      const double exact = 280.0 + 5.0 / film + (response * std::polar(1.0, omega * day.outputs_s[i])).imag();
      EXPECT_NEAR(solution.run.front_k[i], exact, solution.run.promised.total_k()) << tolerance_k;
    }
  }
}

TEST(PeriodicStart, RefusesABodyWhoseMeanIsNotDetermined) {
  const Batch batch{{{{2.5, 2600.0, 800.0, 0.5}}, 0.0, NoConvection{}, Adiabatic{}}, 1, {}};
  EXPECT_THROW(solve(batch, SteadyForcing{}, real_day(), RepeatingStart{}, 0.1), mtf::UsageError);
}

}  // namespace
}  // namespace radiometry::heat::test
