// SPDX-License-Identifier: Apache-2.0

// What the commands of trade studies take.

#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"
#include "apps/study/rows/shard_plan.h"

namespace apps {
namespace {

constexpr auto kEngines = enumerated<SweepOptions::Engine>("slurm", "parallel", "local");
constexpr auto kSearch = enumerated<bool>("smooth", "search");

}  // namespace

Command sweep_command() {
  Command app{"sweep", "every design of a trade study, here or in shards on many machines",
              "Writes a folder with designs.csv, designs.npy, columns.csv (units), sweep.json, the study with its\n"
              "sensor files, and sensor files of the best designs. A run that was stopped continues when the same "
              "command is given again.\n"
              "--accuracy compares a sample of the designs at every tolerance with a tight one; where a difference is\n"
              "larger than the stated error, the files are written and the exit code is 3.\n\n"
              "Beyond one machine, in a folder PLAN that all of them share:\n"
              "  mtf sweep plan STUDY -o PLAN --shards N      copies the study and cuts its designs into N shards\n"
              "  mtf sweep run PLAN --shard I/N               makes shard I, from 1; without --shard that of\n"
              "                                               SLURM_ARRAY_TASK_ID; one that is finished stays\n"
              "  mtf sweep submit PLAN --engine slurm|parallel|local [--submit]\n"
              "                                               shows the script that runs all shards, and runs it\n"
              "  mtf sweep merge PLAN -o FOLDER               the same bytes as `mtf sweep STUDY -o FOLDER`\n"
              "A study file named like one of these words is given as ./plan.",
              "  mtf sweep study.toml -o sweep\n"
              "  mtf sweep plan study.toml -o plan --shards 4"};
  auto& options = options_of<SweepOptions>(app, run_sweep);
  OptionSpec& words =
      add_text(app, "study", "[VERB] STUDY", "study file (TOML), or one of the verbs below and PLAN", options.words);
  words.required = true;
  std::vector<std::string> first{""};  // a study file
  first.insert(first.end(), kSweepVerbs.begin(), kSweepVerbs.end());
  words.candidates = one_of(first);
  add_text(app, "-o,--out", "FOLDER", "folder to create: of results, or the plan", options.out);
  add_value(app, "--tolerance", "X", "error allowed to each metric, in place of the study's", options.tolerance,
            within(1e-12, 0.1, " is outside [1e-12, 0.1]"));
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_force(app, options.force);
  add_flag(app, "--accuracy", "measure the error against run time too, at every tolerance: takes longer",
           options.accuracy);
  add_value(app, "--shards", "N", "plan: how many", options.shards, whole(1, study::kMostShards));
  add_value(app, "--shard", "I/N", "run: which one, such as 2/8", options.shard, part_of);
  add_choice(app, "--engine", "NAME", "submit: slurm (a job array), parallel (GNU parallel) or local (one by one)",
             kEngines, options.engine);
  add_flag(app, "--submit", "submit: run the script too", options.submit);
  return app;
}

Command optimize_command() {
  Command app{
      "optimize", "the best design of a trade study, and what limits it",
      "Numeric axes are continuous from their lowest to their highest value, every combination of the values\n"
      "of other axes is tried (200 at most); links, constraints and objectives are those of the study. Reports\n"
      "which limits are active and what relaxing each would gain. Without a feasible design the nearest\n"
      "is shown with what contradicts, and the exit code is 3. Several objectives need --weights, --objective\n"
      "or --each.",
      "  mtf optimize study.toml --objective 1 -o best.toml\n"
      "  mtf optimize study.toml --weights 1,0.2 --format json --report best.json"};
  auto& options = options_of<OptimizeCommandOptions>(
      app, [](const auto& given, const Global& global) { return fits_module().optimize(given, global); });
  add_file(app, "study", "study file (TOML)", options.study);
  add_value(app, "--objective", "N", "take this one of several objectives, from 1", options.objective, whole(1, 1000));
  add_value(app, "--weights", "A,B,...", "of all objectives as shown, in their order: what counts is the weighted sum",
            options.weights, number_list);
  add_flag(app, "--each", "each objective separately", options.each);
  add_choice(app, "--method", "METHOD", "smooth (default: by derivatives, going on as search) or search", kSearch,
             options.search);
  add_value(app, "--starts", "N",
            "searches from different designs, in each combination of values of discrete axes; default 8",
            options.starts, whole(1, 10'000));
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_text(app, "-o,--out", "FILE",
           "sensor file of the best design; with --each a folder, with best-1.toml, best-2.toml, ...", options.out);
  add_text(app, "--report", "FILE", "everything that was found, as JSON", options.report);
  add_force(app, options.force);
  return app;
}

}  // namespace apps
