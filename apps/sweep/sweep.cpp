// SPDX-License-Identifier: Apache-2.0

// `mtf sweep STUDY -o DIR`, and the choice among its verbs.

#include <algorithm>

#include "apps/study/rows/sweep_rows.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

/// The options that only some verbs take.
struct Verb {
  std::string_view name;
  int (*run)(const SweepOptions&, const Global&);
  bool out, tolerance, shards, shard, engine, accuracy;
};

constexpr std::array kVerbs{Verb{"plan", sweep_plan, true, true, true, false, false, false},
                            Verb{"run", sweep_run, false, false, false, true, false, false},
                            Verb{"merge", sweep_merge, true, false, false, false, false, true},
                            Verb{"submit", sweep_submit, false, false, false, false, true, false}};

void check_options(const SweepOptions& options, const std::string& command, const Verb& takes) {
  const auto refuse = [&](std::string_view option, bool given, bool taken) {
    if (given && !taken)
      throw mtf::UsageError(std::string(option) + ": `" + command + "` does not take it; see mtf sweep --help");
  };
  refuse("--out", !options.out.empty(), takes.out);
  refuse("--force", options.force, takes.out);
  refuse("--tolerance", options.tolerance.has_value(), takes.tolerance);
  refuse("--shards", options.shards.has_value(), takes.shards);
  refuse("--shard", options.shard.has_value(), takes.shard);
  refuse("--engine", options.engine.has_value(), takes.engine);
  refuse("--submit", options.submit, takes.engine);
  refuse("--accuracy", options.accuracy, takes.accuracy);
  if (takes.out && options.out.empty())
    throw mtf::UsageError("--out: `" + command + "` needs a folder to write; add -o FOLDER");
}

int sweep_here(const SweepOptions& options, const Global& global) {
  const fs::path folder = options.out;
  const SweepStudy named = open_study(options.words[0], options.tolerance);
  for (const auto& warning : named.study->warnings)
    note(global, one_line(mtf::io::format_diagnostic(warning, options.words[0])));
  const std::vector<StudyCopy> copies = copies_of(*named.study);
  const std::unique_ptr<OutputSet> outputs =
      open_sweep_folder(folder, named.layout, copies, inputs_of(*named.study), options.force, global);
  SweepRun run;
  run.folder = folder;
  run.outputs = outputs.get();
  run.files = write_copies(copies, *outputs);
  // From the copies: what is in the folder is what the rows were made of.
  const SweepStudy sweep = open_study(outputs->in("study.toml"), options.tolerance);
  const study::RowRange all{0, sweep.study->designs};
  int status = 0;
  {
    const InterruptNote interrupted("mtf: finished designs are kept; the same command continues with the others\n");
    run.tally = make_rows(sweep, all, parts_of(folder), global, run.seconds);
    run.pieces = study::rows_of(row_run(sweep, all, parts_of(folder), global));
    status = finish_sweep(sweep, run, options, global);
  }
  close_sweep_folder(folder);
  return status;
}

}  // namespace

SweepStudy open_study(const fs::path& file, std::optional<double> tolerance) {
  SweepStudy sweep;
  sweep.study = study::load_study(file.string());
  if (tolerance) {
    study::Study other = *sweep.study;
    other.tolerance = *tolerance;
    sweep.study = std::make_shared<const study::Study>(std::move(other));
  }
  sweep.columns = study::columns_of(*sweep.study);
  sweep.layout = study::layout_of(*sweep.study, sweep.columns);
  return sweep;
}

study::RowRun row_run(const SweepStudy& sweep, study::RowRange range, const fs::path& folder, const Global& global) {
  return {.layout = sweep.layout,
          .range = range,
          .folder = folder,
          .threads = global.threads,
          .make = study::row_makers(sweep.study)};
}

study::RowTally make_rows(const SweepStudy& sweep, study::RowRange range, const fs::path& folder, const Global& global,
                          double& seconds) {
  ProgressLine progress(global);
  const mtf::Stopwatch watch;
  study::RowRun run = row_run(sweep, range, folder, global);
  run.done = [&](std::int64_t done) {
    progress.update("designs", static_cast<double>(done) / static_cast<double>(range.count),
                    significant(static_cast<double>(done) / std::max(1e-3, watch.seconds()), 3) + " designs/s");
  };
  const study::RowTally tally = study::run_rows(run);
  seconds = watch.seconds();
  return tally;
}

int run_sweep(const SweepOptions& options, const Global& global) {
  const auto verb = std::ranges::find_if(kVerbs, [&](const Verb& each) { return each.name == options.words.front(); });
  const bool is_verb = verb != kVerbs.end();
  const std::string command = "mtf sweep" + (is_verb ? " " + std::string(verb->name) : "");
  if (options.words.size() > (is_verb ? 2U : 1U)) {
    if (is_verb) throw mtf::UsageError(command + ": takes one name, not " + one_line(options.words[2]) + " too");
    const auto meant = mtf::nearest(options.words[0], kSweepVerbs);
    throw mtf::UsageError("mtf sweep: takes one study; '" + one_line(options.words[0]) + "' is no verb" +
                          (meant ? "; did you mean " + *meant + "?" : " (plan, run, merge or submit)"));
  }
  if (!is_verb) {
    check_options(options, command, {"", nullptr, true, true, false, false, false, true});
    return sweep_here(options, global);
  }
  if (options.words.size() == 1)
    throw mtf::UsageError(command + ": needs the name of " + (verb->name == "plan" ? "a study" : "a plan's folder") +
                          " after it; a study file named " + std::string(verb->name) + " is given as ./" +
                          std::string(verb->name));
  check_options(options, command, *verb);
  return verb->run(options, global);
}

}  // namespace apps
