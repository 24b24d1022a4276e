// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/band_response.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mtf/error.h"
#include "mtf/math/quadrature.h"
#include "mtf/units.h"
#include "radiometry/light/exponent.h"

namespace radiometry {
namespace {

constexpr std::size_t kMostFactors = 8;
/// Beyond this distance into a piece e^-x is below the precision of a double.
constexpr double kDepth = 80.0;

/// Half of the smallest float: smaller values are rounded to 0.
constexpr double kLeast = 7e-46;
constexpr double kLogError = 1e-9;
constexpr double kGrowth = 0.067;  ///< of L in a cell: the cubic is wrong by 1/384 of its fourth power
constexpr int kMantissa = 23, kFewestBits = 5;
constexpr double kWidestCell = 0x1p-5;  // of log T

/// log L at a temperature and its slope by log T.
struct Knot {
  double log_t, log_l, slope;
};

Knot knot(const BandResponse& response, Flux flux, double log_t) {
  const double t = std::exp(log_t), l = response.radiance(flux, t);
  return {log_t, std::log(l), t * response.derivative(flux, t) / l};
}

/// The cubic through two knots, and its slope.
Knot between(const Knot& a, const Knot& b, double log_t) {
  const double h = b.log_t - a.log_t, t = (log_t - a.log_t) / h, rest = 1.0 - t;
  const double rise = b.log_l - a.log_l, bend_a = h * a.slope - rise, bend_b = rise - h * b.slope;
  const double bend = bend_a * rest + bend_b * t;
  return {log_t, a.log_l + t * rise + t * rest * bend, (rise + (rest - t) * bend + t * rest * (bend_b - bend_a)) / h};
}

/// Knots after `a` up to `b`. Halving leaves 1/16 of the error in the middle.
void add_knots(const BandResponse& response, Flux flux, const Knot& a, const Knot& b, int depth,
               std::vector<Knot>& knots) {
  const Knot middle = knot(response, flux, 0.5 * (a.log_t + b.log_t));
  const double error = std::abs(between(a, b, middle.log_t).log_l - middle.log_l);
  const bool wide = b.log_t - a.log_t > 0.35;
  if (depth > 0 && (wide || !(error <= 8.0 * kLogError))) {
    add_knots(response, flux, a, middle, depth - 1, knots);
    add_knots(response, flux, middle, b, depth - 1, knots);
  } else {
    knots.push_back(middle);
    knots.push_back(b);
  }
}

/// The lowest temperature in [lo, hi] from which on there is radiance, or a little less; above hi when there is none.
double first_warm(const BandResponse& response, Flux flux, double lo_k, double hi_k) {
  const auto warm = [&](double t) { return response.radiance(flux, t) >= kLeast; };
  if (!warm(hi_k)) return 2.0 * hi_k;
  double cold = std::max(lo_k, 1e-30), hot = hi_k;
  if (warm(cold)) return cold;
  while (hot > 1.001 * cold) {
    const double middle = std::sqrt(cold) * std::sqrt(hot);
    (warm(middle) ? hot : cold) = middle;
  }
  return hot;
}

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

RadianceTable::RadianceTable(const BandResponse& response, double lo_k, double hi_k, Flux flux) {
  if (!(lo_k >= 0.0 && hi_k >= lo_k && hi_k <= std::numeric_limits<float>::max()))
    throw mtf::UsageError("a table of radiances from " + mtf::format_double(lo_k) + " K to " +
                          mtf::format_double(hi_k) + " K; temperatures are 0 or above, finite and rise");
  start_ = 1.0F;
  if (hi_k == 0.0) return;
  const double warm = first_warm(response, flux, lo_k, hi_k);
  start_ = static_cast<float>(warm);
  end_ = static_cast<float>(hi_k);
  if (start_ > end_) {
    end_ = 0.0F;
    return;
  }

  // The table goes one cell further at both ends.
  std::vector<Knot> knots{knot(response, flux, std::log(warm) - kWidestCell)};
  add_knots(response, flux, knots[0], knot(response, flux, std::log(hi_k) + kWidestCell), 16, knots);
  double growth = 1.0;
  for (const Knot& k : knots) growth = std::max(growth, k.slope);
  const int cell_bits = std::clamp(static_cast<int>(std::ceil(std::log2(growth / kGrowth))), kFewestBits, 16);
  shift_ = static_cast<std::uint32_t>(kMantissa - cell_bits);
  mask_ = (1U << shift_) - 1U;
  step_ = std::ldexp(1.0, -static_cast<int>(shift_));
  first_ = std::bit_cast<std::uint32_t>(start_) >> shift_;
  const std::uint32_t last = std::bit_cast<std::uint32_t>(end_) >> shift_;
  const auto temperature = [&](std::uint32_t cell) {  // also of the cell after the largest float
    const double octave = std::ldexp(1.0, static_cast<int>(cell >> cell_bits) - 127);
    const std::uint32_t place = cell & ((1U << cell_bits) - 1U);
    return octave * (1.0 + std::ldexp(static_cast<double>(place), -cell_bits));
  };
  // L and T dL/dT.
  auto at = [&, k = std::size_t{0}](double temperature_k) mutable {
    const double log_t = std::log(temperature_k);
    while (k + 2 < knots.size() && knots[k + 1].log_t < log_t) ++k;
    const Knot found = between(knots[k], knots[k + 1], log_t);
    const double l = std::exp(found.log_l);
    return std::pair{l, l * found.slope};
  };
  double from = temperature(first_);
  auto [low, low_slope] = at(from);
  for (std::uint32_t cell = first_; cell <= last; ++cell) {
    const double to = temperature(cell + 1), width = to - from;
    const auto [high, high_slope] = at(to);
    const double rise = high - low, a = low_slope * width / from, b = high_slope * width / to;
    cells_.push_back({low, a, 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise});
    low = high;
    low_slope = high_slope;
    from = to;
  }
}

double RadianceTable::beyond(float temperature_k) const {
  if (std::isinf(temperature_k)) return static_cast<double>(temperature_k);
  return end_ > 0.0F ? (*this)(end_) : 0.0;
}

}  // namespace radiometry
