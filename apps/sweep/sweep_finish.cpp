// SPDX-License-Identifier: Apache-2.0

// From rows to a folder of results.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "apps/study/result_columns.h"
#include "apps/study/rows/sweep_rows.h"
#include "apps/sweep/sweep_report.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/stage.h"
#include "mtf/parallel.h"
#include "mtf/units.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSpreadOverFront = 6;  // designs of the front that get a sensor file
constexpr std::int64_t kSampled = 64;        // designs after which an evaluator can say what they share and lack
constexpr double kAccuracySeconds = 3.0;     // for the table of error against time
constexpr double kIndexSeconds = 10.0;       // at most, for the shares of variance ...
constexpr double kAnyIndexSeconds = 1.0;     // ... and as long as this if the designs took less
constexpr double kActiveShare = 0.01;

/// Designs that are chosen, each once: the best of each objective, then some spread over the front; the nearest one
/// where none is feasible, the middle one where nothing is asked for, none where all are invalid.
std::vector<ChosenFile> choose(const SweepReport& report) {
  std::vector<ChosenFile> chosen;
  if (none_valid(report)) return chosen;
  const auto add = [&](std::int64_t design, const std::string& why) {
    const auto same = std::find_if(chosen.begin(), chosen.end(), [&](const auto& c) { return c.design == design; });
    if (same == chosen.end())
      chosen.push_back({design, "chosen/design_" + std::to_string(design) + ".toml", why});
    else if (why != "on the Pareto front")
      same->why += ", " + why;
  };
  const study::Study& study = *report.sweep->study;
  const auto& best = report.tally->best();
  for (std::size_t o = 0; o < best.size(); ++o)
    if (best[o].design >= 0) add(best[o].design, "best " + study.objectives[o].text);
  for (const std::size_t point : spread_over_front(report.front, kSpreadOverFront))
    add(report.front.designs[point], "on the Pareto front");
  if (report.tally->feasible() == 0 && report.tally->nearest().design >= 0)
    add(report.tally->nearest().design, "nearest to the constraints");
  if (chosen.empty()) add(study.designs / 2, study.designs == 1 ? "the only design" : "middle of the study");
  return chosen;
}

std::vector<double> axis_values(const study::Study& study, std::int64_t design) {
  std::vector<double> values(study.axes.size());
  study::design_at(study, design, values);
  return values;
}

/// Writes the sensor files of the chosen designs; those that a sensor cannot be are taken off the list.
void write_chosen(SweepReport& report, study::Evaluator& evaluator) {
  OutputSet& outputs = *report.run->outputs;
  // Curves are named by their absolute path where they are not below the sensor file: here they are in the folder of
  // the study.
  const std::string whole = "\"" + (fs::weakly_canonical(fs::absolute(outputs.in(""))) / "").string();
  std::erase_if(report.chosen, [&](const ChosenFile& chosen) {
    try {
      const std::string file = outputs.in(chosen.file);
      std::string text =
          mtf::io::write_config(evaluator.sensor_at(axis_values(*report.sweep->study, chosen.design)), file);
      for (std::size_t at = text.find(whole); at != std::string::npos; at = text.find(whole, at))
        text.replace(at, whole.size(), "\"../");
      emit(file, text);
      return false;
    } catch (const mtf::UsageError& problem) {
      report.skipped.push_back("design " + std::to_string(chosen.design) + " (" + chosen.why +
                               ") has no sensor file: " + problem.what());
      return true;
    }
  });
}

std::vector<study::ConstraintValues> sides_of(const SweepReport& report, std::span<const double> row) {
  const study::TallyJob& job = report.tally->job();
  std::vector<study::ConstraintValues> sides(job.limits.size());
  if (!sides.empty() && !row.empty()) job.sides(row, sides);
  return sides;
}

