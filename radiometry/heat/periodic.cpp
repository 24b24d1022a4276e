// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/periodic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/heat/depth/elimination.h"
#include "radiometry/heat/surface_loss.h"

namespace radiometry::heat {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t kSamples = 64;    ///< of the forcing in a period
constexpr std::size_t kHarmonics = 12;  ///< what is left is corrected by the days that are run
constexpr std::size_t kFacetsAtOnce = 64;
constexpr int kMostIterations = 100;
constexpr double kUnknown_k = std::numeric_limits<double>::infinity();

/// One exposed side of one facet over the period.
struct SideSamples {
  double emission = 0.0;
  NaturalConvection natural;
  std::array<double, kSamples> absorbed{}, film{}, air_k{}, latent{}, vapour_pa{};

  LossAndSlope at(std::size_t j, double t) const {
    return SurfaceLoss{emission, film[j], air_k[j], natural, latent[j], vapour_pa[j]}.at(t);
  }
  /// Means over the period at a temperature: net flow inwards, and the slope of the loss.
  LossAndSlope mean(double t) const {
    double net = 0.0, slope = 0.0;
    for (std::size_t j = 0; j < kSamples; ++j) {
      const LossAndSlope now = at(j, t);
      net += absorbed[j] - now.loss;
      slope += now.slope;
    }
    return {net / kSamples, slope / kSamples};
  }
};

struct FacetSamples {
  SideSamples front, back;
  std::array<double, kSamples> inside{};
  std::vector<std::array<double, kSamples>> source_w_m3{};  ///< of each layer that generates heat
};

double sample_time(const Timeline& period, std::size_t j) {
  return period.start_s + (period.end_s - period.start_s) * static_cast<double>(j) / kSamples;
}

/// The forcing of some facets at all sample times.
std::vector<FacetSamples> sample(const Plan& plan, const GroupForcing& of_group, const Timeline& period,
                                 std::size_t first, std::size_t count) {
  const Construction& construction = plan.batch.construction;
  const bool sheet = construction.is_sheet();
  const Forcing forcing = of_group(first, count);
  std::vector<FacetSamples> samples(count);
  std::vector<double> front(count), back(sheet ? count : 0);
  std::vector<double> source(construction.generates ? construction.layers.size() : 0);
  for (std::size_t j = 0; j < kSamples; ++j) {
    ForcingValues values{.front = {.absorbed_w_m2 = front}, .back = {.absorbed_w_m2 = back}};
    values.source_w_m3 = source;
    forcing({sample_time(period, j), Instant::Limit::after}, first, values);
    for (std::size_t i = 0; i < count; ++i) {
      const double up = plan.batch.up.empty() ? 0.0 : plan.batch.up[first + i];
      const auto take = [&](const SideForcing& from, bool of_back, SideSamples& to) {
        const SurfaceLoss loss = surface_loss(construction, of_back, from, of_back ? -up : up);
        to.emission = loss.emission;
        to.natural = loss.natural;
        to.absorbed[j] = from.absorbed_w_m2[i];
        to.film[j] = loss.film;
        to.air_k[j] = loss.air_k;
        to.latent[j] = loss.latent;
        to.vapour_pa[j] = loss.vapour_pa;
      };
      take(values.front, false, samples[i].front);
      if (sheet) take(values.back, true, samples[i].back);
      samples[i].inside[j] = values.inside;
      samples[i].source_w_m3.resize(source.size());
      for (std::size_t k = 0; k < source.size(); ++k) samples[i].source_w_m3[k][j] = source[k];
    }
  }
  return samples;
}

/// A facet linearised about the mean of the period.
struct Linearised {
  std::vector<double> mean_k;  ///< of each node
  double front_slope = 0.0, back_slope = 0.0;
};

double mean_of(const std::array<double, kSamples>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / kSamples;
}

/// Heat from the inside boundary for an inside value and the temperature of the last node.
double inside_flow(const Plan& plan, const Grid& grid, double inside, double t) {
  return std::holds_alternative<InnerFlux>(plan.batch.construction.inside) ? inside : grid.inner_w_m2_k * (inside - t);
}

Linearised mean_state(const Plan& plan, const Grid& grid, const FacetSamples& facet) {
  const bool sheet = plan.batch.construction.is_sheet();
  const Elimination<double> steady = eliminate(grid, sheet, 1.0, 0.0);
  const double inside = mean_of(facet.inside);
  const std::size_t n = grid.nodes();
  constexpr double kStart_k = 300.0;
  Linearised state{.mean_k = std::vector<double>(n, kStart_k)};
  std::vector<double> b(n);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const LossAndSlope front = facet.front.mean(state.mean_k.front()), back = facet.back.mean(state.mean_k.back());
    state.front_slope = front.slope;
    state.back_slope = sheet ? back.slope : 0.0;
    if (!(front.slope + state.back_slope + grid.inner_w_m2_k > 0.0))
      throw mtf::UsageError(
          "heat: no mean temperature: the construction has neither emission, convection nor an inside temperature; "
          "start at a uniform temperature");
    double flow = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double inwards = i + 1 < n ? grid.conductance[i] * (state.mean_k[i] - state.mean_k[i + 1]) : 0.0;
      b[i] = flow - inwards;
      flow = inwards;
    }
    for (std::size_t k = 0; k < facet.source_w_m3.size(); ++k)
      for (std::size_t i = 0; i < n; ++i)
        b[i] += grid.layer_m[i * facet.source_w_m3.size() + k] * mean_of(facet.source_w_m3[k]);
    b.front() += front.loss;
    b.back() += sheet ? back.loss : inside_flow(plan, grid, inside, state.mean_k.back());
    solve_linear(steady, state.front_slope, state.back_slope, b);
    double move = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      state.mean_k[i] += b[i];
      move = std::max(move, std::abs(b[i]));
    }
    if (move < 1e-9) break;
  }
  return state;
}

