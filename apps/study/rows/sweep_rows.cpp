// SPDX-License-Identifier: Apache-2.0
#include "apps/study/rows/sweep_rows.h"

#include <cmath>

#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"
#include "radiometry/stages/noise/poisson.h"
#include "radiometry/stages/noise/random.h"

namespace study {
namespace {

constexpr int kRowLayout = 1;  // grows when rows change their meaning

/// Draws of what is built, in units of the spread: standard normal numbers, or uniform ones in (-1, 1).
/// [draw][as_built]
std::vector<double> as_built_draws(const Study& study) {
  std::vector<double> draws;
  for (int d = 0; d < study.draws; ++d)
    for (std::size_t k = 0; k < study.as_built.size(); ++k) {
      const radiometry::Bits128 bits = radiometry::philox({static_cast<std::uint32_t>(d), static_cast<std::uint32_t>(k),
                                                           0, static_cast<std::uint32_t>(Purpose::as_built)},
                                                          study.seed);
      const radiometry::Uniform u = radiometry::uniform(bits[0], bits[1]);
      draws.push_back(study.as_built[k].law == AsBuilt::Law::normal ? radiometry::normal_quantile(u) : u.u - u.rest);
    }
  return draws;
}

}  // namespace

DesignRows::DesignRows(std::shared_ptr<const Study> study, std::shared_ptr<const std::vector<double>> draws)
    : study_(study),
      draws_(std::move(draws)),
      evaluator_(study),
      reader_(study),
      axis_values_(study->axes.size()),
      shift_(study->as_built.size()),
      slots_(study->slots()) {
  const std::vector<Column> columns = columns_of(*study_);
  feasible_ = column_of(columns, Column::Role::feasible);
  yield_ = column_of(columns, Column::Role::yield);
  built_row_.resize(columns.size());
}

void DesignRows::operator()(std::int64_t design, std::span<double> row) {
  evaluator_.evaluate(design, row);
  if (!yield_) return;
  design_ = design;
  row[*yield_] = yield_of(row);
}

double DesignRows::yield_of(std::span<const double> row) {
  design_at(*study_, design_, axis_values_);
  reader_.read(row, slots_);
  std::int64_t good = 0;
  impossible_ = 0;
  for (int d = 0; d < study_->draws; ++d) {
    for (std::size_t k = 0; k < shift_.size(); ++k) {
      const AsBuilt& built = study_->as_built[k];
      const auto p = static_cast<std::size_t>(built.parameter);
      const double value = slots_[p] / study_->parameters[p].scale.si;
      const double spread = built.relative ? built.spread * std::abs(value) : built.spread;
      shift_[k] = spread * (*draws_)[static_cast<std::size_t>(d) * shift_.size() + k];
    }
    evaluator_.evaluate_at(axis_values_, built_row_, shift_);
    good += (feasible_ ? built_row_[*feasible_] == 1.0 : evaluator_.last_valid()) ? 1 : 0;
    impossible_ += evaluator_.last_problem().empty() ? 0 : 1;
  }
  return static_cast<double>(good) / study_->draws;
}

double yield_error(double yield, int draws) {
  const double n = draws + 1.0, share = (yield * draws + 0.5) / n;
  return std::sqrt(share * (1.0 - share) / n);
}

double impossible_share(const std::shared_ptr<const Study>& study, std::int64_t design) {
  DesignRows rows(study, std::make_shared<const std::vector<double>>(as_built_draws(*study)));
  std::vector<double> row(columns_of(*study).size());
  rows(design, row);
  return static_cast<double>(rows.impossible()) / study->draws;
}

std::function<RowMaker()> row_makers(const std::shared_ptr<const Study>& study) {
  const auto draws = std::make_shared<const std::vector<double>>(as_built_draws(*study));
  return [study, draws]() -> RowMaker {
    const auto rows = std::make_shared<DesignRows>(study, draws);
    return [rows](std::int64_t design, std::span<double> row) { (*rows)(design, row); };
  };
}

RowLayout layout_of(const Study& study, const std::vector<Column>& columns) {
  std::string text = "row layout " + std::to_string(kRowLayout) + "\nversion " + mtf::version + " " + mtf::git_commit +
                     "\nstudy " + study.sha256 + "\ntolerance " + mtf::io::number_text(study.tolerance) + "\ndesigns " +
                     std::to_string(study.designs) + "\n";
  for (const Column& column : columns) text += column.name + "\t" + column.unit + "\n";
  return {mtf::io::sha256_hex(text), static_cast<std::int64_t>(columns.size())};
}

}  // namespace study
