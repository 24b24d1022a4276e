// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/depth/depth_grid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

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

using Complex = std::complex<double>;
using Vector = std::vector<double>;

/// Frequencies at which both are compared, with the admittances of the grid.
struct Band {
  Vector omega;
  std::vector<Complex> admittance;
  double step = 0.0;  ///< of log(omega)
};

Complex admittance(const Grid& grid, double omega) {
  const Elimination<Complex> e = eliminate(grid, false, 1.0 / Complex(0.0, omega));
  return e.own / e.a;
}

Band band_of(const Grid& grid, double duration_s) {
  constexpr double kDay_s = 86400.0, kBeyond = 40.0, kPerDecade = 24.0;
  const double lowest = std::numbers::pi / std::max(duration_s, kDay_s);
  const double highest = std::max(kBeyond * grid.conductance[0] / grid.capacity[1], 10.0 * lowest);
  const auto count = static_cast<std::size_t>(kPerDecade * std::log10(highest / lowest)) + 2;
  Band band;
  band.step = std::log(highest / lowest) / static_cast<double>(count - 1);
  for (std::size_t i = 0; i < count; ++i) {
    band.omega.push_back(lowest * std::exp(band.step * static_cast<double>(i)));
    band.admittance.push_back(admittance(grid, band.omega.back()));
  }
  return band;
}

/// Projections of the nodes below the surface; the basis is orthonormal in their heat capacities.
class Projection {
 public:
  explicit Projection(const Grid& grid) : grid_(grid) { add(Vector(grid.nodes() - 1, 1.0)); }

  /// Adds the temperatures below a surface that is at 1 and grows as exp(s t).
  void add(double s) {
    const Elimination<double> e = eliminate(grid_, false, 1.0 / s);
    Vector v;
    for (std::size_t i = 1; i < grid_.nodes(); ++i) v.push_back(e.forward[i] * (i == 1 ? 1.0 : v.back()));
    add(std::move(v));
  }

  /// The chain; none where rounding has spoiled it.
  std::optional<Grid> chain() const {
    const std::size_t n = basis_.size();
    Vector q(n), before(n, 0.0), w(n);  // of Lanczos' method for K in this basis, from what the surface is joined to
    for (std::size_t j = 0; j < n; ++j) q[j] = basis_[j].front();
    double size = normalise(q), capacity = 1.0 / (size * size), total = grid_.capacity[0] + capacity;
    Grid chain{.capacity = {grid_.capacity[0], capacity}, .conductance = {grid_.conductance[0]}};
    std::vector<Vector> earlier{q};
    while (earlier.size() < n) {
      for (std::size_t i = 0; i < n; ++i) {
        w[i] = 0.0;
        for (std::size_t j = 0; j < n; ++j) w[i] += stiffness_[std::max(i, j)][std::min(i, j)] * q[j];
      }
      const double own = product(q, w);
      for (int twice = 0; twice < 2; ++twice)
        for (const Vector& one : earlier) subtract(one, product(one, w), w);
      size = normalise(w);
      const double conductance = own * capacity - chain.conductance.back();
      capacity = conductance * conductance / (size * size * capacity);
      if (!(conductance > 0.0) || !(capacity > 0.0) || !std::isfinite(capacity)) return std::nullopt;
      chain.conductance.push_back(conductance);
      chain.capacity.push_back(capacity);
      total += capacity;
      earlier.push_back(q = w);
    }
    double of_grid = 0.0;
    for (const double one : grid_.capacity) of_grid += one;
    if (!(std::abs(total / of_grid - 1.0) < 1e-10)) return std::nullopt;
    return chain;
  }

 private:
  static double product(const Vector& a, const Vector& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }
  static void subtract(const Vector& from, double factor, Vector& v) {
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= factor * from[i];
  }
  static double normalise(Vector& v) {
    const double size = std::sqrt(product(v, v));
    for (double& one : v) one /= size;
    return size;
  }

  void add(Vector v) {
    const std::size_t n = v.size();
    const auto heat = [&](const Vector& a, const Vector& b) {
      double sum = 0.0;
      for (std::size_t i = 0; i < n; ++i) sum += grid_.capacity[i + 1] * a[i] * b[i];
      return sum;
    };
    for (int thrice = 0; thrice < 3; ++thrice)
      for (const Vector& one : basis_) subtract(one, heat(one, v), v);
    const double size = std::sqrt(heat(v, v));
    for (double& one : v) one /= size;
    basis_.push_back(std::move(v));
    Vector row;
    for (const Vector& one : basis_) {
      double sum = grid_.conductance[0] * one[0] * basis_.back()[0];
      for (std::size_t i = 1; i < n; ++i)
        sum += grid_.conductance[i] * (one[i] - one[i - 1]) * (basis_.back()[i] - basis_.back()[i - 1]);
      row.push_back(sum);
    }
    stiffness_.push_back(std::move(row));
  }

  const Grid& grid_;
  std::vector<Vector> basis_, stiffness_;  ///< the lower triangle of K
};

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

ShortChain shortened(const Grid& grid, double flux_w_m2, double duration_s, double error_k) {
  constexpr double kNear = 0.2;  // in log(s): such vectors are nearly the same
  ShortChain best{grid, 0.0};
  const std::size_t most = grid.nodes() * 3 / 4;
  if (most < 4) return best;
  const Band band = band_of(grid, duration_s);
  Projection projection(grid);
  Vector used;
  double next = band.omega.front();
  for (std::size_t nodes = 3; nodes <= most; ++nodes) {
    projection.add(next);
    used.push_back(next);
    const std::optional<Grid> chain = projection.chain();
    if (!chain) return best;
    double sum = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < band.omega.size(); ++i) {
      const double off =
          std::abs(admittance(*chain, band.omega[i]) - band.admittance[i]) / std::norm(band.admittance[i]);
      sum += off;
      const bool fresh =
          std::ranges::none_of(used, [&](double s) { return std::abs(std::log(s / band.omega[i])) < kNear; });
      if (!fresh || off <= worst) continue;
      worst = off;
      next = band.omega[i];
    }
    const double error = 2.0 / std::numbers::pi * flux_w_m2 * sum * band.step;
    if (error <= error_k) return {*chain, error};
    if (worst == 0.0) return best;
  }
  return best;
}

}  // namespace radiometry::heat
