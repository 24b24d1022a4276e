// SPDX-License-Identifier: Apache-2.0
#pragma once

// A construction with one exposed surface as a shorter chain of nodes that this surface cannot tell from the grid.
//
// Of the grid the surface knows its admittance alone, the heat flow into it over its temperature,
//   Y(s) = m_0 s + g_0 - g_0^2 e_1^T (K + s M)^-1 e_1,   K and M of the nodes below it.
// Replacing K and M by their projections on a few vectors (K + s_j M)^-1 e_1, of the times 1 / s_j that matter, gives
// an admittance with the same value and slope at every s_j (rational Krylov spaces: Ruhe, Linear Algebra Appl. 58, 391,
// 1984), whose error falls exponentially with their number. In the basis in which the projection is tridiagonal it is a
// chain of capacities and conductances again, all above 0: a grid by Gauss's quadrature, so to say (Druskin and
// Knizhnerman, SIAM J. Numer. Anal. 37, 403, 2000). The vector of ones belongs to the space, so that the chain has the
// heat capacity of the grid and rests where the grid rests. Nodes below the surface are no depths then.
//
// A step of the flux by q moves a surface at the frequency w by q / (w |Y|), so that the chain is off by at most
//   (2 / pi) q integral |dY| / |Y|^2 dw / w,
// twice the inverse Fourier transform of the moduli; what a surface gives off makes that smaller.

#include "radiometry/heat/depth/depth_grid.h"

namespace radiometry::heat {

struct ShortChain {
  Grid grid;             ///< without depth_m and layer_m, unless it is the grid that was given
  double error_k = 0.0;  ///< by the integral above
};

/// For grids that are adiabatic inside and generate no heat, in a run of `duration_s` with steps of flux up to
/// `flux_w_m2`. Where no chain of at most three quarters of the nodes keeps `error_k`, the grid itself.
ShortChain shortened(const Grid& grid, double flux_w_m2, double duration_s, double error_k);

}  // namespace radiometry::heat