/// Fourier coefficient k of samples, as an amplitude: the mean of x exp(-2 pi i j k / N), doubled.
template <class Value>
Complex harmonic(std::size_t k, const std::vector<Complex>& turns, Value value) {
  Complex sum{};
  for (std::size_t j = 0; j < kSamples; ++j) sum += value(j) * turns[(j * k) % kSamples];
  return sum * (2.0 / kSamples);
}

/// What all facets share: exp(-2 pi i j / N), and the eliminations of every harmonic.
struct Harmonics {
  std::vector<Complex> turns;
  std::vector<Elimination<Complex>> eliminations;
};

Harmonics harmonics_of(const Grid& grid, bool sheet, double period_s) {
  Harmonics all;
  for (std::size_t j = 0; j < kSamples; ++j)
    all.turns.push_back(std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(j) / kSamples));
  for (std::size_t k = 1; k <= kHarmonics; ++k) {
    const Complex i_omega(0.0, 2.0 * std::numbers::pi * static_cast<double>(k) / period_s);
    all.eliminations.push_back(eliminate(grid, sheet, 1.0 / i_omega));
  }
  return all;
}

/// Temperatures of all nodes at the start of the period, of the linearised balance.
std::vector<double> linear_state(const Plan& plan, const Grid& grid, const Harmonics& harmonics,
                                 const FacetSamples& facet, const Linearised& linear) {
  const bool sheet = plan.batch.construction.is_sheet();
  std::vector<double> t = linear.mean_k;
  const auto net = [](const SideSamples& side, double mean_k) {
    std::array<double, kSamples> flow{};
    for (std::size_t j = 0; j < kSamples; ++j) flow[j] = side.absorbed[j] - side.at(j, mean_k).loss;
    return flow;
  };
  const auto front = net(facet.front, t.front());
  std::array<double, kSamples> back{};
  if (sheet)
    back = net(facet.back, t.back());
  else
    for (std::size_t j = 0; j < kSamples; ++j) back[j] = inside_flow(plan, grid, facet.inside[j], linear.mean_k.back());
  std::vector<Complex> b(grid.nodes());
  for (std::size_t k = 1; k <= kHarmonics; ++k) {
    const Elimination<Complex>& e = harmonics.eliminations[k - 1];
    std::fill(b.begin(), b.end(), Complex{});
    for (std::size_t layer = 0; layer < facet.source_w_m3.size(); ++layer) {
      const std::size_t layers = facet.source_w_m3.size();
      const Complex source =
          e.a * harmonic(k, harmonics.turns, [&](std::size_t j) { return facet.source_w_m3[layer][j]; });
      for (std::size_t i = 0; i < b.size(); ++i) b[i] += grid.layer_m[i * layers + layer] * source;
    }
    b.front() += e.a * harmonic(k, harmonics.turns, [&](std::size_t j) { return front[j]; });
    b.back() += e.a * harmonic(k, harmonics.turns, [&](std::size_t j) { return back[j]; });
    solve_linear(e, linear.front_slope, linear.back_slope, b);
    for (std::size_t i = 0; i < t.size(); ++i) t[i] += b[i].real();
  }
  return t;
}

/// The runs of a state, on their grids.
struct GridOfRun {
  const Grid* grid;
  std::vector<double> State::*t;
};

std::vector<GridOfRun> runs_of(const Plan& plan, Runs carried) {
  std::vector<GridOfRun> runs{{&plan.fine, &State::fine}};
  if (carried == Runs::three) runs.insert(runs.end(), {{&plan.fine, &State::doubled}, {&plan.coarse, &State::coarse}});
  return runs;
}

double largest(const State& step) {
  double most = 0.0;
  for (const auto* values : {&step.fine, &step.doubled, &step.coarse})
    for (const double value : *values) most = std::max(most, std::abs(value));
  return most;
}

}  // namespace

