// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the surroundings do to a batch of facets of equal construction, as functions of time.
//
// The forcing is asked at any time of the run. Between two breaks it has to be smooth; a break is a time at which it,
// or its slope, jumps: a shadow edge, a weather record, a schedule. Steps of the solver end at breaks. At a break the
// forcing has two values, and the Instant says which one is asked for.

#include <functional>
#include <span>
#include <vector>

#include "radiometry/heat/construction.h"

namespace radiometry::heat {

/// A time in seconds; at a break, whether the value before it or after it is meant. Everywhere else both are the same.
struct Instant {
  double time_s = 0.0;
  enum class Limit { before, after } limit = Limit::after;
};

/// What one side of the facets is exposed to.
struct SideForcing {
  std::span<double> absorbed_w_m2;  ///< per facet, to be filled: all that is absorbed, short-wave and long-wave, and
                                    ///< sources at the surface; emission and convection are the solver's
  double air_k = 0.0;
  double wind_m_s = 0.0;
  double vapour_pa = 0.0;  ///< pressure of the air's vapour, for surfaces that are wet
};

struct ForcingValues {
  SideForcing front;
  SideForcing back;                 ///< of sheets; absorbed_w_m2 is empty for other constructions
  double inside = 0.0;              ///< K for a fixed temperature and a film, W/m2 for a flux, unused otherwise
  std::span<double> source_w_m3{};  ///< heat generated in each layer, to be filled; empty where it generates none
};

/// Fills the values at an instant for the facets first, first + 1, ... of the batch, as many as
/// values.front.absorbed_w_m2 has. It is called from several threads at once, and for any facets in any order of time.
using Forcing = std::function<void(Instant, std::size_t first, ForcingValues& values)>;

/// A forcing for the facets first, first + 1, ..., first + count - 1 of a batch alone, of which what does not change
/// with time has been worked out: it is asked for once before a group of facets is advanced.
using GroupForcing = std::function<Forcing(std::size_t first, std::size_t count)>;

/// The same forcing for all groups; `forcing` has to live as long.
inline GroupForcing for_all_groups(const Forcing& forcing) {
  return [&forcing](std::size_t, std::size_t) -> Forcing { return Forcing(std::cref(forcing)); };
}

/// Facets of one construction that are advanced side by side. Neighbours in the batch share their time steps, so facets
/// with similar forcing (the same shadows at the same times) should stand together.
struct Batch {
  Construction construction;
  std::size_t facets = 0;
  std::vector<double> up;  ///< per facet: vertical component of the outward normal, for tarp; empty: all vertical, 0
};

/// The times of a run. Outputs rise; times outside [start, end] are ignored.
struct Timeline {
  double start_s = 0.0, end_s = 0.0;
  std::vector<double> outputs_s;  ///< steps end here
  std::vector<double> breaks_s;   ///< and here
  /// Further outputs, of Runs::one alone, at which steps need not end: within a step, the surface temperature is the
  /// parabola through both its ends and the stage between them. The error is of third order, as that of one step.
  std::vector<double> between_s{};
  /// Outputs that follow a break sooner than this do not set the first size of the cells (solve.cpp); their errors
  /// count as those of all others.
  double least_lag_s = 0.0;
};

}  // namespace radiometry::heat
