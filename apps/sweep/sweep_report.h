// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is known of a finished sweep or optimisation, for people and as JSON.

#include <string>
#include <vector>

#include "apps/study/optimum/optimize.h"
#include "apps/study/statistics/accuracy.h"
#include "apps/study/statistics/indices.h"
#include "apps/study/statistics/tally.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/text/json.h"

namespace apps {

/// A design whose sensor file is written.
struct ChosenFile {
  std::int64_t design = 0;
  std::string file, why;
  std::string caution{};  ///< Evaluator::last_caution
};

/// Why most of the invalid designs are so that were looked at, in the words of the first of them.
struct InvalidCause {
  std::string text;                         ///< "" where none was met
  std::int64_t designs = 0, looked_at = 0;  ///< invalid for this cause, and for any
};

struct SweepReport {
  const SweepStudy* sweep = nullptr;
  const SweepRun* run = nullptr;
  const study::Tally* tally = nullptr;
  study::FrontPoints front;
  std::vector<std::string> gaps;                  ///< by column
  std::vector<std::vector<study::Limit>> limits;  ///< what keeps the best design of each objective from being better
  std::vector<ChosenFile> chosen;
  InvalidCause cause;
  std::int64_t gradient_design = 0;
  study::Gradient gradient;
  study::StudyIndices indices;
  study::AccuracyTable accuracy;
  std::vector<std::string> skipped;
  int threads = 1;
  double finish_seconds = 0.0;  ///< of tables, sensitivities and the accuracy against time
};

/// At most `most` points of the Pareto front, both ends among them, evenly spread over the front in the order of the
/// first objective, the best last.
std::vector<std::size_t> spread_over_front(const study::FrontPoints& front, std::size_t most);

/// True when every design is invalid: there is nothing to choose.
bool none_valid(const SweepReport& report);

/// Constraints that a row does not meet: indices.
std::vector<std::size_t> violated_constraints(const SweepReport& report, std::span<const double> row);

/// A limit of an optimum, or of the best design of a sweep, which has no gain.
Json limit_json(const study::Limit& limit);

/// sweep.json.
Json to_json(const SweepReport& report);

/// What the command says, for people.
std::string sweep_summary(const SweepReport& report);

/// One optimisation of a study.
struct OptimizedGoal {
  std::string name;  ///< "maximize niirs_giqe5", "1 x maximize niirs_giqe5 + 0.2 x minimize cost"
  study::OptimizeOptions options;
  study::OptimizeOutcome outcome;
  std::string file;  ///< of the sensor that was written; "" = none
};

std::string optimize_table(const study::Study& study, const std::vector<OptimizedGoal>& goals);
std::string optimize_json(const study::Study& study, const std::vector<OptimizedGoal>& goals);

}  // namespace apps
