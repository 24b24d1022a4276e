// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/design_sensitivity.h"

#include <algorithm>

#include "mtf/parallel.h"
#include "mtf/work/stopwatch.h"

namespace study {

std::shared_ptr<Evaluator> EvaluatorPool::take() {
  std::unique_ptr<Evaluator> one;
  {
    const std::lock_guard guard(lock_);
    if (!free_.empty()) {
      one = std::move(free_.back());
      free_.pop_back();
    }
  }
  if (!one) one = std::make_unique<Evaluator>(study_);
  return {one.release(), [this](Evaluator* back) {
            std::unique_ptr<Evaluator> owned(back);
            const std::lock_guard guard(lock_);
            free_.push_back(std::move(owned));
          }};
}

std::int64_t index_samples(const Study& study) {
  constexpr std::int64_t most = 4096;
  const auto points = std::max<std::int64_t>(most, study.designs / 4);
  return std::min(most, points / static_cast<std::int64_t>(study.axes.size() + 2));
}

namespace {
constexpr double kSeconds = 10.0;  // for indices, about
constexpr std::int64_t kLeastSamples = 16;
}  // namespace

StudyIndices study_indices(const std::shared_ptr<const Study>& study, const std::vector<Column>& columns, int threads,
                           const std::function<void(double)>& done) {
  StudyIndices result{.samples = index_samples(*study)};
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].role == Column::Role::metric || columns[c].role == Column::Role::objective)
      result.columns.push_back(c);
  EvaluatorPool pool(study);
  // Range models take a hundred milliseconds a design: then as many as some seconds allow.
  {
    const auto evaluator = pool.take();
    std::vector<double> values(study->axes.size()), row(columns.size());
    design_at(*study, study->designs / 2, values);
    evaluator->evaluate_at(values, row);  // reads what is read once
    constexpr double kElsewhere = 0.37;   // a design that shares little with the first
    design_at_quantiles(*study, std::vector<double>(values.size(), kElsewhere), values);
    const mtf::Stopwatch watch;
    evaluator->evaluate_at(values, row);
    const double each = watch.seconds() / mtf::threads_of(threads);
    const double points = kSeconds / each / static_cast<double>(study->axes.size() + 2);
    result.samples =
        std::min(result.samples, std::max(kLeastSamples, static_cast<std::int64_t>(std::min(points, 1e9))));
  }
  const auto make = [&]() -> PointMaker {
    const std::size_t axes = study->axes.size(), width = columns.size();
    return [&, evaluator = pool.take(), values = std::vector<double>(axes), row = std::vector<double>(width)](
               std::span<const double> unit, std::span<double> results) mutable {
      design_at_quantiles(*study, unit, values);
      evaluator->evaluate_at(values, row);
      for (std::size_t r = 0; r < results.size(); ++r) results[r] = row[result.columns[r]];
    };
  };
  result.indices = sensitivity_indices({.parameters = study->axes.size(),
                                        .results = result.columns.size(),
                                        .samples = result.samples,
                                        .seed = study->seed,
                                        .threads = threads,
                                        .make = make,
                                        .done = done});
  return result;
}

}  // namespace study
