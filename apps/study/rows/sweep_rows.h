// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rows of a study's designs, with the yield of what is built: the share of draws about the design that meet all
// constraints. The draws are common random numbers, the same for every design, so that yields of neighbours differ by
// the designs and not by luck; each is a function of (seed, draw, parameter), by counter.

#include <memory>

#include "apps/study/design/evaluator.h"
#include "apps/study/result_columns.h"
#include "apps/study/rows/row_file.h"

namespace study {

/// Makes the row of a design with its yield. Each thread has one of its own.
class DesignRows {
 public:
  DesignRows(std::shared_ptr<const Study> study, std::shared_ptr<const std::vector<double>> draws);
  void operator()(std::int64_t design, std::span<double> row);
  /// Draws about the last design that no sensor can be, as a jitter below 0. They count as bad.
  std::int64_t impossible() const { return impossible_; }

 private:
  double yield_of(std::span<const double> row);

  std::shared_ptr<const Study> study_;
  std::shared_ptr<const std::vector<double>> draws_;
  Evaluator evaluator_;
  SlotReader reader_;
  std::optional<std::size_t> feasible_, yield_;
  std::vector<double> axis_values_, built_row_, shift_, slots_;
  std::int64_t design_ = 0, impossible_ = 0;
};

/// Standard deviation of a share p of n `draws`, above 0 where all or none of them are good:
/// sqrt(q (1 - q) / (n + 1)), q = (p n + 1/2) / (n + 1), after Agresti and Coull, American Statistician 52 (1998) 119,
/// for one standard deviation.
double yield_error(double yield, int draws);

/// DesignRows::impossible of a design, as a share of its draws.
double impossible_share(const std::shared_ptr<const Study>& study, std::int64_t design);

/// A maker of rows for each thread.
std::function<RowMaker()> row_makers(const std::shared_ptr<const Study>& study);

/// What rows of the study are kept under: they are those of this study at this tolerance, made by this version.
RowLayout layout_of(const Study& study, const std::vector<Column>& columns);

}  // namespace study
