// SPDX-License-Identifier: Apache-2.0
#include "tests/radiometry/heat/random_facets.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace radiometry::heat::test {
namespace {

constexpr double kHour_s = 3600.0;

struct Random {
  std::mt19937_64 engine;
  double between(double lo, double hi) { return lo + (hi - lo) * static_cast<double>(engine() >> 11) * 0x1p-53; }
  double log_between(double lo, double hi) { return std::exp(between(std::log(lo), std::log(hi))); }
  std::size_t one_of(std::size_t count) { return engine() % count; }
};

Convection random_convection(Random& random) {
  switch (random.one_of(4)) {
    case 0:
      return NoConvection{};
    case 1:
      return McAdams{};
    case 2:
      return Tarp{.roughness = random.between(1.0, 2.17), .perimeter_over_area_m = random.log_between(0.1, 10.0)};
    default:
      return LinearConvection{random.between(0.0, 10.0), random.between(0.0, 5.0)};
  }
}

Inside random_inside(Random& random, std::size_t kind) {
  switch (kind) {
    case 0:
      return Adiabatic{};
    case 1:
      return FixedTemperature{};
    case 2:
      return InnerFilm{random.log_between(0.1, 50.0)};
    case 3:
      return InnerFlux{};
    default:
      return Sheet{random.between(0.02, 1.0), random_convection(random)};
  }
}

/// Weather and shadows of one facet: a sun that is 0 or follows a sine, wind and air as sines, inside with one jump.
struct Day {
  double sun = 0.0, absorptance = 0.0, long_wave = 0.0, air_k = 0.0, air_swing_k = 0.0, wind = 0.0, gust = 0.0;
  double inside = 0.0, inside_jump = 0.0, jump_s = 0.0, back = 0.0;
  std::vector<double> flips_s;  ///< the sun is on after every second one

  void operator()(Instant at, std::size_t, ForcingValues& values) const {
    const bool after = at.limit == Instant::Limit::after;
    const auto passed = (after ? std::upper_bound(flips_s.begin(), flips_s.end(), at.time_s)
                               : std::lower_bound(flips_s.begin(), flips_s.end(), at.time_s)) -
                        flips_s.begin();
    const double turn = 2.0 * std::numbers::pi * at.time_s / (24.0 * kHour_s);
    const double lit = passed % 2 == 0 ? 0.0 : sun * (0.6 + 0.4 * std::sin(2.0 * turn));
    std::fill(values.front.absorbed_w_m2.begin(), values.front.absorbed_w_m2.end(), absorptance * lit + long_wave);
    std::fill(values.back.absorbed_w_m2.begin(), values.back.absorbed_w_m2.end(), back + 0.2 * absorptance * lit);
    values.front.air_k = values.back.air_k = air_k + air_swing_k * std::sin(turn - 1.0);
    values.front.wind_m_s = values.back.wind_m_s = wind + gust * std::sin(6.0 * turn);
    values.inside = inside + ((after ? at.time_s >= jump_s : at.time_s > jump_s) ? inside_jump : 0.0);
  }
};

}  // namespace

RandomFacet random_facet(std::uint32_t seed) {
  Random random{std::mt19937_64(seed)};
  RandomFacet facet{.batch = {}, .forcing = {}, .timeline = {}, .start_k = random.between(270.0, 310.0)};
  const std::size_t layers = 1 + random.one_of(3);
  for (std::size_t i = 0; i < layers; ++i)
    facet.batch.construction.layers.push_back({.conductivity_w_m_k = random.log_between(1e-3, 400.0),
                                               .density_kg_m3 = random.log_between(30.0, 9000.0),
                                               .heat_capacity_j_kg_k = random.between(380.0, 2000.0),
                                               .thickness_m = random.log_between(5e-5, 1.0)});
  facet.batch.construction.emissivity = random.between(0.02, 1.0);
  facet.batch.construction.convection = random_convection(random);
  facet.batch.construction.inside = random_inside(random, seed % 5);
  facet.batch.facets = 1;
  facet.batch.up = {random.between(-1.0, 1.0)};

  Day day;
  day.sun = random.between(0.0, 1361.0);
  day.absorptance = random.between(0.1, 1.0);
  day.long_wave = facet.batch.construction.emissivity * random.between(150.0, 450.0);
  day.back = random.between(0.0, 300.0);
  day.air_k = random.between(265.0, 305.0);
  day.air_swing_k = random.between(0.0, 8.0);
  day.wind = random.between(0.0, 1.0) < 0.2 ? 0.0 : random.between(0.0, 20.0);
  day.gust = random.between(0.0, 0.5) * day.wind;
  const bool flux = std::holds_alternative<InnerFlux>(facet.batch.construction.inside);
  day.inside = flux ? random.between(-20.0, 50.0) : random.between(280.0, 320.0);
  day.inside_jump = flux ? random.between(-20.0, 20.0) : random.between(-20.0, 40.0);
  day.jump_s = random.between(0.0, 12.0 * kHour_s);
  for (double t = 0.0; (t += random.log_between(300.0, 4.0 * kHour_s)) < 12.0 * kHour_s;) day.flips_s.push_back(t);

  facet.timeline = {.start_s = 0.0, .end_s = 12.0 * kHour_s, .outputs_s = {}, .breaks_s = day.flips_s};
  facet.timeline.breaks_s.push_back(day.jump_s);
  std::sort(facet.timeline.breaks_s.begin(), facet.timeline.breaks_s.end());
  for (int i = 1; i <= 72; ++i) facet.timeline.outputs_s.push_back(600.0 * i);
  facet.forcing = day;
  return facet;
}

