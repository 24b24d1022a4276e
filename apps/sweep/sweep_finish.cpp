// SPDX-License-Identifier: Apache-2.0

// From rows to a folder of results.

#include <algorithm>

#include "apps/study/result_columns.h"
#include "apps/sweep/sweep_report.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/stage.h"
#include "mtf/parallel.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSpreadOverFront = 6;  // designs of the front that get a sensor file
constexpr std::int64_t kSampled = 64;        // designs after which an evaluator can say what they share and lack
constexpr double kAccuracySeconds = 3.0;     // for the table of error against time
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
  if (chosen.empty()) add(study.designs / 2, "middle of the study");
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

/// What evaluators report about the study as a whole, and derivatives at the best design.
void ask_evaluator(SweepReport& report) {
  const study::Study& study = *report.sweep->study;
  study::Evaluator evaluator(report.sweep->study);
  std::vector<double> row(report.sweep->columns.size());
  // From all over the study: what is saturated or impossible may be at one end of it only.
  const std::int64_t some = std::min(kSampled, study.designs);
  for (std::int64_t i = 0; i < some; ++i)
    evaluator.evaluate(i * (study.designs - 1) / std::max<std::int64_t>(some - 1, 1), row);
  report.gaps = evaluator.gaps();
  for (const std::string& text : evaluator.skipped()) report.skipped.push_back(text);
  report.chosen = choose(report);
  for (ChosenFile& chosen : report.chosen) {
    evaluator.evaluate(chosen.design, row);
    chosen.caution = evaluator.last_caution();
  }
  write_chosen(report, evaluator);
  const auto& best = report.tally->best();
  const auto first = std::find_if(best.begin(), best.end(), [](const auto& b) { return b.design >= 0; });
  report.gradient_design = first != best.end() ? first->design : study.designs / 2;
  report.gradient = evaluator.gradient_at(axis_values(study, report.gradient_design));
}

std::vector<std::size_t> constraints_of(const SweepReport& report, std::span<const double> row, bool wanted_active) {
  const study::TallyJob& job = report.tally->job();
  std::vector<study::ConstraintValues> sides(job.limits.size());
  if (!sides.empty() && !row.empty()) job.sides(row, sides);
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < sides.size(); ++k)
    if (wanted_active ? study::active(sides[k], kActiveShare) : !study::meets(job.limits[k], sides[k]))
      found.push_back(k);
  return found;
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

std::vector<std::size_t> active_constraints(const SweepReport& report, std::span<const double> row) {
  return constraints_of(report, row, true);
}

std::vector<std::size_t> violated_constraints(const SweepReport& report, std::span<const double> row) {
  return constraints_of(report, row, false);
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
    report.indices = study::study_indices(sweep.study, sweep.columns, global.threads,
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

}  // namespace apps
