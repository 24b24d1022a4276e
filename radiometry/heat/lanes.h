// SPDX-License-Identifier: Apache-2.0
#pragma once

// The loops of the solver: kLanes facets of equal construction side by side, in vectors. Arrays of nodes are
// [node * kLanes + lane].

#include <array>
#include <cstddef>
#include <vector>

#include "radiometry/heat/depth/depth_grid.h"
#include "radiometry/heat/depth/elimination.h"

namespace radiometry::heat {

/// Facets that share their steps. More of them amortise what a step costs for all, fewer let facets with other shadows
/// have other steps. Of 8, 16, 32 and 64, 32 took the least time, whether neighbours share their shadows or not
/// (tests/bench/bench_heat.cpp).
inline constexpr std::size_t kLanes = 32;

struct alignas(64) Lanes {
  std::array<double, kLanes> at{};
  double& operator[](std::size_t lane) { return at[lane]; }
  const double& operator[](std::size_t lane) const { return at[lane]; }
};

/// An exposed side of the facets at an instant.
struct Surface {
  double emission = 0.0;  ///< epsilon sigma
  double film = 0.0, air_k = 0.0;
  double latent = 0.0, vapour_pa = 0.0;  ///< as SurfaceLoss
  Lanes absorbed;
};

/// What does not change with time: coefficients of natural convection, for air colder and warmer than the surface.
struct Buoyancy {
  bool present = false;
  Lanes warm{}, cold{};
};

enum class Sides { one, two_on_one_node, two };

/// What all steps of a group of facets on one grid share.
struct GroupGrid {
  const Grid* grid = nullptr;
  Sides sides = Sides::one;
  bool inner_flux = false;  ///< the inside value is a flux and not a temperature
  bool wet = false;         ///< a side evaporates
  const Buoyancy* front_buoyancy = nullptr;
  const Buoyancy* back_buoyancy = nullptr;
};

/// All boundaries at an instant.
struct Boundary {
  Surface front, back;
  double inside = 0.0;
  std::vector<double> source_w_m3{};  ///< of each layer; empty: none
};

/// One implicit stage, with increments D of the temperatures T as unknowns:
///   (M + a K) D + a (loss(T + D) - loss(T)) = keep M D_before + a (weight (-K T) + q - loss(T) [+ the same `before`])
/// with q and the losses at `at`. On return D has the increments and T the new temperatures.
struct StageRequest {
  const Elimination<double>* elimination = nullptr;
  double keep = 0.0;
  const Boundary* before = nullptr;  ///< weight 2 where it is given, else 1
  const Boundary* at = nullptr;
};
void run_stage(const GroupGrid& group, const StageRequest& request, std::vector<double>& t, std::vector<double>& d,
               std::vector<double>& scratch);

/// The largest |error| of the exposed surfaces over the lanes, K:
///   (M + a (K + slopes)) error = of_flow (a F) + M (of_first D1 + of_second D2)
/// F the flow into each node at temperatures `t` and boundaries `at`.
struct ErrorWeights {
  double of_flow = 0.0, of_first = 0.0, of_second = 0.0;
};
double surface_error(const GroupGrid& group, const Elimination<double>& elimination, const ErrorWeights& weights,
                     const Boundary& at, const std::vector<double>& t, const std::vector<double>& first,
                     const std::vector<double>& second, std::vector<double>& scratch);

/// Heat over the boundaries, J/m2 per lane.
struct HeatSums {
  Lanes absorbed, emitted, convected, inside;  ///< convected: latent heat too
};
/// Adds the flows at temperatures `t` and boundaries `at`, for `duration_s`.
void add_heat(const GroupGrid& group, const Boundary& at, const std::vector<double>& t, double duration_s,
              HeatSums& sums);

}  // namespace radiometry::heat
