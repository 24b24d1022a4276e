// SPDX-License-Identifier: Apache-2.0
#include "apps/study/judge.h"

#include "mtf/error.h"

namespace study {

std::size_t objective_column(const Study& study, const std::vector<Column>& columns, std::size_t objective) {
  const Expression& expression = study.objectives[objective].expression;
  const auto named = [&](const std::string& name, Column::Role role) -> std::optional<std::size_t> {
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (columns[c].name == name && columns[c].role == role) return c;
    return std::nullopt;
  };
  if (const auto own = named(study.objectives[objective].text, Column::Role::objective)) return *own;
  if (expression.slots().size() == 1) {
    const auto slot = static_cast<std::size_t>(expression.slots()[0]);
    const bool metric = slot >= study.parameters.size();
    const std::string& name = metric ? study.metrics[slot - study.parameters.size()].name : study.parameters[slot].name;
    for (const Column::Role role : {Column::Role::metric, Column::Role::axis, Column::Role::link})
      if (const auto column = named(name, role)) return *column;
  }
  throw mtf::RuntimeError("objective " + study.objectives[objective].text + ": the table has no column of it");
}

std::optional<std::size_t> column_of(const std::vector<Column>& columns, Column::Role role) {
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].role == role) return c;
  return std::nullopt;
}

void slots_of(const Study& study, std::span<const double> row, std::span<double> slots) {
  for (std::size_t p = 0; p < study.parameters.size(); ++p)
    slots[p] = study.parameters[p].base * study.parameters[p].scale.si;
  std::size_t column = 0;
  const auto take = [&](int parameter) {
    const auto p = static_cast<std::size_t>(parameter);
    slots[p] = row[column++] * study.parameters[p].scale.si;
  };
  for (const Axis& axis : study.axes) take(axis.parameter);
  for (const Link& link : study.links) take(link.parameter);
  for (std::size_t m = 0; m < study.metrics.size(); ++m)
    slots[study.parameters.size() + m] = row[column++] * unit_scale(study.metrics[m].unit).si;
}

TallyJob tally_job(std::shared_ptr<const Study> study, const std::vector<Column>& columns) {
  TallyJob job{.columns = columns.size(),
               .feasible = column_of(columns, Column::Role::feasible),
               .error = column_of(columns, Column::Role::error),
               .yield = column_of(columns, Column::Role::yield)};
  for (std::size_t o = 0; o < study->objectives.size(); ++o)
    job.goals.push_back({objective_column(*study, columns, o), study->objectives[o].maximize});
  for (const Constraint& constraint : study->constraints) job.limits.push_back({constraint.less, constraint.strict});
  job.sides = [study](std::span<const double> row, std::span<Sides> sides) {
    std::vector<double> slots(study->slots());
    slots_of(*study, row, slots);
    for (std::size_t k = 0; k < sides.size(); ++k)
      sides[k] = {study->constraints[k].left.evaluate<double>(slots),
                  study->constraints[k].right.evaluate<double>(slots)};
  };
  return job;
}

std::vector<TableColumn> table_columns(const std::vector<Column>& columns) {
  std::vector<TableColumn> table;
  for (const Column& column : columns) table.push_back({column.name, column.levels});
  return table;
}

}  // namespace study