RandomFacet random_heated_facet(std::uint32_t seed) {
  Random random{std::mt19937_64(seed + 2000000ULL)};
  RandomFacet facet = random_facet(seed);
  Construction& construction = facet.batch.construction;
  construction.generates = true;
  const double on_s = random.between(0.0, 4.0 * kHour_s), off_s = on_s + random.between(600.0, 6.0 * kHour_s);
  std::vector<double> power_w_m3;
  for (const Layer& layer : construction.layers)
    power_w_m3.push_back(random.between(-100.0, 400.0) / layer.thickness_m /
                         static_cast<double>(construction.layers.size()));
  facet.timeline.breaks_s.insert(facet.timeline.breaks_s.end(), {on_s, off_s});
  std::sort(facet.timeline.breaks_s.begin(), facet.timeline.breaks_s.end());
  facet.forcing = [day = facet.forcing, power_w_m3, on_s, off_s](Instant at, std::size_t first, ForcingValues& values) {
    day(at, first, values);
    const bool after = at.limit == Instant::Limit::after;
    const bool on = (after ? at.time_s >= on_s : at.time_s > on_s) && !(after ? at.time_s >= off_s : at.time_s > off_s);
    const double part = on ? 1.0 : 0.2 * std::sin(at.time_s / kHour_s);
    for (std::size_t i = 0; i < values.source_w_m3.size(); ++i) values.source_w_m3[i] = part * power_w_m3[i];
  };
  return facet;
}

RandomFacet random_calm_facet(std::uint32_t seed) {
  Random random{std::mt19937_64(seed + 3000000ULL)};
  RandomFacet facet = random_facet(seed);
  facet.batch.construction.convection = Tarp{};
  facet.batch.construction.emissivity = random.between(0.02, 0.3);
  if (auto* sheet = std::get_if<Sheet>(&facet.batch.construction.inside)) sheet->convection = Tarp{};
  std::vector<double> wind;
  for (int i = 0; i <= 24; ++i) {
    wind.push_back(i % 2 == 0 ? random.log_between(0.3, 10.0) : 0.0);
    facet.timeline.breaks_s.push_back(0.5 * kHour_s * i);
  }
  std::sort(facet.timeline.breaks_s.begin(), facet.timeline.breaks_s.end());
  const double sun_w_m2 = random.between(300.0, 1000.0);
  facet.forcing = [other = facet.forcing, wind, sun_w_m2](Instant at, std::size_t first, ForcingValues& values) {
    other(at, first, values);
    for (double& absorbed : values.front.absorbed_w_m2) absorbed += sun_w_m2;
    const double place = std::min(at.time_s / (0.5 * kHour_s), 23.999999999);
    const auto i = static_cast<std::size_t>(place);
    const double share = std::min(at.time_s / (0.5 * kHour_s) - static_cast<double>(i), 1.0);
    values.front.wind_m_s = values.back.wind_m_s = std::max(0.0, wind[i] + share * (wind[i + 1] - wind[i]));
  };
  return facet;
}

RandomFacet random_wet_facet(std::uint32_t seed) {
  Random random{std::mt19937_64(seed + 1000000ULL)};
  RandomFacet facet = random_facet(seed);
  Construction& construction = facet.batch.construction;
  if (std::holds_alternative<NoConvection>(construction.convection)) construction.convection = McAdams{};
  construction.wet_fraction = random.log_between(0.05, 1.0);
  construction.air_pressure_pa = random.between(6e4, 1.05e5);
  if (auto* sheet = std::get_if<Sheet>(&construction.inside)) {
    if (std::holds_alternative<NoConvection>(sheet->convection)) sheet->convection = McAdams{};
    sheet->wet_fraction = random.between(0.0, 1.0);
  }
  const double vapour_pa = random.log_between(100.0, 2000.0);
  facet.forcing = [dry = facet.forcing, vapour_pa](Instant at, std::size_t first, ForcingValues& values) {
    dry(at, first, values);
    values.front.vapour_pa = values.back.vapour_pa =
        vapour_pa * (1.0 + 0.5 * std::sin(2.0 * std::numbers::pi * at.time_s / (24.0 * kHour_s)));
  };
  return facet;
}

}  // namespace radiometry::heat::test
