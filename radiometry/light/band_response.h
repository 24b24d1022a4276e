// SPDX-License-Identifier: Apache-2.0
#pragma once

// A product of curves over a band (filter x optics x quantum efficiency ...), its integrals with Planck's law and the
// Gauss rules for which it is the weight.
//
//   weighted radiance = integral over the band of product(lambda) L(lambda, T) dlambda
//
// The product is never sampled anew: between neighbouring samples of the curves it is a polynomial of the wavelength,
// and the integral is taken there piece by piece in x = c2 / (lambda T), by 16 Gauss-Legendre nodes on panels no wider
// than 4 and no longer than a ratio of 1.5. On such a panel the nearest poles, x = 0 and 2 pi i, lie 5 and 3.3 half
// widths from its middle: what the rule leaves is below 1e-15 of the panel for up to 8 curves, at any temperature.
// (Panels below a ratio of 1.02 take 6 nodes, to the same end.)

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mtf/system.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/light/spectrum.h"

namespace radiometry {

class BandResponse {
 public:
  /// The product of the curves over the wavelengths that the band and all curves have in common; it is 1 without
  /// curves. Throws UsageError as common_range does, and for more than 8 curves.
  BandResponse(const Interval& band, std::span<const Spectrum> factors);

  /// The wavelengths that the band and the curves have in common.
  const Interval& range() const { return range_; }
  /// The product at a wavelength in the range.
  double value(double wavelength_um) const;
  /// Integral of the product over the range, um.
  double integral() const;

  /// Weighted radiance of a blackbody, W or photons per second, m^-2 sr^-1; 0 at 0 K, NaN below.
  template <class S>
  S radiance(Flux flux, const S& temperature_k) const {
    const double t = mtf::value_of(temperature_k);
    return mtf::lift({planck_integral(flux, t, false), planck_integral(flux, t, true)}, temperature_k);
  }
  /// Its derivative by the temperature, per K.
  double derivative(Flux flux, double temperature_k) const { return planck_integral(flux, temperature_k, true); }

  /// n wavelengths and weights such that the weighted sum is the mean of a function over the electrons that a blackbody
  /// of `temperature_k` gives, the response being that per photon; without a temperature the photon radiance is the
  /// same at all wavelengths. They are a Gauss rule, exact for polynomials of degree 2n - 1 in the wavelength, with
  /// positive weights of sum 1 and rising wavelengths, and take the place of mtf::wavelength_nodes. 1 <= n <= 256.
  /// There are fewer than n where the rate is above 0 at fewer points. With watts it is the signal of a thermal
  /// detector in place of the electrons, the response being that to power. Throws UsageError when there are no
  /// electrons.
  mtf::WavelengthNodes electron_nodes(int n, std::optional<double> temperature_k, Flux flux = Flux::photons) const;

  /// The same electrons for mtf::Band::rate: these nodes, at most 256 of them, and their density. Throws as
  /// electron_nodes does.
  mtf::ElectronRate electron_rate(std::optional<double> temperature_k, Flux flux = Flux::photons) const;

 private:
  struct Piece {
    double lo_um, hi_um;
    std::size_t ends;  ///< index into ends_: value of each curve at lo, then at hi
  };
  /// An interval within a piece over which Planck's law is nearly a polynomial.
  struct Panel {
    const Piece* piece;
    double lo_um, width_um;
    bool whole;  ///< all of the piece
  };
  std::vector<Panel> panels(std::optional<double> temperature_k) const;
  /// Electrons at many wavelengths, relative to the largest rate, whose logarithm may lie far below that of a double.
  struct RatePoints {
    std::vector<double> wavelength_um, rate;
    double log_largest = 0.0, sum = 0.0;
  };
  /// Enough points for a Gauss rule of n nodes.
  RatePoints rate_points(int n, std::optional<double> temperature_k, Flux flux) const;
  double piece_value(const Piece& piece, double wavelength_um) const;
  double planck_integral(Flux flux, double temperature_k, bool derivative) const;

  Interval range_;
  std::size_t factors_ = 0;
  std::vector<Piece> pieces_;  ///< rising
  std::vector<double> ends_;
};

/// Weighted radiance of a blackbody for every pixel of a temperature image: the integral of BandResponse, made
/// once into a table that the bits of the temperature index.
///
/// First log L is sampled over log T, with its slope, densely enough that cubics through value and slope at both ends
/// are right within 1e-9: L itself runs over hundreds of decades, its logarithm over a few hundreds. Then each octave
/// of T is cut into 2^n cells, n such that L grows by less than 7 % in a cell, and each gets the cubic through L and
/// dL/dT at its ends. A float has its octave in the exponent and its cell in the leading bits of the mantissa, so that
/// a pixel takes no logarithm, no exponential and no search. The relative error is below 1e-7 before the result is
/// rounded to float, and L rises strictly with T.
class RadianceTable {
 public:
  /// For temperatures from lo_k to hi_k, 0 <= lo <= hi, finite. Throws UsageError for others.
  RadianceTable(const BandResponse& response, double lo_k, double hi_k, Flux flux = Flux::photons);

  /// Photons per second or watts, m^-2 sr^-1, weighted by the response, of a temperature in [lo, hi]; 0 where the
  /// radiance is below the smallest float. Below lo it is 0, above hi that of hi; NaN for NaN, infinite for infinite.
  double operator()(float temperature_k) const {
    const auto bits = std::bit_cast<std::uint32_t>(temperature_k);
    if (!(temperature_k >= start_)) return temperature_k < start_ ? 0.0 : static_cast<double>(temperature_k);
    if (temperature_k > end_) return beyond(temperature_k);
    const Cell& cell = cells_[(bits >> shift_) - first_];
    const double t = static_cast<double>(bits & mask_) * step_;
    return cell.c0 + t * (cell.c1 + t * (cell.c2 + t * cell.c3));
  }

 private:
  /// Cubic of the place in a cell, 0 to 1.
  struct Cell {
    double c0, c1, c2, c3;
  };
  double beyond(float temperature_k) const;

  float start_ = 0.0F, end_ = 0.0F;  ///< where there is radiance; no cells: start above end
  std::uint32_t shift_ = 0, first_ = 0, mask_ = 0;
  double step_ = 0.0;
  std::vector<Cell> cells_;
};

}  // namespace radiometry