/// What keeps the best design of an objective from being better: constraints that are within 1 % of their limit, or
/// that the next step of the grid along an axis breaks where it improves the objective; ends of axes from which the
/// first step back makes it worse.
std::vector<study::Limit> limits_of_best(const SweepReport& report, study::Evaluator& evaluator,
                                         std::size_t objective) {
  const study::Study& study = *report.sweep->study;
  const study::TallyDesign& best = report.tally->best()[objective];
  const study::TallyGoal& goal = report.tally->job().goals[objective];
  std::vector<study::Limit> limits;
  if (best.design < 0) return limits;
  const std::vector<double> at = axis_values(study, best.design);
  const auto sides = sides_of(report, best.row);
  std::vector<bool> limiting(sides.size());
  for (std::size_t k = 0; k < sides.size(); ++k) limiting[k] = study::active(sides[k], kActiveShare);
  std::vector<double> row(report.sweep->columns.size());
  std::int64_t stride = study.designs;  // the last axis is the fastest
  for (std::size_t a = 0; a < at.size() && study.method == study::Method::grid; ++a) {
    const std::int64_t points = study.axes[a].points(), block = stride;
    stride /= points;
    const std::int64_t place = best.design % block / stride;
    const auto& values = study.axes[a].values;
    const bool ordered = !study.axes[a].discrete() && std::is_sorted(values.begin(), values.end());
    for (const int step : {-1, 1}) {
      if (place + step < 0 || place + step >= points) continue;
      evaluator.evaluate(best.design + step * stride, row);
      if (!evaluator.last_valid()) continue;
      const double gain = (goal.maximize ? 1.0 : -1.0) * (row[goal.column] - best.value);
      if (gain > 0.0)
        for (const std::size_t k : violated_constraints(report, row)) limiting[k] = true;
      if (gain < 0.0 && ordered && place == (step > 0 ? 0 : points - 1))
        limits.push_back(
            limit_of(study, row[a] > at[a] ? study::Limit::Kind::lower : study::Limit::Kind::upper, a, at, sides));
    }
  }
  for (std::size_t k = limiting.size(); k-- > 0;)
    if (limiting[k]) limits.insert(limits.begin(), limit_of(study, study::Limit::Kind::constraint, k, at, sides));
  return limits;
}

/// The commonest of these causes. Their numbers, which differ from design to design, do not count.
InvalidCause commonest(const std::vector<std::string>& causes) {
  std::map<std::string, InvalidCause> found;
  for (const std::string& text : causes) {
    std::string words = text;
    std::erase_if(words, [](unsigned char c) { return std::isdigit(c) != 0 || c == '.' || c == 'e' || c == '-'; });
    InvalidCause& cause = found[words];
    if (cause.designs++ == 0) cause.text = text;
  }
  InvalidCause most;
  for (const auto& [words, cause] : found)
    if (!cause.text.empty() && cause.designs > most.designs) most = cause;
  most.looked_at = std::ssize(causes);
  return most;
}

/// What evaluators report about the study as a whole, and derivatives at the best design.
void ask_evaluator(SweepReport& report) {
  const study::Study& study = *report.sweep->study;
  study::Evaluator evaluator(report.sweep->study);
  std::vector<double> row(report.sweep->columns.size());
  // From all over the study: what is saturated or impossible may be at one end of it only.
  const std::int64_t some = std::min(kSampled, study.designs);
  std::vector<std::string> causes;
  for (std::int64_t i = 0; i < some; ++i) {
    evaluator.evaluate(i * (study.designs - 1) / std::max<std::int64_t>(some - 1, 1), row);
    if (evaluator.last_valid()) continue;
    causes.push_back(evaluator.last_problem().empty() ? evaluator.last_refusal() : evaluator.last_problem());
  }
  report.cause = commonest(causes);
  report.gaps = evaluator.gaps();
  for (const std::string& text : evaluator.skipped()) report.skipped.push_back(text);
  report.chosen = choose(report);
  for (ChosenFile& chosen : report.chosen) {
    evaluator.evaluate(chosen.design, row);
    chosen.caution = evaluator.last_caution();
  }
  write_chosen(report, evaluator);
  for (std::size_t o = 0; o < study.objectives.size(); ++o)
    report.limits.push_back(limits_of_best(report, evaluator, o));
  const auto& best = report.tally->best();
  const auto first = std::find_if(best.begin(), best.end(), [](const auto& b) { return b.design >= 0; });
  report.gradient_design = first != best.end() ? first->design : study.designs / 2;
  report.gradient = evaluator.gradient_at(axis_values(study, report.gradient_design));
}

// The summary that `mtf sweep` prints.

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
    const std::string limits = joined(report.limits[o], [](const study::Limit& one) { return one_line(one.text); });
    cells.push_back(limits.empty() ? "-" : limits);
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
  if (const InvalidCause& cause = report.cause; !cause.text.empty())
    text += "  the commonest cause, of " + share(cause.designs, cause.looked_at) +
            " looked at: " + one_line(cause.text) + "\n";
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

std::vector<std::size_t> spread_over_front(const study::FrontPoints& front, std::size_t most) {
  std::vector<std::size_t> order(front.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return front.at(a)[0] != front.at(b)[0] ? front.at(a)[0] < front.at(b)[0] : a < b;
  });
  const std::size_t some = std::min(most, order.size());
  std::vector<std::size_t> points;
  for (std::size_t i = 0; i < some; ++i) points.push_back(order[some == 1 ? 0 : i * (order.size() - 1) / (some - 1)]);
  return points;
}

bool none_valid(const SweepReport& report) { return report.tally->invalid().designs == report.tally->designs(); }

