// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/band_tables.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include "radiometry/light/constants.h"

namespace radiometry::render {
namespace {

using Values = std::vector<double>;

constexpr double kColdest_k = 50.0;
constexpr std::size_t kMostTemperatures = 2048;
/// Relative error of a cubic through equally spaced temperatures that a step is chosen for.
constexpr double kCubicError = 2e-8;

double dot_of(const Values& a, std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

Values product(const Values& a, const Values& b) {
  Values out(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) out[k] = a[k] * b[k];
  return out;
}

/// fold(values) with the transmission of every node of the grid.
Values through(const BandNodes& nodes, const Values& values, const PathGrid& grid) {
  const Values folded = fold(nodes, values);
  Values out;
  for (const AirSamples& air : grid.node) out.push_back(dot_of(air.transmission, folded));
  return out;
}

/// In a middle interval a cubic errs by 9/384 h^4 times the fourth derivative, which is at most (c2 / (lambda T^2))^4
/// of the value.
EmissionFolds::Table place_of(const KelvinRange& range, double shortest_um) {
  EmissionFolds::Table table;
  const double lo = std::max(range.lo_k, kColdest_k), hi = std::max(range.hi_k, lo);
  const double steepness = kSecondRadiation_um_k / (shortest_um * lo * lo);
  table.step_k = std::pow(kCubicError * 384.0 / 9.0, 0.25) / steepness;
  table.step_k = std::max(table.step_k, (hi - lo) / static_cast<double>(kMostTemperatures));
  table.first_k = lo - table.step_k;
  table.temperatures = 4 + static_cast<std::size_t>((hi - lo) / table.step_k);
  return table;
}

}  // namespace

EmissionFolds::EmissionFolds(const BandNodes& nodes, std::span<const std::vector<double>> emissivity,
                             std::span<const KelvinRange> range) {
  for (std::size_t m = 0; m < emissivity.size(); ++m) {
    Table table = place_of(range[m], nodes.range.lo_um);
    for (std::size_t t = 0; t < table.temperatures; ++t) {
      const double kelvin = table.first_k + static_cast<double>(t) * table.step_k;
      const Values folded = fold(nodes, product(emissivity[m], blackbody_at(nodes, kelvin)));
      table.value.insert(table.value.end(), folded.begin(), folded.end());
    }
    table_.push_back(std::move(table));
  }
}

CubicPlace cubic_place(double at, std::size_t of) {
  const double below = std::clamp(std::floor(at), 1.0, static_cast<double>(of - 3)), t = at - below;
  return {static_cast<std::size_t>(below) - 1,
          {-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0, -(t + 1.0) * t * (t - 2.0) / 2.0,
           (t + 1.0) * t * (t - 1.0) / 6.0}};
}

CubicPlace cubic_place(const EmissionFolds::Table& table, double temperature_k) {
  return cubic_place((std::max(temperature_k, kColdest_k) - table.first_k) / table.step_k, table.temperatures);
}

BandTables::BandTables(const BandNodes& nodes, const EmissionFolds& folds,
                       std::span<const std::vector<double>> emissivity, const LightSources& sources,
                       const PathGrid& grid, double reference_k, std::span<const MadeFinish> made)
    : nodes_(grid.node.size()), roots_(grid.roots()) {
  for (std::size_t m = 0; m < folds.size(); ++m) {
    const EmissionFolds::Table& from = folds.of(m);
    Emitted emitted{{from.first_k, from.step_k, from.temperatures, {}}, {}};
    for (std::size_t t = 0; t < from.temperatures; ++t)
      for (const AirSamples& air : grid.node)
        emitted.value.push_back(
            dot_of(air.transmission, std::span(from.value).subspan(t * nodes.samples(), nodes.samples())));
    emitted_.push_back(std::move(emitted));

    const bool is_made = m >= emissivity.size();
    Values missing = is_made ? made[m - emissivity.size()].reflects : Values(nodes.size());
    for (std::size_t k = 0; !is_made && k < missing.size(); ++k) missing[k] = 1.0 - emissivity[m][k];
    reflected_.emplace_back();
    if ((!is_made || made[m - emissivity.size()].light) &&
        std::any_of(missing.begin(), missing.end(), [](double part) { return part > 0.0; }))
      for (const Values& light : sources.radiance) {
        const Values seen = through(nodes, product(missing, light), grid);
        reflected_.back().insert(reflected_.back().end(), seen.begin(), seen.end());
      }
    if (sources.sun_irradiance.empty()) continue;
    for (double& part : missing) part /= std::numbers::pi;
    sun_.push_back(through(nodes, product(missing, sources.sun_irradiance), grid));
  }
  const Values air = fold(nodes, blackbody_at(nodes, reference_k));
  for (const AirSamples& node : grid.node) path_.push_back(dot_of(node.source, air));
}

BandTables BandTables::between(const BandTables& low, const BandTables& high, double share) {
  BandTables out = low;
  const auto mix = [&](Values& to, const Values& other) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = std::lerp(to[i], other[i], share);
  };
  for (std::size_t m = 0; m < out.emitted_.size(); ++m) {
    mix(out.emitted_[m].value, high.emitted_[m].value);
    mix(out.reflected_[m], high.reflected_[m]);
  }
  for (std::size_t m = 0; m < out.sun_.size(); ++m) mix(out.sun_[m], high.sun_[m]);
  mix(out.path_, high.path_);
  return out;
}

SixValues BandTables::emitted(std::size_t finish, double temperature_k, std::size_t node) const {
  const Emitted& table = emitted_[finish];
  const auto [first, weight] = cubic_place(table.place, temperature_k);
  SixValues sum{};
  for (std::size_t i = 0; i < 4; ++i) {
    const SixValues at = six(std::span(table.value).subspan((first + i) * nodes_), node);
    for (std::size_t k = 0; k < 6; ++k) sum[k] += weight[i] * at[k];
  }
  return sum;
}

void BandTables::add_reflected(std::size_t finish, std::size_t source, double share, std::size_t node,
                               SixValues& sum) const {
  const SixValues at = six(std::span(reflected_[finish]).subspan(source * nodes_), node);
  for (std::size_t k = 0; k < 6; ++k) sum[k] += share * at[k];
}

SixValues BandTables::sunlit(std::size_t finish, std::size_t node) const {
  return sun_.empty() ? SixValues{} : six(sun_[finish], node);
}

double promised_error(const SpectralCamera& camera, std::span<const Spectrum> emissivity, const EmissionFolds& folds,
                      const BandTables& tables, const PathGrid& grid, const AirView* view) {
  constexpr std::size_t kTemperatures = 12;
  constexpr double kBetween = 0.21132486540518713, kRounding = 1e-7;  // rounding: of pixels, which are floats
  const BandNodes fine = band_nodes(camera, emissivity, 6);
  struct Place {
    PathGrid::Cell cell;
    double root, height;
    AirSamples air;
  };
  std::vector<Place> places;
  for (std::uint16_t layer = 0; layer < grid.layers(); ++layer)
    for (std::uint16_t cell = 0; cell < grid.cells(); ++cell)
      for (const double t : {kBetween, 1.0 - kBetween}) {
        const double root = std::lerp(grid.root[2 * cell], grid.root[2 * cell + 2], t);
        const double height = std::midpoint(grid.height_m[layer], grid.height_m[layer + 1U]);
        if (view != nullptr && !view->reaches(root * root, height)) continue;
        places.push_back({{cell, layer}, root, height, view != nullptr ? view->to(root * root, height) : grid.node[0]});
      }
  const double reference_k = view != nullptr ? view->reference_k() : 0.0;
  const Values air_light = blackbody_at(fine, reference_k), air = fold(fine, air_light);
  const double air_black = integral(fine, air_light);
  double worst = 0.0;
  for (std::size_t m = 0; m < emissivity.size(); ++m) {
    const EmissionFolds::Table& table = folds.of(m);
    const Values eps = at_nodes(fine, emissivity[m]);
    const std::size_t intervals = table.temperatures - 3, step = std::max<std::size_t>(1, intervals / kTemperatures);
    for (std::size_t t = 0; t < intervals; t += step) {
      const double kelvin = table.first_k + (static_cast<double>(t) + 1.5) * table.step_k;
      const Values folded = fold(fine, product(eps, blackbody_at(fine, kelvin)));
      for (const Place& place : places) {
        const double direct = dot_of(place.air.transmission, folded) + dot_of(place.air.source, air);
        const std::size_t node = grid.index(place.cell);
        const double seen = grid.between(place.cell, place.root, place.height,
                                         sum_of(tables.emitted(m, kelvin, node), tables.path(node)));
        worst = std::max(worst, std::abs(seen - direct) / std::max(direct, air_black));
      }
    }
  }
  return kPromise * worst + kRounding;
}

}  // namespace radiometry::render
