// SPDX-License-Identifier: Apache-2.0
#pragma once

// Other minima that the data do not tell from the best one. Where the OTF, as far as the data see it, is the same after
// a change of parameters, chi-square has a minimum at both places. The changes that are tried:
//   p -> -p             a parameter with both signs: a defocus, an acceleration; coma in a curve without phase
//   p -> 2 c - p        about another centre (flat_points.h): a defocus beside the file's own spherical aberration
//   several signs       at once: the wavefront (w020, w040) -> -(w020, w040), with all terms over the field of its even
//                       part, while odd ones (coma) keep theirs: W(p) -> -W(-p) leaves the OTF as it is
//   a turn              of a direction by 90 or 180 degrees, alone or with a sign: astigmatism
//   p <-> q             two squares by their effects: a footprint and a travel along it
// and each two of them together, but for those that many sets of data tell apart (some_blocks.h). Squares (variables.h)
// are even exactly and need no search.

#include "calib/fit/confidence/flat_points.h"
#include "calib/fit/fit_rounds.h"

namespace calib {

struct Mirror : FitPoint {
  double rise = 0.0;  ///< of chi-square above the best minimum, in units of the noise
};

/// Chi-square up to which another minimum is given beside the best one: the right one is left out in one of two hundred
/// draws at most, so that intervals about each of them hold the truth as often as they say.
inline constexpr double kToldApart_chi2 = 6.6;

/// Minima that differ in a parameter by more than half a standard deviation, lowest first. Where one is lower than the
/// best so far it becomes the solution, and `solved` is judged anew. `simpler`: the fit without the last unknown,
/// whose minima show where those of many sets of data are.
std::vector<Mirror> mirrored_minima(FitProblem& problem, Solved& solved, Solution& solution,
                                    std::span<const FitParameter> parameters, const MinimiseOptions& options,
                                    const FitResult* simpler = nullptr);

/// Gives the values at the other minima as `others` of the parameters and as `alternatives`. Intervals come first.
void report_mirrors(FitProblem& problem, const Solved& solved, std::span<const Mirror> mirrors,
                    std::span<const FlatPoint> flat, FitResult& result);

}  // namespace calib
