// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the results of a study move with its parameters: derivatives at one design, and shares of the variance over the
// ranges of all axes.

#include <memory>
#include <mutex>

#include "apps/study/design/evaluator.h"
#include "apps/study/statistics/indices.h"

namespace study {

/// Evaluators that wait for work, so that pieces of work in any thread share a few.
class EvaluatorPool {
 public:
  explicit EvaluatorPool(std::shared_ptr<const Study> study) : study_(std::move(study)) {}

  /// Lends an evaluator, which goes back to the pool with the last copy of the pointer. The pool has to outlive it.
  std::shared_ptr<Evaluator> take();

 private:
  std::shared_ptr<const Study> study_;
  std::mutex lock_;
  std::vector<std::unique_ptr<Evaluator>> free_;
};

struct StudyIndices {
  std::vector<std::size_t> columns{};  ///< columns of the results: metrics and objectives
  Indices indices{};                   ///< [result][axis]
};

/// Every axis that has more than one value is sampled at its quantiles (design_at_quantiles), independent of each
/// other; the share of the others is 0. Ends after about `seconds`, with the samples taken until then. `done` as in
/// IndexJob.
StudyIndices study_indices(const std::shared_ptr<const Study>& study, const std::vector<Column>& columns,
                           double seconds, int threads, const std::function<void(double)>& done);

}  // namespace study
