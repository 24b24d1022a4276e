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
  std::int64_t samples = 0;            ///< number in each of the two sets
  std::vector<std::size_t> columns{};  ///< columns of the results: metrics and objectives
  Indices indices{};                   ///< [result][axis]
};

/// The number of samples that a study gets: at most 4096 and about as many points as a quarter of its designs, or 4096.
std::int64_t index_samples(const Study& study);

/// Every axis is sampled at its quantiles (design_at_quantiles), independent of each other. `done` as in IndexJob.
StudyIndices study_indices(const std::shared_ptr<const Study>& study, const std::vector<Column>& columns, int threads,
                           const std::function<void(double)>& done);

}  // namespace study
