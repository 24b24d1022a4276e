// SPDX-License-Identifier: Apache-2.0
#pragma once

// One quadrature for all integrals over a band,
//   L = integral of R(lambda) L_lambda(lambda) dlambda = sum over nodes k of w_k L_lambda(lambda_k),
// R the product of the camera's curves, so that source x emissivity x air x response are integrated together, and what
// adds up at every wavelength (eps B + (1 - eps) B = B, tau B + (1 - tau) B = B) adds up in the sums, to rounding.
//
// The band is cut at every sample of a curve (of the camera and of emissivities) and at the wavenumbers of the air
// model, every 5 cm^-1; in each piece the integrand is a polynomial of the wavelength times Planck's law, and takes a
// Gauss rule. A piece has a relative width of 0.7 % or less where there is air (c2/(lambda T) changes by less than 0.2
// at 200 K): with three nodes and three straight lines in the product the rule is exact but for 1e-11.
//
// The air is known at its wavenumbers alone. Between them transmission tau, and the ratio s of the path's radiance to a
// blackbody's of one reference temperature, are straight lines of the wavelength. (Interpolating the path's radiance
// itself makes an isothermal path differ from (1 - tau) B by up to 7e-5 at 3 um.) Both are then sums over the air's
// samples i,
//   integral of R tau f = sum_i tau_i F_i,   F_i = sum_k w_k f_k h_i(lambda_k),   h_i the hat of sample i,
// so that a path takes one product and sum a sample: `fold` makes F of w f.

#include <span>
#include <vector>

#include "radiometry/light/spectral_signal.h"

namespace radiometry::render {

struct BandNodes {
  Flux flux = Flux::photons;
  Interval range{};  ///< of wavelengths with a response
  std::vector<double> wavelength_um{}, weight{};
  std::vector<double> sample_um{};      ///< of the air, rising; one or more
  std::vector<std::uint32_t> sample{};  ///< of each node: the sample at or below it
  std::vector<double> share{};          ///< and what part belongs to the one above

  std::size_t size() const { return weight.size(); }
  std::size_t samples() const { return sample_um.size(); }
};

/// Shortest and longest wavelength that pictures are made for: below, scattered sunlight would be missing; above, the
/// air model ends.
inline constexpr Interval kThermalBands{3.0, 14.0};

/// `more`: curves whose samples the pieces end at, beside the camera's. `nodes` of each piece. Throws mtf::UsageError
/// for a band that is not within kThermalBands, and as common_range.
BandNodes band_nodes(const SpectralCamera& camera, std::span<const Spectrum> more, int nodes = 3);

/// Values at the nodes: of a curve, held beyond its ends; of a blackbody (in the flux of the band); of what the air's
/// samples are.
std::vector<double> at_nodes(const BandNodes& nodes, const Spectrum& curve);
std::vector<double> blackbody_at(const BandNodes& nodes, double temperature_k);
std::vector<double> at_nodes(const BandNodes& nodes, std::span<const double> of_samples);

/// sum of weight x values.
double integral(const BandNodes& nodes, std::span<const double> values);
/// F of the head of this file for f = `values`.
std::vector<double> fold(const BandNodes& nodes, std::span<const double> values);

}  // namespace radiometry::render
