// SPDX-License-Identifier: Apache-2.0
#pragma once

// Run time and realised error of a study at each tolerance: a sample of its designs, evaluated from loose to tight.

#include "apps/study/design/evaluator.h"

namespace study {

struct AccuracyRow {
  double tolerance = 0.0;
  double promised = 0.0;       ///< largest value of the column `error`
  double realised = 0.0;       ///< largest difference of a metric from the reference, as a tolerance counts it
  double us_per_design = 0.0;  ///< time of one thread, without the first design
};

struct AccuracyTable {
  std::vector<AccuracyRow> rows;  ///< 1e-2 ... 1e-9, or to the decade before the reference
  double reference = 1e-10;       ///< tolerance of the rows that these are compared with
  double reference_error = 0.0;   ///< largest value of their own column `error`; NaN where no design has one
  std::int64_t designs = 0;       ///< number in the sample
};

/// True when a difference is larger than the promises of both sides allow. A row without an error promises that it is
/// exact.
bool broken(const AccuracyTable& table, const AccuracyRow& row);

/// The distance of a metric from its true value as a tolerance counts it: absolute where its unit is plain and it is at
/// most 1, else relative. 0 where both are NaN or equal.
double metric_error(double value, double truth, bool plain);

/// Up to 64 designs spread over the study, fewer where they would take more than about `seconds`. Throws what the
/// evaluator throws.
AccuracyTable accuracy_table(const Study& study, double seconds);

}  // namespace study
