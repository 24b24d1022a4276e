// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a row of results to the values of the study's constraints and objectives, and the columns of the files.

#include <memory>

#include "apps/study/design/evaluator.h"
#include "apps/study/statistics/tally.h"

namespace study {

/// "axis", "link", "metric", ...
const char* role_word(Column::Role role);

/// The column of a role that a table has once (feasible, yield, error).
std::optional<std::size_t> column_of(const std::vector<Column>& columns, Column::Role role);

/// Values of all slots of expressions in SI, from a row. Numbers that no column has are those of the row's variant of
/// the sensor. Safe to use from several threads.
class SlotReader {
 public:
  explicit SlotReader(std::shared_ptr<const Study> study);
  /// slots.size() = Study::slots(). Throws as load_variant.
  void read(std::span<const double> row, std::span<double> slots) const;

 private:
  struct Variants;
  const std::vector<double>& fixed(std::span<const double> row) const;

  std::shared_ptr<const Study> study_;
  std::vector<double> metric_si_;
  std::vector<double> base_;              // values of the base sensor, in SI
  std::shared_ptr<Variants> variants_{};  // the variants of the sensor, where there are several
};

/// What a tally needs to know of a study.
TallyJob tally_job(std::shared_ptr<const Study> study, const std::vector<Column>& columns);

/// The columns of designs.csv and designs.npy: those of a row, then `pareto` with two objectives or more.
std::vector<Column> file_columns(const Study& study);

/// The columns of a table. The values of a discrete axis that are no numbers stand there as words.
std::vector<TableColumn> table_columns(const Study& study, const std::vector<Column>& columns);

/// columns.csv: name, unit and definition of every column of designs.csv, a line each.
std::string columns_csv(const std::vector<Column>& columns);

}  // namespace study
