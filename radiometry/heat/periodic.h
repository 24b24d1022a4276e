// SPDX-License-Identifier: Apache-2.0
#pragma once

// The state that repeats after a day (or another period): the start of a run. A start at a uniform temperature is wrong
// for thick bodies, whose slowest mode decays with the time L^2 / (alpha pi^2 / 4): 3.9 days for 1 m of rock.
//
// 1. The mean temperature of every facet balances the mean forcing (one equation with T^4).
// 2. About it the balance is linear: the deviation of the forcing from the mean, as a Fourier series, is multiplied by
//      1 / (h + 4 epsilon sigma T^3 + Y(omega)),
//    Y the admittance of the construction below the surface, by elimination on the same grid.
// 3. Days are run with the full balance. The state is off by (1 - M)^-1 r, r what a day changes and M what is left of
//    a small change after a day: for a slow body many times r, the days of its time constant. Newton's step takes
//    M = exp(-A P), A the linear system of the mean slopes and P the period, with the approximation
//    1 / (1 - exp(-x)) = 1 + 2 / (x (x + 2)): exact for slow and fast modes, within 9 % between. Slopes that change
//    over the day, by the wind and with the temperature, leave a few per cent more, up to half where the wind changes
//    the film a hundredfold. A state is judged by the step, not by what a day changes: where steps become smaller by
//    the ratio p from day to day, what is left after one is at most p / (1 - p) of it.

#include "radiometry/heat/solver.h"

namespace radiometry::heat {

/// W/m2/K of each facet: the mean slope of what its surfaces lose.
struct LossSlopes {
  std::vector<double> front, back;  ///< back: 0 but for sheets
};

struct PeriodicStart {
  State state;
  double error_k = 0.0;  ///< no node of any facet is farther from the state that repeats
  int periods = 0;       ///< periods run
  Run last;              ///< the last of them, with its outputs; it began before the last step
  LossSlopes slopes;
};

/// The timeline is one period. Ends when the error is below `error_k`, or after `most_periods`, so the error has to be
/// checked. Throws UsageError for a construction whose mean temperature is not determined: neither emission, convection
/// nor an inside temperature. `sink` gets the outputs of every period that is run, one after the other.
PeriodicStart periodic_start(const Plan& plan, const Forcing& forcing, const Timeline& period, double error_k,
                             int most_periods = 12, int threads = 1);
PeriodicStart periodic_start(const Plan& plan, const GroupForcing& forcing, const Timeline& period, double error_k,
                             int most_periods = 12, int threads = 1, Runs runs = Runs::three,
                             const OutputSink& sink = {});

/// Newton's step: what to add to every node of `begin` after a period has brought it to `end`.
State newton_step(const Plan& plan, const LossSlopes& slopes, const State& begin, const State& end, int threads = 1);

}  // namespace radiometry::heat
