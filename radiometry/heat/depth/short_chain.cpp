// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/depth/short_chain.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "radiometry/heat/depth/elimination.h"

namespace radiometry::heat {
namespace {

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
