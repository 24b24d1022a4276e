// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values at which the effect of a parameter vanishes with its first derivative. At a bound: a diffusion length towards
// 0 acts by its cube, a delay whose shift is the edge's own offset by its square. Inside the range, at a centre about
// which the effect is mirrored, exactly or nearly: an acceleration at 0, a defocus where it balances the spherical
// aberration of the file, a direction of motion along the normal of the only edge. There the covariance, which is made
// of first derivatives, shows no dependence on the parameter and no correlation with it, and a minimiser that has come
// to the point does not leave it. The interval of such a parameter comes from the likelihood itself
// (fit_intervals.cpp), those of its partners from their profiles.
//
// The information of the parameter alone, S(u) at the distance u from the point, shows this: it is constant where the
// effect grows in proportion, and falls with u^(2p - 2) where it grows as u^p.

#include <vector>

#include "calib/fit/confidence/some_blocks.h"

namespace calib {

struct FlatPoint {
  std::size_t parameter = 0;
  double at = 0.0;      ///< value of x there
  double side = 1.0;    ///< +1 when the fit, or the range, lies above it, -1 when below
  bool inside = false;  ///< a centre: the range goes on beyond it
  double off = 0.0;     ///< distance from it at which the effect is above the noise
  bool here = false;    ///< the present x differs from it by less than can be seen

  /// Returns x, or the place where the parameter acts if x is too near to the point.
  double off_point(double x) const;
};

/// For the parameters near a flat point at the solution; afterwards the problem is at the solution again. Costs a
/// few passes over the data for a parameter that a bound is near to or that has both signs, nothing for the others.
std::vector<FlatPoint> flat_points(const FitProblem& problem, const Solved& solved);

/// Where the effect of variable i, which has both signs or is a direction, may be mirrored: at 0, and where its
/// information, a parabola about such a centre, has its least value. The problem is at the solution again afterwards.
std::vector<double> possible_centres(SomeBlocks& some, std::size_t i);

/// Takes a parameter at its flat point out of the information: except for rounding, first derivatives tell nothing of
/// its correlation with the others there.
void set_apart(Solved& solved, std::span<const FlatPoint> flat);

}  // namespace calib
