// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/band_response.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/math/quadrature.h"
#include "radiometry/light/exponent.h"

namespace radiometry {
namespace {

constexpr std::size_t kMostFactors = 8;
/// Beyond this distance into a piece e^-x is below the precision of a double.
constexpr double kDepth = 80.0;

}  // namespace

BandResponse::BandResponse(const Interval& band, std::span<const Spectrum> factors)
    : range_(common_range(band, factors)), factors_(factors.size()) {
  if (factors.size() > kMostFactors)
    throw mtf::UsageError("a band response of " + std::to_string(factors.size()) + " curves; at most " +
                          std::to_string(kMostFactors) + ", multiply some of them before");
  const std::vector<double> grid = union_grid(range_, factors);
  for (std::size_t i = 0; i + 1 < grid.size(); ++i) {
    pieces_.push_back({grid[i], grid[i + 1], ends_.size()});
    for (const double end : {grid[i], grid[i + 1]})
      for (const Spectrum& factor : factors) ends_.push_back(evaluate(factor, end));
  }
}

double BandResponse::piece_value(const Piece& piece, double wavelength_um) const {
  const double right = (wavelength_um - piece.lo_um) / (piece.hi_um - piece.lo_um), left = 1.0 - right;
  const double* at_lo = ends_.data() + piece.ends;
  const double* at_hi = at_lo + factors_;
  double value = 1.0;
  for (std::size_t i = 0; i < factors_; ++i) value *= at_lo[i] * left + at_hi[i] * right;
  return value;
}

double BandResponse::value(double wavelength_um) const {
  if (!(wavelength_um >= range_.lo_um && wavelength_um <= range_.hi_um)) return 0.0;
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), wavelength_um,
                                      [](double w, const Piece& piece) { return w < piece.hi_um; });
  return piece_value(after == pieces_.end() ? pieces_.back() : *after, wavelength_um);
}

double BandResponse::integral() const {
  double sum = 0.0;
  for (const Piece& piece : pieces_) {
    const mtf::GaussRule rule = mtf::mean_rule(piece.lo_um, piece.hi_um, static_cast<int>(factors_ / 2 + 1));
    for (std::size_t i = 0; i < rule.node.size(); ++i)
      sum += rule.weight[i] * (piece.hi_um - piece.lo_um) * piece_value(piece, rule.node[i]);
  }
  return sum;
}

double BandResponse::planck_integral(Flux flux, double temperature_k, bool derivative) const {
  if (!radiates(temperature_k)) return no_radiance(temperature_k);
  const int p = flux == Flux::watts ? 3 : 2;
  if (temperature_k > kHottest_k) return std::numeric_limits<double>::infinity();
  // The sum runs from the longest wavelength down and is scaled by e^(x of the first piece that adds to it).
  double sum = 0.0;
  Exponent first{};
  for (auto piece = pieces_.rbegin(); piece != pieces_.rend(); ++piece) {
    const Exponent start = exponent(piece->hi_um, temperature_k);
    const double width = (piece->hi_um - piece->lo_um) / piece->lo_um * start.x;
    const double depth = std::min(width, kDepth), scale = sum == 0.0 ? 1.0 : std::exp(first.x - start.x);
    if (scale == 0.0) break;
    double piece_sum = 0.0;
    for (double from = 0.0; from < depth;) {
      const double x = start.x + from, step = std::min({depth - from, 4.0, 0.5 * x});
      const mtf::GaussRule& rule = mtf::gauss_legendre(step <= 0.02 * x && step <= 0.25 ? 6 : 16);
      for (std::size_t i = 0; i < rule.node.size(); ++i) {
        const double s = from + 0.5 * step * (1.0 - rule.node[i]), t = start.x + s, lost = -std::expm1(-t);
        const double planck = (p == 3 ? t * t * t : t * t) * std::exp(-s) / lost;
        const double wavelength_um = piece->hi_um * (start.x / t);
        piece_sum += 0.5 * step * rule.weight[i] * (derivative ? planck * t / lost : planck) *
                     piece_value(*piece, wavelength_um);
      }
      from += step;
    }
    if (sum == 0.0 && piece_sum > 0.0) first = start;
    sum += scale * piece_sum;
  }
  if (sum == 0.0) return 0.0;
  return times_exp(band_factor(flux) * std::pow(temperature_k, derivative ? p : p + 1) * sum, first);
}

}  // namespace radiometry
