// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/adequacy.h"

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <complex>
#include <numbers>

namespace calib {
namespace {

constexpr double kFineBin_px = 0.125;
constexpr std::size_t kFewestInBin = 24;
constexpr double kModelError = 1e-6;  // of the contrast
constexpr double kOutlierSd = 4.0;

/// Probability that a normal variable is at least z.
double normal_tail(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

struct Cell {
  double n = 0.0, distance = 0.0, sum = 0.0, squares = 0.0, bias2 = 0.0;
  void add(const Cell& c) { n += c.n, distance += c.distance, sum += c.sum, squares += c.squares, bias2 += c.bias2; }
};

/// Cells of equal width, joined where they hold too few pixels.
std::vector<Cell> cells_of(std::span<const Residual> residuals, double contrast, double quantum) {
  double lo = 0.0, hi = 0.0;
  for (const Residual& r : residuals) lo = std::min(lo, r.distance_px), hi = std::max(hi, r.distance_px);
  const auto count = static_cast<std::size_t>(std::min(1e6, (hi - lo) / kFineBin_px)) + 1;
  std::vector<Cell> fine(count);
  for (const Residual& r : residuals) {
    const auto i = std::min(count - 1, static_cast<std::size_t>((r.distance_px - lo) / kFineBin_px));
    const double value = bent(r.value, true).value;
    // Rounding of values whose noise is small against the step is no noise: what is left of its mean.
    const double step = quantum / r.sd, before = std::max(0.0, 1.0 - step * step / 12.0);
    const double rounding =
        step > 0.0 ? step * step / 12.0 * std::exp(-4.0 * std::numbers::pi * std::numbers::pi * before / (step * step))
                   : 0.0;
    const double shared = std::max(rounding, r.shared);
    const double model = kModelError * contrast / r.sd;
    fine[i].add({1.0, r.distance_px, value, value * value, shared + model * model});
  }
  std::vector<Cell> cells;
  for (const Cell& cell : fine) {
    if (cells.empty() || cells.back().n >= static_cast<double>(kFewestInBin)) cells.emplace_back();
    cells.back().add(cell);
  }
  if (cells.size() > 1 && cells.back().n < static_cast<double>(kFewestInBin)) {
    const Cell rest = cells.back();
    cells.pop_back();
    cells.back().add(rest);
  }
  return cells;
}

Adequacy sums(std::span<const Residual> residuals) {
  Adequacy a;
  double beyond = 0.0;
  for (const Residual& r : residuals) {
    const double size = bent(r.value, true).value;
    a.chi2 += size * size;
    beyond += std::abs(r.value) > kOutlierSd;
  }
  if (!residuals.empty()) a.outlier_share = beyond / static_cast<double>(residuals.size());
  return a;
}

/// The distance from which the noise that pixels share is too little to show in a test.
int spacing_of(const PixelCorrelation& correlation) {
  constexpr double kLittle = 0.05;
  for (int ring = 1; ring <= correlation.rings; ++ring) {
    double squares = 0.0, count = 0.0;
    for (const PixelLag& lag : correlation.lags)
      if (std::max(std::abs(lag.x), std::abs(lag.y)) == ring) {
        squares += lag.correlation * lag.correlation;
        count += 1.0;
      }
    if (squares < kLittle * kLittle * count) return std::max(2, ring);
  }
  return correlation.rings + 1;
}

}  // namespace

double f_tail(double ratio, double dof1, double dof2) {
  if (!(dof1 > 0.0 && dof2 > 0.0 && ratio > 0.0)) return 1.0;
  return boost::math::ibeta(0.5 * dof2, 0.5 * dof1, dof2 / (dof2 + dof1 * ratio));
}

Adequacy judge_edge(std::span<const Residual> residuals, std::size_t fitted, double contrast, double quantum) {
  Adequacy a = sums(residuals);
  const std::vector<Cell> cells = cells_of(residuals, contrast, quantum);
  double within = 0.0;
  for (const Cell& c : cells) within += c.squares - c.sum * c.sum / c.n;
  const double all = static_cast<double>(residuals.size()), groups = static_cast<double>(cells.size());
  const double dof = groups - static_cast<double>(fitted), dof_within = all - groups;
  if (dof < 4.0 || dof_within < 4.0) return a;
  const double scatter = within / dof_within;

  double between = 0.0, excess = 0.0, neighbours = 0.0, previous = 0.0;
  for (const Cell& c : cells) {
    const double mean = c.sum / c.n, variance = scatter / c.n + c.bias2 / c.n;
    const double z = variance > 0.0 ? mean / std::sqrt(variance) : 0.0;
    between += z * z;
    excess += c.n * (mean * mean - variance);
    // What rounding leaves in one mean it leaves in the next.
    neighbours += z * previous - (variance > 0.0 ? c.bias2 / c.n / variance : 0.0);
    previous = z;
    a.bins.push_back({c.distance / c.n, 0.0, mean, variance});
  }
  for (std::size_t i = 0; i < a.bins.size(); ++i) {
    const double left = i == 0 ? a.bins[i].distance_px : a.bins[i - 1].distance_px;
    const double right = i + 1 == a.bins.size() ? a.bins[i].distance_px : a.bins[i + 1].distance_px;
    a.bins[i].width_px = 0.5 * (right - left);
  }
  a.structure = std::sqrt(std::max(0.0, excess / all));
  const double by_means = f_tail(between / dof, dof, dof_within);
  const double by_neighbours = normal_tail(neighbours / std::sqrt(groups));
  a.whiteness_p = std::min(1.0, 2.0 * std::min(by_means, by_neighbours));
  return a;
}

IndependentResiduals independent(std::vector<Residual> residuals, Point normal, double flat_px) {
  IndependentResiduals found{.residuals = std::move(residuals)};
  if (found.residuals.empty()) return found;
  constexpr std::int64_t kMostRows = 1024;  // bounds the memory of the grid
  std::int64_t x0 = found.residuals.front().x, y0 = found.residuals.front().y, x1 = x0, y1 = y0;
  for (const Residual& r : found.residuals) y0 = std::min(y0, r.y);
  const auto taken = [&](const Residual& r) { return r.y - y0 < kMostRows; };
  for (const Residual& r : found.residuals)
    if (taken(r)) x0 = std::min(x0, r.x), x1 = std::max(x1, r.x), y1 = std::max(y1, r.y);
  PixelGrid grid(static_cast<std::size_t>(x1 - x0) + 1, static_cast<std::size_t>(y1 - y0) + 1);
  for (const Residual& r : found.residuals)
    if (taken(r) && std::abs(r.distance_px) >= flat_px)
      grid.set(static_cast<std::size_t>(r.x - x0), static_cast<std::size_t>(r.y - y0), bent(r.value, true).value);
  const PixelCorrelation correlation = correlation_of(grid, normal);
  if (correlation.rings == 0) return found;
  found.spacing_px = spacing_of(correlation);
  found.noise = noise_correlation(correlation, grid.count(), static_cast<double>(found.residuals.size()));
  std::erase_if(found.residuals, [&](const Residual& r) {
    return (r.x - x0) % found.spacing_px != 0 || (r.y - y0) % found.spacing_px != 0;
  });
  return found;
}

Adequacy judge_sequence(std::span<const Residual> residuals) {
  Adequacy a = sums(residuals);
  double neighbours = 0.0;
  for (std::size_t i = 1; i < residuals.size(); ++i)
    if (residuals[i].y == residuals[i - 1].y)
      neighbours += bent(residuals[i].value, true).value * bent(residuals[i - 1].value, true).value;
  const double mean_square = a.chi2 / std::max<double>(1.0, static_cast<double>(residuals.size()));
  if (residuals.size() >= 8 && mean_square > 0.0)
    a.whiteness_p = normal_tail(neighbours / mean_square / std::sqrt(static_cast<double>(residuals.size())));
  return a;
}

// The step's residual r(d) has the transform of a line spread 2 pi i f R(f), R the integral of r exp(-2 pi i f d).
std::vector<double> residual_otf(const Adequacy& adequacy, double contrast_sd, std::span<const double> f_cy_px) {
  std::vector<double> all(f_cy_px.size(), 0.0);
  if (adequacy.whiteness_p > 0.01 || !(contrast_sd > 0.0)) return all;
  for (std::size_t k = 0; k < f_cy_px.size(); ++k) {
    std::complex<double> sum;
    double variance = 0.0;
    const double turn = 2.0 * std::numbers::pi * f_cy_px[k];
    for (const ResidualBin& bin : adequacy.bins) {
      sum += bin.width_px * bin.mean * std::polar(1.0, -turn * bin.distance_px);
      variance += bin.width_px * bin.width_px * bin.variance;
    }
    const double size = std::norm(sum);
    const double keep = size > 0.0 ? std::max(0.0, 1.0 - 2.0 * variance / size) : 0.0;
    all[k] = keep * turn * std::sqrt(size) / contrast_sd;
  }
  return all;
}

}  // namespace calib
