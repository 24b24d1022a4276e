// SPDX-License-Identifier: Apache-2.0

// `mtf optimize`: the best design of a study.

#include <cmath>
#include <filesystem>

#include "apps/study/result_columns.h"
#include "apps/sweep/sweep_report.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"
#include "mtf/version.h"

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

using study::Column;
using study::Limit;
using study::OptimizeOutcome;
using study::Optimum;
using study::Study;
using Status = OptimizeOutcome::Status;

constexpr int kDigits = 8;

std::string method_name(study::OptimizeOptions::Method method) {
  return method == study::OptimizeOptions::Method::smooth ? "smooth" : "search";
}

/// What a column says about a design and has no other place: axes, links, metrics, objectives of their own.
std::string status_name(Status status) {
  return status == Status::optimal      ? "optimal"
         : status == Status::stopped    ? "stopped"
         : status == Status::infeasible ? "infeasible"
                                        : "impossible";
}

bool is_value(const Column& column) {
  return column.role == Column::Role::axis || column.role == Column::Role::link ||
         column.role == Column::Role::metric || column.role == Column::Role::objective;
}

/// The word of a discrete axis, else null.
const std::string* level_of(const Study& study, const Optimum& optimum, std::size_t column) {
  if (column >= study.axes.size() || !study.axes[column].discrete()) return nullptr;
  return &study.axes[column].levels[static_cast<std::size_t>(optimum.axis_values[column])];
}

std::string value_text(const Study& study, const Optimum& optimum, std::size_t column) {
  if (const std::string* level = level_of(study, optimum, column)) return one_line(*level);
  const double value = optimum.row[column];
  return std::isfinite(value) ? significant(value, kDigits) : "-";
}

std::string reached_text(const Optimum& optimum, std::size_t axis) {
  for (const Limit& limit : optimum.limits)
    if (limit.kind != Limit::Kind::constraint && limit.index == axis) return std::string(state_words(limit.kind));
  return {};
}

std::string constraint_text(const Study& study, const Optimum& optimum, std::size_t i) {
  for (const study::Violation& violation : optimum.violations)
    if (violation.constraint == i)
      return "missed by " + significant(violation.by, 4) + (violation.unit.empty() ? "" : " " + violation.unit);
  for (const Limit& limit : optimum.limits)
    if (limit.kind == Limit::Kind::constraint && limit.index == i) return std::string(state_words(limit.kind));
  return study.constraints.empty() ? "" : "holds";
}

std::string headline(const OptimizedGoal& goal) {
  const OptimizeOutcome& outcome = goal.outcome;
  switch (outcome.status) {
    case Status::optimal:
      return "optimal (remaining slope " + significant(outcome.best.residual, 2) + " of the objective's spread)";
    case Status::stopped:
      return "feasible, not shown to be optimal";
    case Status::infeasible:
      return "infeasible; the nearest design:";
    case Status::impossible:
      break;
  }
  return "impossible";
}

std::string others_table(const Study& study, const OptimizedGoal& goal) {
  std::vector<std::string> header{"other places", "starts"};
  const std::vector<Column> columns = columns_of(study);
  for (std::size_t a = 0; a < study.axes.size(); ++a)
    header.push_back(one_line(columns[a].name) + (columns[a].unit.empty() ? "" : " [" + columns[a].unit + "]"));
  for (std::size_t i = 0; i < study.objectives.size(); ++i) header.push_back(one_line(study.objectives[i].text));
  TextTable table(std::move(header));
  for (const Optimum& other : goal.outcome.others) {
    std::vector<std::string> row{other.converged ? "optimum" : "stopped", std::to_string(other.starts)};
    for (std::size_t a = 0; a < study.axes.size(); ++a) row.push_back(value_text(study, other, a));
    for (const double value : other.objectives) row.push_back(significant(value, kDigits));
    table.add(std::move(row));
  }
  return table.aligned();
}

