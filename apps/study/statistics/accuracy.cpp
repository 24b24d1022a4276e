// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/accuracy.h"
#include "mtf/work/stopwatch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace study {
namespace {

constexpr std::int64_t kMostSampled = 64, kLeastSampled = 2;
constexpr int kLoosest = 2, kTightest = 9;  // decades

std::int64_t sample_design(const Study& study, std::int64_t count, std::int64_t i) {
  return count == 1 ? 0 : i * (study.designs - 1) / (count - 1);
}

Evaluator evaluator_at(const Study& study, double tolerance) {
  Study copy = study;
  copy.tolerance = tolerance;
  return Evaluator(std::make_shared<const Study>(std::move(copy)));
}

/// Rows of the sample, one after the other, and the time of a design.
std::vector<double> sample_rows(const Study& study, double tolerance, std::int64_t count, std::size_t columns,
                                double& us_per_design) {
  Evaluator evaluator = evaluator_at(study, tolerance);
  std::vector<double> rows(static_cast<std::size_t>(count) * columns);
  const auto row = [&](std::int64_t i) {
    evaluator.evaluate(sample_design(study, count, i),
                       std::span(rows).subspan(static_cast<std::size_t>(i) * columns, columns));
  };
  mtf::Stopwatch watch;
  row(0);
  if (count > 1) watch = mtf::Stopwatch();  // what is made once is no cost of a design
  for (std::int64_t i = 1; i < count; ++i) row(i);
  us_per_design = 1e6 * watch.seconds() / static_cast<double>(std::max<std::int64_t>(1, count - 1));
  return rows;
}

}  // namespace

double metric_error(double value, double truth, bool plain) {
  if (value == truth || (std::isnan(value) && std::isnan(truth))) return 0.0;
  if (std::isnan(value) || std::isnan(truth)) return std::numeric_limits<double>::infinity();
  const double difference = std::abs(value - truth);
  return plain && std::abs(truth) <= 1.0 ? difference : difference / std::abs(truth);
}

bool broken(const AccuracyTable& table, const AccuracyRow& row) {
  constexpr double kRounding = 1e-13;  // of metrics that are made of many numbers
  return row.realised > std::fmax(row.promised, 0.0) + std::fmax(table.reference_error, 0.0) + kRounding;
}

AccuracyTable accuracy_table(const Study& study, double seconds) {
  const std::vector<Column> columns = columns_of(study);
  AccuracyTable table;
  double us = 0.0;
  const std::int64_t few = std::min(kLeastSampled, study.designs);
  // Wavefronts by quadrature take seconds a design at tight tolerances: those that take too long are left out.
  int tightest = kLoosest;
  const mtf::Stopwatch probing;
  while (tightest < kTightest && probing.seconds() < 0.125 * seconds)
    sample_rows(study, std::pow(10.0, -++tightest), 1, columns.size(), us);
  if (tightest < kTightest) table.reference = std::pow(10.0, -tightest);
  const int last = tightest < kTightest ? tightest - 1 : kTightest;
  const mtf::Stopwatch watch;
  sample_rows(study, table.reference, few, columns.size(), us);
  // All decades together cost some four times what the tightest does.
  const double each = 4.0 * watch.seconds() / static_cast<double>(few);
  const auto fit = static_cast<std::int64_t>(std::min(seconds / each, static_cast<double>(kMostSampled)));
  table.designs = std::min(study.designs, std::max(kLeastSampled, fit));
  const std::vector<double> truth = sample_rows(study, table.reference, table.designs, columns.size(), us);
  table.reference_error = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (columns[i % columns.size()].role == Column::Role::error)
      table.reference_error = std::fmax(table.reference_error, truth[i]);
  for (int decade = kLoosest; decade <= last; ++decade) {
    AccuracyRow row{.tolerance = std::pow(10.0, -decade), .promised = std::numeric_limits<double>::quiet_NaN()};
    const std::vector<double> values =
        sample_rows(study, row.tolerance, table.designs, columns.size(), row.us_per_design);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Column& column = columns[i % columns.size()];
      if (column.role == Column::Role::error) row.promised = std::fmax(row.promised, values[i]);
      if (column.role == Column::Role::metric)
        row.realised = std::max(row.realised, metric_error(values[i], truth[i], column.unit.empty()));
    }
    table.rows.push_back(row);
  }
  return table;
}

}  // namespace study
