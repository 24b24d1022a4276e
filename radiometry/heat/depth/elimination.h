// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interior of a construction eliminated from the linear system of a time step, for all facets at once.
//
// A stage of the scheme, a harmonic of a periodic state and a steady state are all
//   (M + a K) D + a (loss of the surfaces) = r,
// M the heat capacities, K the conduction, a a time (complex for a harmonic). Only the exposed surfaces differ from
// facet to facet, so the other nodes are eliminated from the inside outwards with factors that belong to the grid and a
// alone:
//   (own + mutual) x - mutual y + a loss(x)           = b_0         x: the front node
//   (back_own + mutual) y - mutual x + a loss_back(y) = b_(n-1)     y: the back node, of a sheet alone
// Every factor is a sum, product or quotient of positive numbers (as in the algorithm of Grassmann, Taksar and Heyman,
// Oper. Res. 33, 1107, 1985): no digits cancel, however thin and conductive a cell is.

#include <cstddef>
#include <vector>

#include "radiometry/heat/depth/depth_grid.h"

namespace radiometry::heat {

template <class S>
struct Elimination {
  S a{};
  /// Of each eliminated node i: what of its right-hand side goes to node i - 1, what to the back node, and 1 / pivot.
  std::vector<S> forward, to_back, inverse;
  S own{}, mutual{}, back_own{};
  std::size_t end = 0;  ///< nodes 1 ... end - 1 are eliminated
};

/// `masses` 1 for M + a K, 0 for a K alone.
template <class S>
Elimination<S> eliminate(const Grid& grid, bool sheet, S a, double masses = 1.0) {
  const std::size_t n = grid.nodes();
  const bool two = sheet && n > 1;
  Elimination<S> e;
  e.a = a;
  e.end = two ? n - 1 : n;
  e.forward.resize(n);
  e.to_back.resize(n);
  e.inverse.resize(n);
  S own = masses * grid.capacity[e.end - 1] + (two ? S{} : a * grid.inner_w_m2_k);
  S mutual = two ? a * grid.conductance[n - 2] : S{};
  e.back_own = two ? S(masses * grid.capacity[n - 1]) : S{};
  for (std::size_t i = e.end - 1; i > 0; --i) {
    const S outward = a * grid.conductance[i - 1], pivot = outward + mutual + own;
    e.inverse[i] = 1.0 / pivot;
    e.forward[i] = outward / pivot;
    e.to_back[i] = mutual / pivot;
    e.back_own += own * e.to_back[i];
    own = masses * grid.capacity[i - 1] + own * e.forward[i];
    mutual *= e.forward[i];
  }
  e.own = own;
  e.mutual = mutual;
  return e;
}

/// Solves with losses that are linear, of slopes `front` and `back` in W/m2/K. `b` is the right-hand side of all nodes
/// and becomes the solution.
template <class S>
void solve_linear(const Elimination<S>& e, double front, double back, std::vector<S>& b) {
  const bool two = e.end < b.size();
  for (std::size_t i = e.end - 1; i > 0; --i) {
    b[i - 1] += e.forward[i] * b[i];
    if (two) b.back() += e.to_back[i] * b[i];
  }
  const S p = e.own + e.mutual + e.a * (two ? front : front + back);
  S y{};
  if (two) {
    const S q = e.back_own + e.mutual + e.a * back, determinant = p * q - e.mutual * e.mutual;
    const S x = (q * b[0] + e.mutual * b.back()) / determinant;
    y = b.back() = (p * b.back() + e.mutual * b[0]) / determinant;
    b[0] = x;
  } else {
    b[0] /= p;
  }
  for (std::size_t i = 1; i < e.end; ++i) b[i] = e.inverse[i] * b[i] + e.forward[i] * b[i - 1] + e.to_back[i] * y;
}

}  // namespace radiometry::heat
