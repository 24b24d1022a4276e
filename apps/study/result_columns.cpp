// SPDX-License-Identifier: Apache-2.0
#include "apps/study/result_columns.h"

#include <algorithm>
#include <limits>
#include <map>
#include <mutex>

#include "apps/study/design/variant_sensor.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"

namespace study {
namespace {

/// The column that shows an objective: that of its metric or parameter, else its own. Throws RuntimeError when there is
/// none (columns of another study).
std::size_t objective_column(const Study& study, const std::vector<Column>& columns, std::size_t objective) {
  const Expression& expression = study.objectives[objective].expression;
  const auto named = [&](const std::string& name, Column::Role role) -> std::optional<std::size_t> {
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (columns[c].name == name && columns[c].role == role) return c;
    return std::nullopt;
  };
  if (const auto own = named(study.objectives[objective].text, Column::Role::objective)) return *own;
  if (expression.slots().size() == 1) {
    const std::string& name = study.name_of(expression.slots()[0]);
    for (const Column::Role role : {Column::Role::metric, Column::Role::axis, Column::Role::link})
      if (const auto column = named(name, role)) return *column;
  }
  throw mtf::RuntimeError("objective " + study.objectives[objective].text + ": the table has no column of it");
}

}  // namespace

const char* role_word(Column::Role role) {
  constexpr std::array words{"axis", "link", "metric", "objective", "feasible", "yield", "error", "pareto"};
  return words[static_cast<std::size_t>(role)];
}

std::optional<std::size_t> column_of(const std::vector<Column>& columns, Column::Role role) {
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].role == role) return c;
  return std::nullopt;
}

struct SlotReader::Variants {
  std::mutex lock;
  std::map<std::vector<int>, std::vector<double>> base;  // in SI, by levels
};

SlotReader::SlotReader(std::shared_ptr<const Study> study) : study_(std::move(study)) {
  for (const Parameter& parameter : study_->parameters) base_.push_back(parameter.base * parameter.scale.si);
  for (const MetricInfo& metric : study_->metrics) metric_si_.push_back(unit_scale(metric.unit).si);
  const bool some_fixed = std::ranges::any_of(
      study_->parameters, [](const Parameter& p) { return p.role == Parameter::Role::fixed && !p.path.empty(); });
  if (some_fixed && study_->variants > 1) variants_ = std::make_shared<Variants>();
}

const std::vector<double>& SlotReader::fixed(std::span<const double> row) const {
  if (!variants_) return base_;
  std::vector<int> levels(study_->axes.size(), 0);
  for (std::size_t a = 0; a < levels.size(); ++a) {
    const Axis& axis = study_->axes[a];
    if (axis.discrete()) levels[a] = static_cast<int>(std::ranges::find(axis.values, row[a]) - axis.values.begin());
  }
  const std::lock_guard guard(variants_->lock);
  const auto found = variants_->base.find(levels);
  if (found != variants_->base.end()) return found->second;
  std::vector<double> values = load_variant(*study_, levels).base;
  values.resize(base_.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t p = 0; p < values.size(); ++p) {
    const Parameter& parameter = study_->parameters[p];
    values[p] = (parameter.path.empty() ? parameter.base : values[p]) * parameter.scale.si;
  }
  return variants_->base.emplace(levels, std::move(values)).first->second;
}

void SlotReader::read(std::span<const double> row, std::span<double> slots) const {
  const std::vector<double>& base = fixed(row);
  std::copy(base.begin(), base.end(), slots.begin());
  std::size_t column = 0;
  const auto take = [&](int parameter) {
    const auto p = static_cast<std::size_t>(parameter);
    slots[p] = row[column++] * study_->parameters[p].scale.si;
  };
  for (const Axis& axis : study_->axes) take(axis.parameter);
  for (const Link& link : study_->links) take(link.parameter);
  for (std::size_t m = 0; m < metric_si_.size(); ++m) slots[base.size() + m] = row[column++] * metric_si_[m];
}

TallyJob tally_job(std::shared_ptr<const Study> study, const std::vector<Column>& columns) {
  TallyJob job{.columns = columns.size(),
               .feasible = column_of(columns, Column::Role::feasible),
               .error = column_of(columns, Column::Role::error),
               .yield = column_of(columns, Column::Role::yield)};
  for (std::size_t o = 0; o < study->objectives.size(); ++o)
    job.goals.push_back({objective_column(*study, columns, o), study->objectives[o].maximize});
  for (const Constraint& constraint : study->constraints) job.limits.push_back({constraint.less, constraint.strict});
  job.sides = [study, reader = SlotReader(study)](std::span<const double> row, std::span<ConstraintValues> sides) {
    std::vector<double> slots(study->slots());
    reader.read(row, slots);
    for (std::size_t k = 0; k < sides.size(); ++k)
      sides[k] = {study->constraints[k].left.evaluate<double>(slots),
                  study->constraints[k].right.evaluate<double>(slots)};
  };
  return job;
}

std::vector<Column> file_columns(const Study& study) {
  std::vector<Column> columns = columns_of(study);
  if (study.objectives.size() > 1)
    columns.push_back({"pareto", "",
                       "1 for a design of the Pareto front: feasible, and no feasible one is as good in all objectives "
                       "and better in one",
                       "study file", Column::Role::pareto});
  return columns;
}

std::vector<TableColumn> table_columns(const Study& study, const std::vector<Column>& columns) {
  std::vector<TableColumn> table;
  for (const Column& column : columns) table.push_back({column.name, {}});
  for (std::size_t a = 0; a < study.axes.size(); ++a) {
    const Axis& axis = study.axes[a];
    bool indices = axis.discrete();
    for (std::size_t i = 0; indices && i < axis.values.size(); ++i) indices = axis.values[i] == static_cast<double>(i);
    if (indices) table[a].levels = axis.levels;
  }
  return table;
}

std::string columns_csv(const std::vector<Column>& columns) {
  std::string text = "column,unit,definition\ndesign,,\"number of the design, from 0\"\n";
  for (const Column& column : columns)
    text += mtf::io::csv_field(column.name) + "," + mtf::io::csv_field(column.unit) + "," +
            mtf::io::csv_field(column.definition) + "\n";
  return text;
}

}  // namespace study
