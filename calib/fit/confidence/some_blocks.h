// SPDX-License-Identifier: Apache-2.0
#pragma once

// Of a fit of many sets of data a part, evenly taken: it shows how the data depend on the variables at a part of the
// cost, as the many edges of a chart see the same parameters. Priors are made as much weaker as the data are fewer, so
// that chi-square and information are those of all data times the share.

#include "calib/fit/fit_report.h"

namespace calib {

struct SomeBlocks {
  FitProblem problem;
  Solved solved;       ///< noise and tests of these blocks; references, information and what is determined are of all
  double share = 1.0;  ///< of all blocks
  /// Of each variable: it acts differently over the field (Sensors), and so many places of the image tell most of its
  /// mirrors apart, or there are not all blocks.
  std::vector<bool> told_apart{};
};

/// A few dozen blocks; all where there are no more.
SomeBlocks some_blocks(const FitProblem& problem, const Solved& solved);

}  // namespace calib
