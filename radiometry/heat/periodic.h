// SPDX-License-Identifier: Apache-2.0
#pragma once

// The state that repeats after a day (or another period): the start of a run. A start at a uniform temperature is wrong
// for thick bodies, whose slowest mode decays with the time L^2 / (alpha pi^2 / 4): 3.9 days for 1 m of rock.
//
// 1. The mean temperature of every facet balances the mean forcing (one equation with T^4).
// 2. About it the balance is linear: the deviation of the forcing from the mean, as a Fourier series, is multiplied by
//      1 / (h + 4 epsilon sigma T^3 + Y(omega)),
//    Y the admittance of the construction below the surface, by elimination on the same grid.
// 3. Days are run with the full balance. What a day changes, r, is corrected by (1 - exp(-A P))^-1 r, A the linear
//    system and P the period, with the approximation 1 / (1 - exp(-x)) = 1 + 2 / (x (x + 2)): exact for slow and fast
//    modes, within 9 % between. So a few days are enough however slow the body is.

#include "radiometry/heat/solver.h"

namespace radiometry::heat {

struct PeriodicStart {
  State state;
  double residual_k = 0.0;  ///< the largest change of any node over the last period; it is corrected in the state
  int periods = 0;          ///< periods run
  Run last;                 ///< the last of them, with its outputs; it began before the last correction
};

/// The timeline is one period. Ends when a period changes no node of any facet by more than
/// `residual_k`, or after `most_periods`, so the residual has to be checked. Throws UsageError for a construction
/// whose mean temperature is not determined: neither emission, convection nor an inside temperature. `sink` gets the
/// outputs of every period that is run, one after the other.
PeriodicStart periodic_start(const Plan& plan, const Forcing& forcing, const Timeline& period, double residual_k,
                             int most_periods = 8, int threads = 1);
PeriodicStart periodic_start(const Plan& plan, const GroupForcing& forcing, const Timeline& period, double residual_k,
                             int most_periods = 8, int threads = 1, Runs runs = Runs::three,
                             const OutputSink& sink = {});

/// Step 3 alone: the start to try after a period has brought `begin` to `end`. The forcing is that of the period, which
/// the timeline is.
State corrected_start(const Plan& plan, const GroupForcing& forcing, const Timeline& period, const State& begin,
                      const State& end, int threads = 1);

}  // namespace radiometry::heat
