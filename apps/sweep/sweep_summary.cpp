// SPDX-License-Identifier: Apache-2.0

// The summary that `mtf sweep` prints.

#include <cmath>

#include "apps/study/result_columns.h"
#include "apps/study/rows/sweep_rows.h"
#include "apps/study/study_conditions.h"
#include "apps/sweep/sweep_report.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/units.h"

namespace apps {
namespace {

std::string list(const SweepReport& report, const std::vector<std::size_t>& constraints, const std::string& between) {
  std::string text;
  for (const std::size_t k : constraints)
    text += (text.empty() ? "" : between) + one_line(report.sweep->study->constraints[k].text);
  return text;
}

/// The value of an axis: its word where it has words.
std::string axis_text(const study::TableColumn& column, double value) {
  const bool named = !column.levels.empty() && value >= 0.0 && value < static_cast<double>(column.levels.size());
  return named ? one_line(column.levels[static_cast<std::size_t>(value)]) : significant(value, 5);
}

/// The best designs with their axes.
std::string best_table(const SweepReport& report) {
  const study::Study& study = *report.sweep->study;
  const std::vector<study::Column>& columns = report.sweep->columns;
  std::vector<std::string> header{"best", "value", "design"};
  for (std::size_t a = 0; a < study.axes.size(); ++a)
    header.push_back(one_line(columns[a].name) + (columns[a].unit.empty() ? "" : " [" + columns[a].unit + "]"));
  header.push_back("limited by");
  const auto shown = study::table_columns(study, columns);
  TextTable table(header);
  std::vector<Align> align(header.size(), Align::right);
  align.front() = align.back() = Align::left;
  bool any = false;
  for (std::size_t o = 0; o < study.objectives.size(); ++o) {
    const study::TallyDesign& best = report.tally->best()[o];
    if (best.design < 0) continue;
    any = true;
    const study::Objective& objective = study.objectives[o];
    std::vector<std::string> cells{(objective.maximize ? "maximize " : "minimize ") + one_line(objective.text),
                                   significant(best.value, 5) + (objective.unit.empty() ? "" : " " + objective.unit),
                                   std::to_string(best.design)};
    for (std::size_t a = 0; a < study.axes.size(); ++a) cells.push_back(axis_text(shown[a], best.row[a]));
    const std::string active = list(report, active_constraints(report, best.row), ", ");
    cells.push_back(active.empty() ? "-" : active);
    table.add(cells);
  }
  return any ? table.aligned(align) : "";
}

/// A few designs from all along the front, with their objectives and axes; the others are counted.
std::string front_table(const SweepReport& report) {
  constexpr std::size_t kMost = 10;
  const study::Study& study = *report.sweep->study;
  const std::vector<study::Column>& columns = report.sweep->columns;
  const auto shown = study::table_columns(study, columns);
  const auto heading = [](const std::string& name, const std::string& unit) {
    return one_line(name) + (unit.empty() ? "" : " [" + unit + "]");
  };
  std::vector<std::string> header{"design"};
  std::vector<std::size_t> objectives;  // those that are no axis, which has a column anyway
  for (std::size_t o = 0; o < study.objectives.size(); ++o)
    if (report.tally->job().goals[o].column >= study.axes.size()) objectives.push_back(o);
  for (const std::size_t o : objectives) header.push_back(heading(study.objectives[o].text, study.objectives[o].unit));
  for (std::size_t a = 0; a < study.axes.size(); ++a) header.push_back(heading(columns[a].name, columns[a].unit));
  TextTable table(header);
  const std::vector<std::size_t> points = spread_over_front(report.front, kMost);
  std::vector<double> levels(study.axes.size());
  for (auto point = points.rbegin(); point != points.rend(); ++point) {
    std::vector<std::string> cells{std::to_string(report.front.designs[*point])};
    for (const std::size_t o : objectives)
      cells.push_back(significant((study.objectives[o].maximize ? 1.0 : -1.0) * report.front.at(*point)[o], 5));
    study::design_at(study, report.front.designs[*point], levels);
    for (std::size_t a = 0; a < levels.size(); ++a) {
      const study::Axis& axis = study.axes[a];
      cells.push_back(
          axis_text(shown[a], axis.discrete() ? axis.values[static_cast<std::size_t>(levels[a])] : levels[a]));
    }
    table.add(cells);
  }
  const std::size_t others = report.front.size() - points.size();
  return table.aligned(std::vector<Align>(header.size(), Align::right)) +
         (others > 0 ? "and " + std::to_string(others) + " more, which the column pareto of designs.csv marks\n" : "");
}

std::string infeasible(const SweepReport& report) {
  std::string text = "no design meets all constraints\n";
  for (const auto& set : report.tally->contradictions())
    text += set.size() == 1 ? "no design meets " + list(report, set, "") + "\n"
                            : "no design meets all of: " + list(report, set, "; ") + "\n";
  const study::TallyDesign& nearest = report.tally->nearest();
  if (nearest.design >= 0 && !none_valid(report))
    text += "nearest is design " + std::to_string(nearest.design) +
            ", which misses: " + list(report, violated_constraints(report, nearest.row), "; ") + "\n";
  return text;
}

std::string share(std::int64_t count, std::int64_t of) { return std::to_string(count) + " of " + std::to_string(of); }

/// What makes designs invalid, and how many.
std::string invalid(const SweepReport& report) {
  const study::InvalidDesigns& invalid = report.tally->invalid();
  if (invalid.designs == 0) return "";
  const study::Study& study = *report.sweep->study;
  std::string text = "invalid " + share(invalid.designs, report.tally->designs()) + ", the first is design " +
                     std::to_string(invalid.first) + "\n";
  if (invalid.impossible > 0) text += "  impossible as a sensor: " + std::to_string(invalid.impossible) + "\n";
  for (std::size_t g = 0; g < invalid.by_goal.size(); ++g)
    if (invalid.by_goal[g] > 0)
      text +=
          "  " + one_line(study.objectives[g].text) + " is not finite: " + std::to_string(invalid.by_goal[g]) + "\n";
  for (std::size_t k = 0; k < invalid.by_limit.size(); ++k)
    if (invalid.by_limit[k] > 0)
      text += "  " + one_line(study.constraints[k].text) +
              " compares values that are not finite: " + std::to_string(invalid.by_limit[k]) + "\n";
  return text;
}

}  // namespace

std::string sweep_summary(const SweepReport& report) {
  const study::Study& study = *report.sweep->study;
  const study::Tally& tally = *report.tally;
  const SweepRun& run = *report.run;
  const auto& columns = report.sweep->columns;
  std::string text = one_line(run.folder.string()) + "  " + one_line(study.name) + ": " +
                     std::to_string(tally.designs()) + " designs\n";
  if (!study.constraints.empty()) {
    text += "feasible " + share(tally.feasible(), tally.designs()) + "\n";
    TextTable table({"constraint", "met by"});
    for (std::size_t k = 0; k < study.constraints.size(); ++k)
      table.add({one_line(study.constraints[k].text), std::to_string(tally.met()[k])});
    text += table.aligned({Align::left, Align::right});
    if (tally.feasible() == 0) text += infeasible(report);
  }
  text += invalid(report);
  text += best_table(report);
  for (const ChosenFile& chosen : report.chosen)
    if (!chosen.caution.empty())
      text += "design " + std::to_string(chosen.design) + " (" + one_line(chosen.why) + "): " + chosen.caution + "\n";
  if (study.objectives.size() > 1)
    text += "Pareto front: " + plural(std::ssize(report.front.designs), "design") + "\n" +
            (report.front.size() > 0 ? front_table(report) : "");
  if (const auto column = study::column_of(columns, study::Column::Role::yield);
      column && tally.highest_yield().design >= 0) {
    const double yield = tally.highest_yield().value;
    text += "highest yield " + fixed(100.0 * yield, 1) + " % +- " +
            fixed(100.0 * study::yield_error(yield, study.draws), 1) + " % of " + std::to_string(study.draws) +
            " draws: design " + std::to_string(tally.highest_yield().design) + "\n";
  }
  for (const std::string& line : study::condition_lines(study)) text += one_line(line) + "\n";
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (c < report.gaps.size() && !report.gaps[c].empty())
      text += "no " + one_line(columns[c].name) + ": " + one_line(report.gaps[c]) + "\n";
  for (const std::string& skipped : report.skipped) text += one_line(skipped) + "\n";
  text += "error at most " + (std::isnan(tally.worst_error()) ? "unknown" : significant(tally.worst_error(), 2)) +
          " (tolerance " + mtf::format_double(study.tolerance) + ")" +
          (tally.worst_error() > 1.01 * study.tolerance
               ? ": the column error shows the designs above it, whose OTF, or whose table of air, allows no better\n"
               : "\n");
  if (run.tally.made > 0)
    text += "time " + fixed(run.seconds, 2) + " s, " +
            significant(static_cast<double>(run.tally.made) / run.seconds, 3) + " designs/s on " +
            std::to_string(report.threads) + (report.threads == 1 ? " thread" : " threads");
  if (std::isnan(run.seconds))
    text += "merged from shards";
  else if (run.tally.resumed > 0)
    text += std::string(run.tally.made > 0 ? "; " : "") + std::to_string(run.tally.resumed) +
            " designs were computed before";
  return text +
         (report.accuracy.rows.empty() ? "; tables and sensitivities " : "; tables, sensitivities and accuracy ") +
         fixed(report.finish_seconds, 2) + " s\n";
}

}  // namespace apps
