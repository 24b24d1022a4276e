// SPDX-License-Identifier: Apache-2.0
#pragma once

// The inner loop of pupil quadrature: exp(2 pi i D) - 1 at many points of a chord, D a polynomial along it.

#include <cstddef>

namespace mtf {

/// re[k] + i im[k] = weight[k] (exp(2 pi i D(w[k])) - 1), D(w) = sum of coefficient[j] w^j, j = 0 .. degree, in cycles,
/// |D| < 2^50. Relative error of a few 2^-53 of the turn, |exp - 1|, so that a small D loses no digits.
void weighted_turns(const double* coefficient, int degree, const double* w, const double* weight, std::size_t n,
                    double* re, double* im);

}  // namespace mtf
