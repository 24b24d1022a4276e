// SPDX-License-Identifier: Apache-2.0
#pragma once

// Exchange of radiation between receivers, by way of patches: groups of receivers that have nearly the same temperature
// and the same reflectance. What a receiver sees is told by patch; what a patch gives off is the mean of its receivers.
//
// Sampled factors keep neither of the laws that the true ones keep, and without them energy would be made or lost:
//   reciprocity  A_i F_ij = A_j F_ji
//   closure      sum_j F_ij + l_i = 1,   l_i the share that leaves for the sky or the ground
// Exchange areas S_ij = A_i F_ij are known from the rays of i and from those of j. A ray of patch i stands for the area
// a_i = A_i over its rays, and S_ij as told by i has the variance S_ij a_i: both are joined with the inverse variances
// as weights, so that a small patch is not spoiled by the few rays of a large one that hit it. The joint values have
// the variances V_ij = S_ij a_i a_j / (a_i + a_j), V_ii = S_ii a_i, and A_i l_i has A_i l_i a_i. They are then changed
// by the least amount, in units of these, that closes the rows:
//   S_ij <- S_ij + V_ij (x_i + x_j),   A_i l_i <- A_i l_i (1 + a_i x_i),   (diag(row sums of V) + V) x = A - row sums
//   of S
// (van Leersum, Int. J. Heat Fluid Flow 10, 1989; Lawson, Proc. 7th Heat Pipe Conf., 1995). A value that would fall
// below 0 becomes 0; rows that then still exceed their area are scaled down with their columns, and what lacks is given
// to the view of the patch by itself, where no heat is exchanged.
//
// Irradiance H and radiosity J of grey diffuse patches (Hottel and Sarofim, Radiative Transfer, 1967), E emitted flux,
// rho reflectance, H0 what comes from sky, ground and sun, in W m^-2, long-wave and solar alike:
//   H = H0 + F J,   J = E + rho H
// With z = sqrt(rho A) H this is (1 - M) z = b, M = sqrt(rho/A) S sqrt(rho/A) symmetric with eigenvalues within
// +-max(rho): conjugate gradients (Hestenes and Stiefel, 1952) solve it for any number of bounces.

#include <span>
#include <vector>

#include "radiometry/scene/views.h"

namespace radiometry::scene {

struct Exchange {
  std::vector<double> area_m2;        ///< of each patch
  SparseRows factors;                 ///< F_ij between patches; columns rising
  std::vector<double> leaving;        ///< l_i
  std::vector<double> leaving_scale;  ///< l_i over the sampled mean of the patch; 1 where that is 0
  double change = 0.0;                ///< rms over patches, by area, of sqrt(sum_j (F_ij - sampled F_ij)^2)
  double own_view = 0.0;  ///< largest share that was given to the view of a patch by itself: 0 but for rounding

  std::vector<double> receiver_area_m2;
  std::vector<std::uint32_t> patch_of;  ///< of each receiver
  SparseRows rows;                      ///< of each receiver: what it sees of each patch, as sampled

  std::size_t patches() const { return area_m2.size(); }
  std::size_t receivers() const { return patch_of.size(); }
};

/// `views` has a row for each receiver, `patch_of` the patch that it belongs to. Throws mtf::UsageError when sizes do
/// not fit each other or a patch has no receiver.
Exchange exchange_of(const Views& views, std::span<const double> receiver_area_m2,
                     std::span<const std::uint32_t> patch_of, std::size_t patches);

struct Radiosity {
  std::vector<double> irradiance_w_m2;   ///< H
  std::vector<double> radiosity_w_m2{};  ///< J
  int iterations = 0;
};

/// Of patches; of several moments at once, `columns` of them, where fluxes are [patch * columns + column], in and out.
/// Reflectances are in [0, 1). Throws mtf::UsageError for others, and mtf::RuntimeError when the relative residual of a
/// column does not fall to `tolerance`.
Radiosity radiosity(const Exchange& exchange, std::span<const double> emitted_w_m2, std::span<const double> reflectance,
                    std::span<const double> from_outside_w_m2, double tolerance = 1e-14, std::size_t columns = 1);

/// The product of rows with columns that stand side by side, [row * columns + column].
void times(const SparseRows& rows, std::size_t columns, std::span<const double> x, std::span<double> y);

/// Fluxes of receivers, W m^-2; an entry for each.
struct ReceiverFluxes {
  std::span<const double> emitted;      ///< epsilon sigma T^4; 0 for solar radiation
  std::span<const double> reflectance;  ///< in [0, 1)
  std::span<const double>
      environment;                 ///< from the sky and the ground that it sees: shares of its view times radiation
  std::span<const double> direct;  ///< from the sun
};

/// The irradiance H of each receiver, with what comes from sky, ground and sun: radiosity between patches, then the
/// receiver's own row, shifted so that the mean of the receivers of a patch is the patch's. So what all receivers take
/// in is what they are given (to rounding, where reflectance is the same within each patch), and in an isothermal scene
/// every receiver gets sigma T^4.
std::vector<double> irradiance_w_m2(const Exchange& exchange, const ReceiverFluxes& fluxes, double tolerance = 1e-14);

}  // namespace radiometry::scene
