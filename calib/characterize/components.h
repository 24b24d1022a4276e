// SPDX-License-Identifier: Apache-2.0
#pragma once

// Components of variance with intervals. A component is a sum of mean squares with coefficients c_q of either sign. Its
// variance is 2 sum (c_q MS_q)^2 / dof_q; as a chi-square of few degrees of freedom is far from normal, its limits are
// those of modified large samples (N. Ting, R. K. Burdick, F. A. Graybill, S. Jeyaratnam, T.-F. C. Lu, J. Stat. Comput.
// Simul. 35, 135 (1990)): the distances from the estimate L to its limits are roots of quadratic forms in the mean
// squares, which are exact where one of these is alone. With p the positive and r the negative terms c_q MS_q,
//   low  = L - sqrt(sum G_p^2 p^2 + sum H_r^2 r^2 + sum G_pr p r),   G = 1 - dof / chi2(1 - a/2), H = dof / chi2(a/2) -
//   1 high = L + sqrt(sum H_p^2 p^2 + sum G_r^2 r^2 + sum H_pr p r),   G_pr, H_pr from quantiles of F
// They cover 94.5 to 95.6 % for all seven parts of cubes down to 3 x 8 x 8, where 1.96 standard deviations cover 73 to
// 94 %. Rounding and the truth may make a component negative; its value and limits are kept as they are.

#include <array>
#include <span>
#include <vector>

#include "radiometry/stages/noise/mean_squares.h"

namespace calib {

/// coefficient x mean square, with its degrees of freedom.
struct MeanSquareTerm {
  double coefficient = 0.0, mean_square = 0.0, dof = 1.0;
};

struct VarianceComponent {
  double variance = 0.0, sd = 0.0;
  double low95 = 0.0, high95 = 0.0;
  /// Standard deviation were the truth 0: the positive term of fewest degrees of freedom is then what the others tell.
  /// Unlike sd it is no smaller where that term came out small by chance, so it serves for tests and weights.
  double sd_of_zero = 0.0;

  /// The upper end of 95 %, where chance alone can put both ends below 0.
  double most() const;
};

/// Of the sum of the terms, which are independent.
VarianceComponent variance_component(std::span<const MeanSquareTerm> terms);

/// The terms of a part of the cube, and their sum.
std::vector<MeanSquareTerm> terms_of(const radiometry::MeanSquares& squares, radiometry::CubePart part,
                                     double factor = 1.0);
VarianceComponent variance_component(const radiometry::MeanSquares& squares, radiometry::CubePart part);

/// Adds the independent error of a number that was subtracted.
void widen(VarianceComponent& component, double sd);

/// Probability that chi-square of noise is at least as large.
double chi_square_tail(double chi2, double dof);
/// Median of chi-square over its degrees of freedom (Wilson and Hilferty, 1931).
double chi_square_median(double dof);
/// Probability that a number of events of which `mean` are expected is at least `count`, and the 95 % limits of that
/// mean where `count` occurred.
double poisson_tail(double count, double mean);
std::array<double, 2> poisson_limits(double count);
/// The ratio of two mean squares of noise that is not exceeded with the probability p; with dof1 = 1 that of Student's
/// t squared.
double f_quantile(double p, double dof1, double dof2);

}  // namespace calib
