// SPDX-License-Identifier: Apache-2.0

// `mtf optimize`: the best design of a study.

#include <filesystem>

#include "apps/sweep/optimize_report.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"

namespace apps {
namespace {

std::string objective_name(const study::Objective& objective) {
  return (objective.maximize ? "maximize " : "minimize ") + objective.text;
}

OptimizedGoal one_objective(const study::Study& study, std::size_t which) {
  OptimizedGoal goal{objective_name(study.objectives[which]), {}, {}, {}};
  goal.options.weights.assign(study.objectives.size(), 0.0);
  goal.options.weights[which] = 1.0;
  return goal;
}

std::vector<OptimizedGoal> goals_of(const study::Study& study, const OptimizeCommandOptions& options) {
  const int choices = (options.weights.empty() ? 0 : 1) + (options.objective ? 1 : 0) + (options.each ? 1 : 0);
  if (choices > 1) throw mtf::UsageError("optimize: --weights, --objective and --each exclude each other; give one");
  const std::size_t count = study.objectives.size();
  if (count == 0)
    throw mtf::UsageError(study.file +
                          ": no objectives to optimise; add for example objectives = [\"maximize "
                          "mtf_nyquist\"]");
  std::vector<OptimizedGoal> goals;
  if (options.objective) {
    if (static_cast<std::size_t>(*options.objective) > count)
      throw mtf::UsageError("--objective: " + std::to_string(*options.objective) + ", but the study has " +
                            std::to_string(count) + (count == 1 ? " objective" : " objectives"));
    goals.push_back(one_objective(study, static_cast<std::size_t>(*options.objective) - 1));
  } else if (!options.weights.empty()) {
    OptimizedGoal goal;
    goal.options.weights = options.weights;
    for (std::size_t i = 0; i < std::min(count, options.weights.size()); ++i)
      goal.name +=
          (i == 0 ? "" : " + ") + mtf::format_double(options.weights[i]) + " x " + objective_name(study.objectives[i]);
    goals.push_back(std::move(goal));
  } else if (count == 1 || options.each) {
    for (std::size_t i = 0; i < count; ++i) goals.push_back(one_objective(study, i));
  } else {
    std::string list;
    for (std::size_t i = 0; i < count; ++i)
      list += "\n  " + std::to_string(i + 1) + ": " + objective_name(study.objectives[i]);
    throw mtf::UsageError(study.file + ": " + std::to_string(count) +
                          " objectives; choose one with --objective N, weigh them with --weights A,B,..., or give "
                          "--each:" +
                          list);
  }
  return goals;
}

std::string sensor_text(const std::shared_ptr<const study::Study>& study, const study::Optimum& optimum,
                        const std::string& file) {
  study::Evaluator evaluator(study);
  return mtf::io::write_config(evaluator.sensor_at(optimum.axis_values), file);
}

/// Of --each, in the folder.
std::string name_of(std::size_t goal) { return "best-" + std::to_string(goal + 1) + ".toml"; }

OutputSet outputs_of(const OptimizeCommandOptions& options, std::size_t goals, const study::Study& study) {
  const bool folder = options.each && !options.out.empty();
  std::vector<std::string> names;
  for (std::size_t g = 0; g < goals && folder; ++g) names.push_back(name_of(g));
  return OutputSet({.folder = folder ? options.out : "",
                    .force = options.force,
                    .names = names,
                    .files = {options.report, folder ? "" : options.out},
                    .inputs = inputs_of(study)});
}

}  // namespace

int run_optimize(const OptimizeCommandOptions& options, const Global& global) {
  const std::shared_ptr<const study::Study> study = study::load_study(options.study);
  for (const mtf::io::Diagnostic& warning : study->warnings)
    note(global, mtf::io::format_diagnostic(warning, study->file));
  std::vector<OptimizedGoal> goals = goals_of(*study, options);
  OutputSet outputs = outputs_of(options, goals.size(), *study);
  if (study->draws > 0 && study->as_built.size() > 0)
    note(global, "mtf: note: the optimum does not take as-built variation into account");

  bool feasible = true;
  {
    ProgressLine progress(global);
    for (std::size_t g = 0; g < goals.size(); ++g) {
      goals[g].options.method =
          options.search ? study::OptimizeOptions::Method::search : study::OptimizeOptions::Method::smooth;
      goals[g].options.starts = options.starts;
      goals[g].options.threads = global.threads;
      const std::string step = goals.size() == 1
                                   ? "optimising"
                                   : "optimising " + std::to_string(g + 1) + " of " + std::to_string(goals.size());
      goals[g].options.progress = [&](double share) { progress.update(step, share); };
      progress.update(step, 0.0);
      goals[g].outcome = study::optimize(*study, goals[g].options);
      feasible = feasible && goals[g].outcome.best.feasible;
    }
  }

  if (!options.out.empty()) {
    for (std::size_t g = 0; g < goals.size(); ++g) {
      const std::string file = options.each ? (std::filesystem::path(options.out) / name_of(g)).string() : options.out;
      if (!goals[g].outcome.best.feasible) {
        note(global, "mtf: note: no feasible design: " + one_line(file) + " is not written");
        continue;
      }
      emit(options.each ? outputs.in(name_of(g)) : outputs.at(file), sensor_text(study, goals[g].outcome.best, file));
      goals[g].file = file;
    }
  }
  const std::string json = optimize_json(*study, goals);
  if (!options.report.empty()) emit(outputs.at(options.report), json);
  outputs.commit();
  print(options.format == Format::json ? json : optimize_table(*study, goals));
  return feasible ? 0 : 3;
}

}  // namespace apps