/// `whole`: with its metrics.
Json optimum_json(const Study& study, const Optimum& optimum, bool whole) {
  Json json{{"design", Json::array()}, {"objectives", Json::array()}, {"constraints", Json::array()}};
  const std::vector<Column> columns = columns_of(study);
  for (std::size_t c = 0; c < columns.size() && c < optimum.row.size(); ++c) {
    if (!is_value(columns[c]) || (!whole && columns[c].role == Column::Role::metric)) continue;
    const std::string* level = level_of(study, optimum, c);
    json["design"].push_back({{"name", columns[c].name},
                              {"role", study::role_word(columns[c].role)},
                              {"value", level != nullptr ? Json(*level) : optimum.row[c]},
                              {"unit", columns[c].unit}});
  }
  for (std::size_t i = 0; i < optimum.objectives.size(); ++i)
    json["objectives"].push_back({{"text", study.objectives[i].text},
                                  {"maximize", study.objectives[i].maximize},
                                  {"value", optimum.objectives[i]},
                                  {"unit", study.objectives[i].unit}});
  for (std::size_t i = 0; i < study.constraints.size(); ++i)
    json["constraints"].push_back({{"text", study.constraints[i].text}, {"state", constraint_text(study, optimum, i)}});
  json["goal"] = optimum.goal;
  json["error"] = optimum.row.back();
  json["feasible"] = optimum.feasible;
  json["limits"] = Json::array(optimum.limits, limit_json);
  json["limits_depend"] = optimum.shared;
  json["violations"] = Json::array();
  for (const study::Violation& violation : optimum.violations)
    json["violations"].push_back({{"text", study.constraints[violation.constraint].text},
                                  {"by", violation.by},
                                  {"unit", violation.unit},
                                  {"share", violation.share}});
  json["residual"] = optimum.residual;
  json["converged"] = optimum.converged;
  json["method"] = method_name(optimum.method);
  json["why"] = optimum.why;
  json["edge"] = optimum.edge;
  json["starts"] = optimum.starts;
  return json;
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

std::string optimize_table(const Study& study, const std::vector<OptimizedGoal>& goals) {
  std::string text;
  const std::vector<Column> columns = columns_of(study);
  for (const OptimizedGoal& goal : goals) {
    const OptimizeOutcome& outcome = goal.outcome;
    text += (text.empty() ? "" : "\n") + one_line(goal.name) + ": " + headline(goal) + "\n";
    if (outcome.status != Status::impossible) {
      TextTable table({"", "value", "unit", ""});
      for (std::size_t c = 0; c < columns.size(); ++c)
        if (is_value(columns[c]))
          table.add({one_line(columns[c].name), value_text(study, outcome.best, c), columns[c].unit,
                     c < study.axes.size() ? reached_text(outcome.best, c) : ""});
      table.add({"error", significant(outcome.best.row.back(), 2), "", "largest of the metrics, estimated"});
      for (std::size_t i = 0; i < study.constraints.size(); ++i)
        table.add({one_line(study.constraints[i].text), constraint_text(study, outcome.best, i), "", ""});
      text += table.aligned();
    }
    for (const std::string& line : sentences(study, goal.options, outcome)) text += "- " + one_line(line) + "\n";
    if (!outcome.others.empty()) text += others_table(study, goal);
    text += std::to_string(outcome.evaluations) + " evaluations, " + std::to_string(outcome.starts) +
            (outcome.starts == 1 ? " start" : " starts") + "\n";
  }
  for (const std::string& line : study::condition_lines(study)) text += one_line(line) + "\n";
  return text;
}

std::string optimize_json(const Study& study, const std::vector<OptimizedGoal>& goals) {
  Json json{{"schema", 1},
            {"program", std::string("mtf ") + mtf::version},
            {"study", study.file},
            {"name", study.name},
            {"sha256", study.sha256},
            {"seed", study.seed},
            {"goals", Json::array()}};
  if (const auto lines = study::condition_lines(study); !lines.empty()) json["conditions"]["lines"] = lines;
  for (const OptimizedGoal& goal : goals) {
    const OptimizeOutcome& outcome = goal.outcome;
    Json one{{"goal", goal.name},
             {"weights", goal.options.weights},
             {"status", status_name(outcome.status)},
             {"method", method_name(goal.options.method)},
             {"starts", outcome.starts},
             {"starts_of_best", outcome.starts_of_best},
             {"evaluations", outcome.evaluations},
             {"best", outcome.status == Status::impossible ? Json() : optimum_json(study, outcome.best, true)},
             {"others", Json::array()},
             {"contradiction", outcome.contradiction},
             {"problem", outcome.problem},
             {"says", sentences(study, goal.options, outcome)},
             {"file", text_or_null(goal.file)}};
    for (const Optimum& other : outcome.others) one["others"].push_back(optimum_json(study, other, false));
    json["goals"].push_back(std::move(one));
  }
  return json_document(json);
}

}  // namespace apps
