// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the residuals of each set of data tell about the noise and about the model, at the solution.

#include "calib/fit/confidence/adequacy.h"
#include "calib/fit/fit_problem.h"

namespace calib {

struct ResidualTests {
  std::size_t count = 0;
  Adequacy adequacy;         ///< of an edge by pixels that do not share their noise
  NoiseCorrelation noise{};  ///< of an edge: what the errors take into account
  /// What the residuals of an edge share that is not its noise: most of them are errors of rounding or of tables.
  NoiseCorrelation left_out{};
  mtf::Image image;  ///< edges and spots: as in FitResiduals
};

/// One for each block. `noise_factor`: chi-square per degree of freedom of each.
std::vector<ResidualTests> test_residuals(const FitProblem& problem, std::span<const double> noise_factor);

std::vector<NoiseCorrelation> noise_of(std::span<const ResidualTests> tests);

}  // namespace calib
