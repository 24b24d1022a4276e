// SPDX-License-Identifier: Apache-2.0

// Gauss rule of a weight given by many points: its Jacobi matrix by the rational QR steps of Gragg and Harwood (Numer.
// Math. 44, 317 (1984)), which add one point at a time and never lose orthogonality, then nodes and weights from its
// eigenvectors (Golub and Welsch, Math. Comp. 23, 221 (1969)).

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/math/quadrature.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/exponent.h"

namespace radiometry {
namespace {

constexpr int kMostNodes = 256;
constexpr double kMostPanels = 1e4;

struct Jacobi {
  std::vector<double> diagonal{}, square{};  // of the side diagonal; square[0] is the total weight
  std::size_t points = 0;
  std::size_t most;

  void add(double node, double weight) {
    if (points < most) {
      diagonal.push_back(node);
      square.push_back(points == 0 ? weight : 0.0);
    }
    ++points;
    if (points == 1) return;
    double cosine = 1.0, sine = 0.0, shift = 0.0, entering = weight;
    for (std::size_t k = 0; k < diagonal.size(); ++k) {
      const double total = square[k] + entering, kept = cosine * total, sine_before = sine;
      cosine = total > 0.0 ? square[k] / total : 1.0;
      sine = total > 0.0 ? entering / total : 0.0;
      const double next = sine * (diagonal[k] - node) - cosine * shift;
      diagonal[k] -= next - shift;
      shift = next;
      entering = sine > 0.0 ? shift * shift / sine : sine_before * square[k];
      square[k] = kept;
    }
  }
};

}  // namespace

std::vector<BandResponse::Panel> BandResponse::panels(std::optional<double> temperature_k) const {
  std::vector<Panel> all;
  for (const Piece& piece : pieces_) {
    const double width = piece.hi_um - piece.lo_um;
    const double depth = temperature_k ? width / piece.lo_um * exponent(piece.hi_um, *temperature_k).x : 0.0;
    const double count = std::ceil(std::min(kMostPanels, 8.0 * std::log(piece.hi_um / piece.lo_um) + depth / 20.0));
    for (double panel = 0.0; panel < count; ++panel)
      all.push_back({&piece, piece.lo_um + width * panel / count, width / count, count == 1.0});
  }
  return all;
}

// A piece gets as many points as the integral of a polynomial of degree 2n times the response needs; narrow ones fewer.
BandResponse::RatePoints BandResponse::rate_points(int n, std::optional<double> temperature_k, Flux flux) const {
  if (temperature_k && !(*temperature_k > 0.0 && *temperature_k <= kHottest_k))
    throw mtf::UsageError("a source of " + mtf::format_double(*temperature_k) +
                          " K; the temperature has to be above 0, at most " + mtf::format_double(kHottest_k) + " K");
  RatePoints points;
  std::vector<double> log_rate;
  const double whole = range_.hi_um - range_.lo_um;
  for (const Panel& panel : panels(temperature_k)) {
    const double lo = panel.lo_um, step = panel.width_um;
    const int degree = static_cast<int>(std::ceil(n * std::min(1.0, 4.0 * step / whole)));
    const mtf::GaussRule rule = mtf::mean_rule(lo, lo + step,
                                               degree + (!panel.whole || step > 0.02 * lo ? 32
                                                         : step > 1e-3 * lo               ? 12
                                                                                          : 6));
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double response = piece_value(*panel.piece, rule.node[i]);
      if (!(response > 0.0)) continue;
      points.wavelength_um.push_back(rule.node[i]);
      points.rate.push_back(rule.weight[i] * step * response);
      log_rate.push_back(temperature_k ? log_planck(flux, rule.node[i], *temperature_k) : 0.0);
    }
  }
  if (!log_rate.empty()) points.log_largest = *std::max_element(log_rate.begin(), log_rate.end());
  for (std::size_t i = 0; i < log_rate.size(); ++i) {
    points.rate[i] *= std::exp(log_rate[i] - points.log_largest);
    points.sum += points.rate[i];
  }
  if (!log_rate.empty() && !std::isfinite(points.log_largest))
    throw mtf::UsageError("a source of " + mtf::format_double(*temperature_k) + " K sends no photons from " +
                          describe(range_) + "; give it a temperature at which it does");
  if (!(points.sum > 0.0))
    throw mtf::UsageError(
        "no electrons to weigh wavelengths by: the curves of the path, the optics and the detector "
        "multiply to 0 everywhere from " +
        describe(range_) + "; check that they overlap there, with wavelengths in um");
  return points;
}

mtf::WavelengthNodes BandResponse::electron_nodes(int n, std::optional<double> temperature_k, Flux flux) const {
  if (n < 1 || n > kMostNodes)
    throw mtf::UsageError(std::to_string(n) + " wavelengths of a band; give 1 to " + std::to_string(kMostNodes));
  const RatePoints points = rate_points(n, temperature_k, flux);
  Jacobi jacobi{.most = static_cast<std::size_t>(n)};
  for (std::size_t i = 0; i < points.rate.size(); ++i)
    if (points.rate[i] > 0.0) jacobi.add(points.wavelength_um[i], points.rate[i]);
  const auto size = static_cast<Eigen::Index>(jacobi.diagonal.size());
  Eigen::VectorXd diagonal(size), side(std::max<Eigen::Index>(size - 1, 0));
  for (Eigen::Index k = 0; k < size; ++k) diagonal[k] = jacobi.diagonal[static_cast<std::size_t>(k)];
  for (Eigen::Index k = 0; k + 1 < size; ++k) side[k] = std::sqrt(jacobi.square[static_cast<std::size_t>(k + 1)]);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, side);
  mtf::WavelengthNodes nodes;
  for (Eigen::Index k = 0; k < size; ++k) {
    nodes.wavelength_um.push_back(std::clamp(solver.eigenvalues()[k], range_.lo_um, range_.hi_um));
    const double root = solver.eigenvectors()(0, k);
    nodes.weight.push_back(root * root);
  }
  return nodes;
}

mtf::ElectronRate BandResponse::electron_rate(std::optional<double> temperature_k, Flux flux) const {
  const RatePoints points = rate_points(1, temperature_k, flux);
  std::vector<double> breaks_um;
  for (const Panel& panel : panels(temperature_k)) breaks_um.push_back(panel.lo_um);
  breaks_um.push_back(range_.hi_um);
  auto nodes = [*this, temperature_k, flux](int n) {
    return electron_nodes(std::min(n, kMostNodes), temperature_k, flux);
  };
  // Logarithms cost twice as much, and are for radiances that leave the range of numbers.
  constexpr double kOrdinary = 600.0;
  const double scale = std::abs(points.log_largest) < kOrdinary ? std::exp(-points.log_largest) : 0.0;
  auto density = [*this, temperature_k, flux, scale, largest = points.log_largest,
                  sum = points.sum](double wavelength_um) {
    const double response = value(wavelength_um);
    if (!(response > 0.0) || !temperature_k) return response / sum;
    if (scale > 0.0) return response * (planck(flux, wavelength_um, *temperature_k) * scale) / sum;
    return response * std::exp(log_planck(flux, wavelength_um, *temperature_k) - largest) / sum;
  };
  return {std::move(nodes), std::move(density), std::move(breaks_um)};
}

}  // namespace radiometry
