// SPDX-License-Identifier: Apache-2.0
#include "apps/sweep/optimize_report.h"

#include <cmath>

#include "apps/study/study_conditions.h"
#include "apps/sweep/sweep_report.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/version.h"

namespace apps {
namespace {

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

std::string role_name(Column::Role role) {
  return role == Column::Role::axis     ? "axis"
         : role == Column::Role::link   ? "link"
         : role == Column::Role::metric ? "metric"
                                        : "objective";
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
                              {"role", role_name(columns[c].role)},
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

std::string status_name(Status status) {
  return status == Status::optimal      ? "optimal"
         : status == Status::stopped    ? "stopped"
         : status == Status::infeasible ? "infeasible"
                                        : "impossible";
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
