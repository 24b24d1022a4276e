// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/depth/depth_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "radiometry/heat/depth/elimination.h"

namespace radiometry::heat {
namespace {

double root_time(const Layer& layer) { return layer.thickness_m / std::sqrt(layer.diffusivity()); }

/// Places in s at which to put nodes: u counts coarse cells from the outer surface, smoothly. du/ds is the reciprocal
/// of the size of a coarse cell, which grows with the distance from the next surface where heat comes and goes.
class Spacing {
 public:
  Spacing(double total, bool both_sides, const GridRequest& request)
      : total_(total),
        half_(both_sides ? 0.5 * total : total),
        first_(2.0 * std::sqrt(request.short_time_s) / 3.0 / request.density),
        growth_(0.7 / request.density) {}

  double cells(double s) const {
    return s <= half_ ? cells_from_surface(s) : 2.0 * cells_from_surface(half_) - cells_from_surface(total_ - s);
  }
  double place(double u) const {
    const double middle = cells_from_surface(half_);
    return u <= middle ? place_from_surface(u) : total_ - place_from_surface(2.0 * middle - u);
  }

 private:
  double cells_from_surface(double s) const { return std::log1p(growth_ * s / first_) / growth_; }
  double place_from_surface(double u) const { return first_ / growth_ * std::expm1(growth_ * u); }

  double total_, half_, first_, growth_;
};

void append_cell(Grid& grid, const Construction& construction, std::size_t of_layer, double width_m) {
  const Layer& layer = construction.layers[of_layer];
  const std::size_t layers = construction.layers.size();
  grid.layer_m.resize(grid.layer_m.size() + layers, 0.0);
  for (const std::size_t node : {grid.nodes() - 1, grid.nodes()})
    grid.layer_m[node * layers + of_layer] += 0.5 * width_m;
  const double half = 0.5 * layer.density_kg_m3 * layer.heat_capacity_j_kg_k * width_m;
  grid.capacity.back() += half;
  grid.capacity.push_back(half);
  grid.conductance.push_back(layer.conductivity_w_m_k / width_m);
  grid.depth_m.push_back(grid.depth_m.back() + width_m);
}

void close_inside(Grid& grid, const Construction& construction) {
  const Inside& inside = construction.inside;
  if (const auto* film = std::get_if<InnerFilm>(&inside)) grid.inner_w_m2_k = film->h_w_m2_k;
  if (std::holds_alternative<FixedTemperature>(inside)) {  // the last node is the boundary itself
    grid.inner_w_m2_k = grid.conductance.back();
    grid.capacity.pop_back();
    grid.conductance.pop_back();
    grid.depth_m.pop_back();
    grid.layer_m.resize(grid.layer_m.size() - construction.layers.size());
  }
}

Grid start_of_grid(std::size_t layers) {
  return {.capacity = {0.0}, .depth_m = {0.0}, .layer_m = std::vector<double>(layers, 0.0)};
}

}  // namespace

Grids make_grids(const Construction& construction, const GridRequest& request) {
  double total = 0.0;
  for (const Layer& layer : construction.layers) total += root_time(layer);
  const Spacing spacing(total, !std::holds_alternative<Adiabatic>(construction.inside), request);

  const Grid start = start_of_grid(construction.layers.size());
  Grids grids{start, start};
  double begin = 0.0;
  for (std::size_t l = 0; l < construction.layers.size(); ++l) {
    const Layer& layer = construction.layers[l];
    const double length = root_time(layer), root = std::sqrt(layer.diffusivity());
    const double first = spacing.cells(begin), last = spacing.cells(begin + length);
    const int cells = std::max(1, static_cast<int>(std::ceil(last - first - 1e-9)));
    const auto depth = [&](double u) {  // u in [0, cells]
      if (u == 0.0 || u == cells) return u == 0.0 ? 0.0 : layer.thickness_m;
      return std::clamp(spacing.place(first + (last - first) * u / cells) - begin, 0.0, length) * root;
    };
    for (int i = 0; i < cells; ++i) {
      append_cell(grids.coarse, construction, l, depth(i + 1) - depth(i));
      append_cell(grids.fine, construction, l, depth(i + 0.5) - depth(i));
      append_cell(grids.fine, construction, l, depth(i + 1) - depth(i + 0.5));
    }
    begin += length;
  }
  close_inside(grids.fine, construction);
  close_inside(grids.coarse, construction);
  return grids;
}

Grids make_one_node(const Construction& construction) {
  Grid grid{.capacity = {capacity(construction)}, .depth_m = {0.0}};
  for (const Layer& layer : construction.layers) grid.layer_m.push_back(layer.thickness_m);
  const double through = resistance(construction);
  if (std::holds_alternative<FixedTemperature>(construction.inside)) grid.inner_w_m2_k = 1.0 / through;
  if (const auto* film = std::get_if<InnerFilm>(&construction.inside))
    grid.inner_w_m2_k = film->h_w_m2_k / (1.0 + film->h_w_m2_k * through);
  return {grid, grid};
}

double one_node_error(const Construction& construction, double flux_w_m2) {
  if (!std::holds_alternative<Adiabatic>(construction.inside) || construction.generates)
    return flux_w_m2 * resistance(construction);
  const double total = capacity(construction);
  double below = total, sum = 0.0;
  for (const Layer& layer : construction.layers) {
    const double deeper = below - layer.capacity();
    sum += layer.resistance() * (below * below + below * deeper + deeper * deeper) / 3.0;
    below = deeper;
  }
  return flux_w_m2 * sum / (total * total);
}

Cut cut_depth(const Construction& construction, double range_k, double duration_s, double error_k) {
  if (!std::holds_alternative<Adiabatic>(construction.inside) || construction.generates) return {construction, 0.0};
  constexpr double kDay_s = 86400.0;
  Cut cut;
  cut.construction = construction;
  cut.construction.layers.clear();
  double at = 0.0, doubling = 1.0;
  for (const Layer& layer : construction.layers) {
    const auto bound = [&](double s) {
      const double step = std::erfc(s / (2.0 * std::sqrt(duration_s)));
      const double wave = std::exp(-s * std::sqrt(std::numbers::pi / std::max(kDay_s, duration_s)));
      return 2.0 * doubling * range_k * std::max(step, wave);
    };
    const double length = root_time(layer);
    cut.construction.layers.push_back(layer);
    if (bound(at + length) < error_k) {
      double lo = at, hi = at + length;  // bound(lo) > error_k, or lo is the interface
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (lo + hi);
        (bound(middle) < error_k ? hi : lo) = middle;
      }
      cut.construction.layers.back().thickness_m *= std::max(hi - at, 1e-3 * length) / length;
      cut.error_k = bound(hi);
      return cut;
    }
    at += length;
    doubling *= 2.0;
  }
  return {construction, 0.0};
}

}  // namespace radiometry::heat
