// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/design_sensitivity.h"

#include <algorithm>
#include <cmath>

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

namespace {

bool varies(const Axis& axis) { return axis.values.empty() ? axis.to != axis.from : axis.values.size() > 1; }

/// At most 4096, and about as many points as a quarter of the designs, or 4096.
std::int64_t index_samples(const Study& study, std::size_t parameters) {
  constexpr std::int64_t most = 4096;
  const auto points = std::max<std::int64_t>(most, study.designs / 4);
  return std::min(most, points / static_cast<std::int64_t>(parameters + 2));
}

}  // namespace

StudyIndices study_indices(const std::shared_ptr<const Study>& study, const std::vector<Column>& columns,
                           double seconds, int threads, const std::function<void(double)>& done) {
  StudyIndices result;
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].role == Column::Role::metric || columns[c].role == Column::Role::objective)
      result.columns.push_back(c);
  const std::size_t axes = study->axes.size();
  std::vector<std::size_t> varying;
  for (std::size_t a = 0; a < axes; ++a)
    if (varies(study->axes[a])) varying.push_back(a);
  EvaluatorPool pool(study);
  const auto make = [&]() -> PointMaker {
    return
        [&, evaluator = pool.take(), at = std::vector<double>(axes, 0.5), values = std::vector<double>(axes),
         row = std::vector<double>(columns.size())](std::span<const double> unit, std::span<double> results) mutable {
          for (std::size_t j = 0; j < varying.size(); ++j) at[varying[j]] = unit[j];
          design_at_quantiles(*study, at, values);
          evaluator->evaluate_at(values, row);
          for (std::size_t r = 0; r < results.size(); ++r) results[r] = row[result.columns[r]];
        };
  };
  const mtf::Stopwatch watch;
  Indices found = sensitivity_indices({.parameters = varying.size(),
                                       .results = result.columns.size(),
                                       .samples = varying.empty() ? 0 : index_samples(*study, varying.size()),
                                       .seed = study->seed,
                                       .threads = threads,
                                       .make = make,
                                       .done = done,
                                       .go_on = [&] { return watch.seconds() < seconds; }});
  // An axis of one value has no part in what varies; where nothing varies there are no shares.
  for (std::vector<Index>& of : found.of) {
    const bool none = varying.empty() || std::isnan(of.front().total);
    std::vector<Index> all(axes, none ? Index{NAN, NAN, NAN, NAN} : Index{});
    for (std::size_t j = 0; j < varying.size(); ++j) all[varying[j]] = of[j];
    of = std::move(all);
  }
  result.indices = std::move(found);
  return result;
}

}  // namespace study