std::vector<std::size_t> violated_constraints(const SweepReport& report, std::span<const double> row) {
  const auto sides = sides_of(report, row);
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < sides.size(); ++k)
    if (!study::meets(report.tally->job().limits[k], sides[k])) found.push_back(k);
  return found;
}

int finish_sweep(const SweepStudy& sweep, const SweepRun& run, const SweepOptions& options, const Global& global) {
  const mtf::Stopwatch watch;
  study::Tally tally(study::tally_job(sweep.study, sweep.columns));
  SweepReport report;
  report.sweep = &sweep;
  report.run = &run;
  report.tally = &tally;
  report.threads = mtf::threads_of(global.threads);
  {
    ProgressLine progress(global);
    const auto designs = static_cast<double>(sweep.study->designs);
    // Counted first: which designs are on the front is known only when all of them have been read.
    study::read_pieces(
        run.pieces, [&](study::RowRange range, const std::vector<double>& rows) { return tally.count(range, rows); },
        global.threads, [&](std::int64_t done) { progress.update("counts", static_cast<double>(done) / designs); });
    report.front = tally.front();
    const std::vector<study::Column> columns = study::file_columns(*sweep.study);
    const bool with_front = sweep.study->objectives.size() > 1;
    study::write_table(
        {.pieces = run.pieces,
         .columns = study::table_columns(*sweep.study, columns),
         .marked = with_front ? std::optional(report.front.designs) : std::nullopt,
         .csv = run.outputs->in("designs.csv"),
         .npy = run.outputs->in("designs.npy"),
         .threads = global.threads,
         .done = [&](std::int64_t done) { progress.update("tables", static_cast<double>(done) / designs); }});
    emit(run.outputs->in("columns.csv"), study::columns_csv(columns));
    ask_evaluator(report);
    // No longer than the designs took, where they were computed here and now.
    const bool timed = run.tally.made > 0 && run.tally.resumed == 0 && !std::isnan(run.seconds);
    const double seconds = timed ? std::clamp(run.seconds, kAnyIndexSeconds, kIndexSeconds) : kIndexSeconds;
    report.indices = study::study_indices(sweep.study, sweep.columns, seconds, global.threads,
                                          [&](double share) { progress.update("sensitivities", share); });
    if (options.accuracy) {
      progress.update("accuracy", 0.0);
      report.accuracy = study::accuracy_table(*sweep.study, kAccuracySeconds);
    }
  }
  report.finish_seconds = watch.seconds();
  const std::string json = mtf::io::without_stages(json_document(to_json(report)));
  emit(run.outputs->in("sweep.json"), json);
  run.outputs->commit();
  print(options.format == Format::json ? json : mtf::io::without_stages(sweep_summary(report)));
  int status = 0;
  if (none_valid(report)) {
    complain(
        "mtf: every design is invalid, so none is chosen: change the axes, or what the objectives and constraints "
        "ask for");
    status = 3;
  }
  for (const study::AccuracyRow& row : report.accuracy.rows) {
    if (!study::broken(report.accuracy, row)) continue;
    note(global, "mtf: at tolerance " + mtf::format_double(row.tolerance) + " a metric is off by " +
                     significant(row.realised, 2) + ", more than the promised " + significant(row.promised, 2) +
                     "; take a tighter tolerance, and please report the study");
    status = 3;
  }
  return status;
}

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
            significant(100.0 * study::yield_error(yield, study.draws), 2) + " % of " + std::to_string(study.draws) +
            " draws: design " + std::to_string(tally.highest_yield().design) + "\n";
    if (const double share = study::impossible_share(report.sweep->study, tally.highest_yield().design); share > 0.0)
      text += "of these draws " + significant(100.0 * share, 3) +
              " % are no possible sensor, as of a value below 0, and count as bad\n";
  }
  for (const std::string& line : study::condition_lines(study)) text += one_line(line) + "\n";
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (c < report.gaps.size() && !report.gaps[c].empty())
      text += "no " + one_line(columns[c].name) + ": " + one_line(report.gaps[c]) + "\n";
  for (const std::string& skipped : report.skipped) text += one_line(skipped) + "\n";
  text += "error at most " + (std::isnan(tally.worst_error()) ? "unknown" : significant(tally.worst_error(), 2)) +
          " (tolerance " + mtf::format_double(study.tolerance) + ")" +
          (tally.worst_error() > 1.01 * study.tolerance ? ": the column error shows the designs above it, whose OTF, "
                                                          "table of air or mean over the image allows no better\n"
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
         fixed(report.finish_seconds, 2) + " s\nnext: mtf report " + shell_word(run.folder.string()) + "\n";
}

}  // namespace apps
