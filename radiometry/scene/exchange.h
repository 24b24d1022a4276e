// SPDX-License-Identifier: Apache-2.0
#pragma once

// Exchange of radiation between patches, which are groups of receivers of nearly equal temperature.
//
// Sampled factors keep neither of the laws that the true ones keep. Both are restored, since energy would be made or
// lost otherwise:
//   reciprocity  A_i F_ij = A_j F_ji
//   closure      sum_j F_ij + sky + ground = 1
// With the exchange areas S_ij = A_i F_ij: S <- (S + S^T) / 2, and then factors d of the patches so that d_i S_ij d_j
// and d_i x (what leaves) have the row sums A_i (symmetric scaling: Sinkhorn and Knopp, Pacific J. Math. 21, 1967;
// Knight, Ruiz and Ucar, SIAM J. Matrix Anal. Appl. 35, 2014). What rounding leaves, and what no scaling can mend, is
// given to the view of the patch by itself, where no heat is exchanged.
//
// Radiosity J of a diffuse grey patch with emitted flux E, reflectance rho and flux H0 received from sky, ground and
// sun:
//   H = H0 + F J,   J = E + rho H          (W m^-2)
// the same for long-wave and solar radiation. With A F symmetric and z = sqrt(rho A) H, (1 - M) z = b with the
// symmetric M = sqrt(rho/A) S sqrt(rho/A), whose eigenvalues are below max(rho): solved by conjugate gradients
// (Hestenes and Stiefel 1952), whatever the number of bounces.

#include <span>
#include <vector>

#include "radiometry/scene/views.h"

namespace radiometry::scene {

struct Exchange {
  std::vector<double> area_m2;  ///< of each patch
  SparseRows factors;           ///< F_ij, reciprocal; row i and leaving[i] sum to 1
  std::vector<double> leaving;  ///< share of each patch that ends in the sky or on the ground
  std::vector<double> scale;    ///< d_i: what multiplies sky and ground of the sampled views of the patch
  double correction =
      0.0;                ///< rms over patches, by area, of the change of F_ij in a row: sqrt(sum_j (F_ij - sampled)^2)
  double own_view = 0.0;  ///< largest share that was given to the view of a patch by itself; 0 but for rounding

  std::size_t size() const { return area_m2.size(); }
};

/// Exchange of the patches that `views` was made for: receiver i has the area `area_m2[i]` and belongs to patch
/// `patch_of[i]`. Throws mtf::UsageError when a patch has no receiver.
Exchange exchange_of(const Views& views, std::span<const double> area_m2, std::span<const std::uint32_t> patch_of,
                     std::size_t patches);

struct Radiosity {
  std::vector<double> leaving_w_m2;   ///< J
  std::vector<double> received_w_m2;  ///< H, with H0
  int iterations = 0;
};

/// Reflectances are in [0, 1); with 1, where a closed group of mirrors has no answer, a mtf::UsageError. Throws
/// mtf::RuntimeError when the relative residual does not fall to `tolerance`.
Radiosity radiosity(const Exchange& exchange, std::span<const double> emitted_w_m2, std::span<const double> reflectance,
                    std::span<const double> received_from_outside_w_m2, double tolerance = 1e-14);

/// What each receiver takes in from the patches, W m^-2, given their radiosities: its own row of `views.patches`,
/// shifted so that the mean over the receivers of a patch is that of `exchange`. So the energy that receivers take in
/// is exactly what the patches give off, and a uniform radiosity stays one.
std::vector<double> received_from_patches(const Exchange& exchange, const Views& views, std::span<const double> area_m2,
                                          std::span<const std::uint32_t> patch_of,
                                          std::span<const double> radiosity_w_m2);

}  // namespace radiometry::scene
