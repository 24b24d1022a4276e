// SPDX-License-Identifier: Apache-2.0

// sweep.json. Numbers that are none are null.

#include <algorithm>

#include "apps/bench/machine.h"
#include "apps/study/result_columns.h"
#include "apps/study/rows/sweep_rows.h"
#include "apps/study/study_shape.h"
#include "apps/sweep/sweep_report.h"
#include "apps/terminal/today.h"
#include "apps/text/json.h"
#include "mtf/version.h"

namespace apps {
namespace {

constexpr std::size_t kMostFront = 10'000;  // designs of the front that are listed

std::string machine_text() {
  const Machine machine = this_machine();
  return (machine.cpu.empty() ? "unknown processor" : machine.cpu) + ", " + std::to_string(machine.cores) + " cores, " +
         std::to_string(machine.memory_bytes >> 20) + " MiB";
}

Json texts_of(const SweepReport& report, const std::vector<std::size_t>& constraints) {
  Json texts = Json::array();
  for (const std::size_t k : constraints) texts.push_back(report.sweep->study->constraints[k].text);
  return texts;
}

Json columns_json(const SweepReport& report) {
  const std::vector<study::Column> all = study::file_columns(*report.sweep->study);
  const auto shown = study::table_columns(*report.sweep->study, all);
  Json columns = Json::array();
  for (std::size_t c = 0; c < all.size(); ++c) {
    const study::Column& column = all[c];
    Json one = {{"name", column.name},
                {"unit", column.unit},
                {"role", study::role_word(column.role)},
                {"definition", column.definition},
                {"source", column.source}};
    if (!shown[c].levels.empty()) one["levels"] = shown[c].levels;
    if (c < report.gaps.size() && !report.gaps[c].empty()) one["gap"] = report.gaps[c];
    one["missing"] = c < report.tally->missing().size() ? report.tally->missing()[c] : 0;
    columns.push_back(one);
  }
  return columns;
}

/// Values of an axis that has a fixed set of them, as its column holds them.
Json axis_values_json(const study::Study& study, std::size_t axis) {
  const study::Axis& a = study.axes[axis];
  Json values = Json::array();
  if (a.discrete() || study.method != study::Method::grid) {
    return a.values;
  }
  std::int64_t stride = 1;  // the last axis is the fastest
  for (std::size_t later = axis + 1; later < study.axes.size(); ++later) stride *= study.axes[later].points();
  std::vector<double> point(study.axes.size());
  for (std::int64_t i = 0; i < a.points(); ++i) {
    study::design_at(study, i * stride, point);
    values.push_back(point[axis]);
  }
  return values;
}

Json axes_json(const SweepReport& report) {
  const study::Study& study = *report.sweep->study;
  Json axes = Json::array();
  for (std::size_t a = 0; a < study.axes.size(); ++a) {
    Json one = {{"column", report.sweep->columns[a].name},
                {"scale", study.axes[a].scale == study::Scale::log ? "log" : "linear"}};
    if (const Json values = axis_values_json(study, a); !values.empty()) one["values"] = values;
    axes.push_back(one);
  }
  return axes;
}

/// With the columns that it compares; where one of them stands alone against a number also `limit`, the number in its
/// unit, and `relation`, of the column to it.
Json constraint_json(const SweepReport& report, std::size_t k) {
  const study::Study& study = *report.sweep->study;
  const study::Constraint& constraint = study.constraints[k];
  Json one = {{"text", constraint.text}, {"met", report.tally->met()[k]}, {"columns", Json::array()}};
  const auto& columns = report.sweep->columns;
  for (const auto* side : {&constraint.left, &constraint.right})
    for (const int slot : side->slots()) {
      const std::string& name = study.name_of(slot);
      if (std::ranges::none_of(columns, [&](const auto& column) { return column.name == name; })) continue;
      one["columns"].push_back(name);
      const bool left = side == &constraint.left;
      const study::Expression& other = left ? constraint.right : constraint.left;
      if (!side->only_slot() || !other.constant()) continue;
      one["limit"] = other.evaluate<double>({}) / study::unit_scale(study::unit_of(study, constraint)).si;
      one["relation"] = std::string(constraint.less == left ? "<" : ">") + (constraint.strict ? "" : "=");
    }
  return one;
}

Json best_json(const SweepReport& report) {
  const study::Study& study = *report.sweep->study;
  Json best = Json::array();
  for (std::size_t o = 0; o < study.objectives.size(); ++o) {
    const study::TallyDesign& design = report.tally->best()[o];
    if (design.design < 0) continue;
    best.push_back({{"objective", study.objectives[o].text},
                    {"design", design.design},
                    {"value", design.value},
                    {"active", Json::array()},
                    {"limits", Json::array()}});
    for (const study::Limit& limit : report.limits[o]) {
      const bool constraint = limit.kind == study::Limit::Kind::constraint;
      if (constraint) best.back()["active"].push_back(limit.text);
      Json one = limit_json(limit);
      // The best design of a grid has some room to the limit itself.
      if (constraint && study.method == study::Method::grid) one["state"] = "the next step of the grid breaks it";
      best.back()["limits"].push_back(std::move(one));
    }
  }
  return best;
}

Json sensitivities_json(const SweepReport& report) {
  const std::vector<study::Column>& columns = report.sweep->columns;
  const study::Gradient& gradient = report.gradient;
  const auto unit_of = [&](const std::string& name) {
    for (const study::Column& column : columns)
      if (column.name == name) return column.unit;
    return std::string();
  };
  Json derivatives = Json::array();
  for (std::size_t c = 0; c < gradient.columns.size(); ++c)
    for (std::size_t p = 0; p < gradient.parameters.size(); ++p) {
      const std::string of = unit_of(gradient.columns[c]), by = unit_of(gradient.parameters[p]);
      derivatives.push_back({{"column", gradient.columns[c]},
                             {"parameter", gradient.parameters[p]},
                             {"value", gradient.value[c * gradient.parameters.size() + p]},
                             {"unit", by.empty() ? of : (of.empty() ? "1" : of) + " per " + by}});
    }
  Json indices = Json::array();
  for (std::size_t r = 0; r < report.indices.columns.size(); ++r)
    for (std::size_t a = 0; a < report.sweep->study->axes.size(); ++a) {
      const study::Index& index = report.indices.indices.of[r][a];
      indices.push_back({{"column", columns[report.indices.columns[r]].name},
                         {"parameter", columns[a].name},
                         {"used", report.indices.indices.used[r]},
                         {"first", index.first},
                         {"first_sd", index.first_sd},
                         {"total", index.total},
                         {"total_sd", index.total_sd}});
    }
  return {{"design", report.gradient_design},
          {"derivatives", derivatives},
          {"samples", report.indices.indices.samples},
          {"indices", indices}};
}

Json yield_json(const SweepReport& report, std::size_t column) {
  const int draws = report.sweep->study->draws;
  Json best = Json::array();
  std::vector<std::int64_t> seen;
  const auto add = [&](const study::TallyDesign& design) {
    if (design.design < 0 || std::find(seen.begin(), seen.end(), design.design) != seen.end()) return;
    seen.push_back(design.design);
    const double yield = design.row[column];
    best.push_back({{"design", design.design},
                    {"yield", yield},
                    {"sd", study::yield_error(yield, draws)},
                    {"impossible", study::impossible_share(report.sweep->study, design.design)}});
  };
  for (const study::TallyDesign& design : report.tally->best()) add(design);
  add(report.tally->highest_yield());
  return {{"draws", draws}, {"best", best}};
}

/// Designs that no sensor can be, or whose objectives or constraints are not finite; the latter by their texts.
Json invalid_json(const SweepReport& report) {
  const study::InvalidDesigns& invalid = report.tally->invalid();
  const study::Study& study = *report.sweep->study;
  Json by = Json::array();
  for (std::size_t g = 0; g < invalid.by_goal.size(); ++g)
    if (invalid.by_goal[g] > 0) by.push_back({{"text", study.objectives[g].text}, {"designs", invalid.by_goal[g]}});
  for (std::size_t k = 0; k < invalid.by_limit.size(); ++k)
    if (invalid.by_limit[k] > 0) by.push_back({{"text", study.constraints[k].text}, {"designs", invalid.by_limit[k]}});
  Json json = {
      {"designs", invalid.designs}, {"first", invalid.first}, {"no_sensor", invalid.impossible}, {"not_finite", by}};
  if (const InvalidCause& cause = report.cause; !cause.text.empty())
    json["cause"] = {{"text", cause.text}, {"designs", cause.designs}, {"looked_at", cause.looked_at}};
  return json;
}

Json accuracy_json(const SweepReport& report) {
  Json rows = Json::array();
  for (const study::AccuracyRow& row : report.accuracy.rows)
    rows.push_back({{"tolerance", row.tolerance},
                    {"promised", row.promised},
                    {"realised", row.realised},
                    {"us_per_design", row.us_per_design}});
  return rows;
}

}  // namespace

Json limit_json(const study::Limit& limit) {
  return {{"text", limit.text},
          {"kind", limit.kind == study::Limit::Kind::constraint ? "constraint"
                   : limit.kind == study::Limit::Kind::lower    ? "lower"
                                                                : "upper"},
          {"state", std::string(study::state_words(limit.kind))},
          {"value", limit.value},
          {"unit", limit.unit},
          {"gain", limit.gain}};
}

Json to_json(const SweepReport& report) {
  const study::Study& study = *report.sweep->study;
  const study::Tally& tally = *report.tally;
  const SweepRun& run = *report.run;
  Json json = {{"schema", 1},
               {"kind", "sweep"},
               {"version", mtf::version},
               {"commit", mtf::git_commit},
               {"date", today()},
               {"machine", machine_text()},
               {"study", {{"name", study.name}, {"file", "study.toml"}, {"sha256", study.sha256}}},
               {"conditions", {{"temperature_k", study.conditions.temperature_k}}}};
  // What the figures of observers and ranges hold for, where there are any.
  if (const auto lines = study::condition_lines(study); !lines.empty()) json["conditions"]["lines"] = lines;
  json["sensors"] = Json::array();
  for (std::size_t i = 1; i < run.files.size(); ++i)
    json["sensors"].push_back({{"file", std::filesystem::path(run.files[i].file).lexically_normal().generic_string()},
                               {"sha256", run.files[i].sha256}});
  json["designs"] = study.designs;
  json["evaluated"] = tally.designs();
  json["method"] = study::kMethods[static_cast<std::size_t>(study.method)];
  json["seed"] = study.seed;
  json["tolerance"] = study.tolerance;
  json["worst_error"] = tally.worst_error();
  json["columns"] = columns_json(report);
  json["axes"] = axes_json(report);
  json["constraints"] = Json::array();
  for (std::size_t k = 0; k < study.constraints.size(); ++k) json["constraints"].push_back(constraint_json(report, k));
  json["objectives"] = Json::array();
  for (std::size_t o = 0; o < study.objectives.size(); ++o)
    json["objectives"].push_back({{"text", study.objectives[o].text},
                                  {"column", report.sweep->columns[tally.job().goals[o].column].name},
                                  {"maximize", study.objectives[o].maximize}});
  json["feasible"] = tally.feasible();
  if (tally.invalid().designs > 0) json["invalid"] = invalid_json(report);
  if (tally.feasible() == 0 && tally.nearest().design >= 0 && !none_valid(report)) {
    json["nearest"] = {{"design", tally.nearest().design},
                       {"violated", texts_of(report, violated_constraints(report, tally.nearest().row))}};
    json["contradictions"] = Json::array();  // smallest sets of constraints that no design meets together
    for (const auto& set : tally.contradictions()) json["contradictions"].push_back(texts_of(report, set));
  }
  json["best"] = best_json(report);
  if (study.objectives.size() > 1) {
    const auto& front = report.front.designs;
    json["pareto"] =
        std::vector(front.begin(), front.begin() + static_cast<std::ptrdiff_t>(std::min(front.size(), kMostFront)));
    json["pareto_size"] = front.size();
  }
  json["chosen"] = Json::array();
  for (const ChosenFile& chosen : report.chosen) {
    json["chosen"].push_back({{"design", chosen.design}, {"file", chosen.file}, {"why", chosen.why}});
    if (!chosen.caution.empty()) json["chosen"].back()["caution"] = chosen.caution;
  }
  json["sensitivities"] = sensitivities_json(report);
  if (const auto column = study::column_of(report.sweep->columns, study::Column::Role::yield))
    json["yield"] = yield_json(report, *column);
  if (!report.accuracy.rows.empty()) json["accuracy"] = accuracy_json(report);
  json["timing"] = {{"seconds", run.seconds},
                    {"designs_per_second", static_cast<double>(run.tally.made) / run.seconds},
                    {"threads", report.threads},
                    {"resumed_designs", run.tally.resumed}};
  json["skipped"] = report.skipped;
  return json;
}

}  // namespace apps
