// SPDX-License-Identifier: Apache-2.0
#pragma once

// The depth of a construction in cells: vertex-centred finite volumes, a node at each surface and each interface.
//   m_i dT_i/dt = g_(i-1) (T_(i-1) - T_i) + g_i (T_(i+1) - T_i)
// m: heat capacity of the halves of the cells beside a node, J/m2/K; g = k / dx of a cell, W/m2/K.
//
// Heat spreads over s = x / sqrt(alpha) like sqrt(t) in every material, so cells are laid out in s, in sqrt(s): near an
// exposed surface they are sqrt(t_short) / 3 and grow in proportion to the distance from it. The fine
// grid halves every cell of the coarse one in s, which is what Richardson's estimate needs.

#include <vector>

#include "radiometry/heat/construction.h"

namespace radiometry::heat {

struct Grid {
  std::vector<double> capacity;       ///< of each node, J/m2/K, outside first
  std::vector<double> conductance{};  ///< of each cell, W/m2/K: one fewer than nodes
  std::vector<double> depth_m{};      ///< of each node
  std::vector<double> layer_m{};      ///< [node * layers + layer]: how much of the layer belongs to the node
  double inner_w_m2_k = 0.0;  ///< from the last node to the inside temperature: a film, or the last cell before a fixed
                              ///< temperature; 0: none

  std::size_t nodes() const { return capacity.size(); }
};

struct Grids {
  Grid fine, coarse;
};

struct GridRequest {
  double short_time_s = 600.0;  ///< the shortest time after a break at which the temperature has to be right
  double density = 1.0;         ///< cells per length, relative to the first guess
};

Grids make_grids(const Construction& construction, const GridRequest& request);

/// One node for all layers, whose resistance stands between it and the inside: for constructions so thin that no
/// difference of temperature builds up. Nothing is left to refine, so both grids are the same.
Grids make_one_node(const Construction& construction);

/// Bound of the error of one node instead of the layers, K, for net fluxes up to `flux_w_m2`. The flux times the
/// resistance; with an adiabatic inside the flux at a depth is in proportion to the capacity C below it, and the
/// surface differs from the mean by flux * integral of (C / C_total)^2 / k dx: a third of that for one layer. Layers
/// that generate heat have the first bound.
double one_node_error(const Construction& construction, double flux_w_m2);

/// The construction cut off, adiabatic, where what lies deeper changes the surface by no more than `error_k`, and the
/// bound that was found; only an adiabatic construction is cut, which generates no heat. Temperatures within a range of
/// `range_k`, over `duration_s`: a step of that size at the depth s arrives at the surface as 2 erfc(s / (2 sqrt(t)))
/// of it, an oscillation of period P as 2 exp(-s sqrt(pi / P)); every interface at most doubles it.
struct Cut {
  Construction construction;
  double error_k = 0.0;
};
Cut cut_depth(const Construction& construction, double range_k, double duration_s, double error_k);

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

struct ShortChain {
  Grid grid;             ///< without depth_m and layer_m, unless it is the grid that was given
  double error_k = 0.0;  ///< by the integral above
};

/// For grids that are adiabatic inside and generate no heat, in a run of `duration_s` with steps of flux up to
/// `flux_w_m2`. Where no chain of at most three quarters of the nodes keeps `error_k`, the grid itself.
ShortChain shortened(const Grid& grid, double flux_w_m2, double duration_s, double error_k);

}  // namespace radiometry::heat
