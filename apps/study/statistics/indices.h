// SPDX-License-Identifier: Apache-2.0
#pragma once

// Variance-based sensitivities: which share of a result's variance over the whole range of designs is due to one
// parameter alone (first order), and which vanishes with it (total). Two sets of n independent random points A and B
// and, for each parameter j, the points AB_j of A with column j of B (Saltelli et al., Comput. Phys. Commun. 181, 259,
// 2010, table 2):
//   first order   S_j = mean(f(B) (f(AB_j) - f(A))) / V
//   total         T_j = mean((f(A) - f(AB_j))^2) / (2 V)      (Jansen, Comput. Phys. Commun. 117, 35, 1999)
// f is taken about its mean first, which changes no expectation and steadies S. The standard errors are those of a
// bootstrap over the points.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "apps/study/design/evaluator.h"

namespace study {

/// The results at a point of the unit cube; NaN for a point that has none.
using PointMaker = std::function<void(std::span<const double> unit, std::span<double> results)>;

struct IndexJob {
  std::size_t parameters = 0, results = 0;
  std::int64_t samples = 1024;  ///< n; points taken: n x (parameters + 2)
  std::uint64_t seed = 0;
  int threads = 0;                     ///< 0 = all cores
  std::function<PointMaker()> make;    ///< called once for each piece of work
  std::function<void(double)> done{};  ///< share of the work, one call at a time; may be empty
  std::function<bool()> go_on{};       ///< asked by each piece of work but the first; no ends it. May be empty
};

/// A share with its standard error.
struct Index {
  double first = 0.0, first_sd = 0.0, total = 0.0, total_sd = 0.0;
};

struct Indices {
  /// [result][parameter]; NaN for a result that does not vary, or that fewer than half of the samples have.
  std::vector<std::vector<Index>> of;
  std::int64_t samples = 0;        ///< that were taken: all of the job's, or those before `go_on` said no
  std::vector<std::int64_t> used;  ///< of these, by result: those with a number at A, B and all AB_j
};

/// The result is the same for any number of threads, where all samples are taken. Throws what `make` and the points
/// throw.
Indices sensitivity_indices(const IndexJob& job);

// How the results of a study move with its parameters: derivatives at one design, and shares of the variance over the
// ranges of all axes.

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