State newton_step(const Plan& plan, const LossSlopes& slopes, const State& begin, const State& end, int threads) {
  // r + 2 (AP)^-1 (AP + 2)^-1 r with A = M^-1 (K + slopes)
  const bool sheet = plan.batch.construction.is_sheet();
  const double period_s = end.time_s - begin.time_s;
  const std::size_t facets = plan.batch.facets;
  State step = end;
  step.time_s = begin.time_s;
  for (const GridOfRun& run : runs_of(plan, begin.runs())) {
    const Grid& grid = *run.grid;
    const Elimination<double> half = eliminate(grid, sheet, 0.5 * period_s), steady = eliminate(grid, sheet, 1.0, 0.0);
    std::vector<double>& changed = step.*run.t;
    const std::vector<double>& before = begin.*run.t;
    mtf::parallel_for(static_cast<std::int64_t>(facets), kFacetsAtOnce, threads,
                      [&](std::int64_t first, std::int64_t last) {
                        std::vector<double> z(grid.nodes());
                        for (auto f = static_cast<std::size_t>(first); f < static_cast<std::size_t>(last); ++f) {
                          for (std::size_t i = 0; i < z.size(); ++i) {
                            changed[i * facets + f] -= before[i * facets + f];
                            z[i] = 0.5 * grid.capacity[i] * changed[i * facets + f];
                          }
                          solve_linear(half, slopes.front[f], slopes.back[f], z);
                          for (std::size_t i = 0; i < z.size(); ++i) z[i] *= grid.capacity[i] / period_s;
                          solve_linear(steady, slopes.front[f], slopes.back[f], z);
                          for (std::size_t i = 0; i < z.size(); ++i) changed[i * facets + f] += 2.0 * z[i];
                        }
                      });
  }
  return step;
}

PeriodicStart periodic_start(const Plan& plan, const Forcing& forcing, const Timeline& period, double error_k,
                             int most_periods, int threads) {
  return periodic_start(plan, for_all_groups(forcing), period, error_k, most_periods, threads);
}

PeriodicStart periodic_start(const Plan& plan, const GroupForcing& forcing, const Timeline& period, double error_k,
                             int most_periods, int threads, Runs runs_carried, const OutputSink& sink) {
  const double period_s = period.end_s - period.start_s;
  if (!(period_s > 0.0)) throw mtf::UsageError("heat: the period of a repeating start has to be above 0");
  const std::size_t facets = plan.batch.facets;
  const bool sheet = plan.batch.construction.is_sheet();
  const bool three = runs_carried == Runs::three;
  const std::vector<GridOfRun> runs = runs_of(plan, runs_carried);

  PeriodicStart result;
  result.state = uniform_state(plan, period.start_s, 0.0, runs_carried);
  result.slopes = {std::vector<double>(facets), std::vector<double>(facets)};
  // The second run starts as the first one does, on the same grid.
  std::vector<GridOfRun> starts{runs.front()};
  if (three) starts.push_back(runs.back());
  std::vector<Harmonics> harmonics;
  for (const GridOfRun& start : starts) harmonics.push_back(harmonics_of(*start.grid, sheet, period_s));
  const auto linear_states = [&](std::int64_t begin, std::int64_t end) {
    const auto first = static_cast<std::size_t>(begin), count = static_cast<std::size_t>(end - begin);
    const std::vector<FacetSamples> samples = sample(plan, forcing, period, first, count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t g = 0; g < starts.size(); ++g) {
        const std::size_t facet = first + i;
        const Linearised mean = mean_state(plan, *starts[g].grid, samples[i]);
        const std::vector<double> t = linear_state(plan, *starts[g].grid, harmonics[g], samples[i], mean);
        for (std::size_t node = 0; node < t.size(); ++node)
          (result.state.*starts[g].t)[node * facets + facet] = t[node];
        if (g > 0) continue;
        result.slopes.front[facet] = mean.front_slope;
        result.slopes.back[facet] = mean.back_slope;
      }
  };
  mtf::parallel_for(static_cast<std::int64_t>(facets), kFacetsAtOnce, threads, linear_states);
  if (three) result.state.doubled = result.state.fine;

  double last_k = 0.0;
  while (result.periods < most_periods) {
    result.last = advance(plan, result.state, forcing, period, threads, sink);
    const State step = newton_step(plan, result.slopes, result.state, result.last.end, threads);
    result.state.step_s = step.step_s;
    for (const GridOfRun& run : runs)
      for (std::size_t i = 0; i < (step.*run.t).size(); ++i) (result.state.*run.t)[i] += (step.*run.t)[i];
    // One step says nothing of how fast they become smaller: by half is taken for granted.
    const double step_k = largest(step), ratio = result.periods > 0 && last_k > 0.0 ? step_k / last_k : 0.5;
    last_k = step_k;
    ++result.periods;
    result.error_k = ratio < 1.0 ? step_k * std::max(1.0, ratio / (1.0 - ratio)) : kUnknown_k;
    if (result.error_k <= error_k) break;
  }
  return result;
}

}  // namespace radiometry::heat
