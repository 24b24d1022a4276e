// SPDX-License-Identifier: Apache-2.0

// What the commands of trade studies take.

#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"
#include "apps/study/rows/shard_plan.h"

namespace apps {
namespace {

constexpr std::array kEngines{std::pair{std::string_view("slurm"), SweepOptions::Engine::slurm},
                              std::pair{std::string_view("parallel"), SweepOptions::Engine::parallel},
                              std::pair{std::string_view("local"), SweepOptions::Engine::local}};

constexpr std::array kSearch{std::pair{std::string_view("smooth"), false}, std::pair{std::string_view("search"), true}};

}  // namespace

Command sweep_command() {
  const auto shared = std::make_shared<SweepOptions>();
  SweepOptions& options = *shared;
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
  OptionSpec& words = add_text(app, "study", "[VERB] STUDY", "study file (TOML), or one of the verbs below and PLAN",
                               [&](const std::string& text) { options.words.push_back(text); });
  words.required = true;
  words.repeats = true;
  std::vector<std::string> first{""};  // a study file
  first.insert(first.end(), kSweepVerbs.begin(), kSweepVerbs.end());
  words.candidates = one_of(first);
  add_text(app, "-o,--out", "FOLDER", "folder to create: of results, or the plan", options.out);
  add_word(app, "--tolerance", "X", "error allowed to each metric, in place of the study's",
           [&](const std::string& text) {
             options.tolerance = number("--tolerance", text);
             if (!(*options.tolerance >= 1e-12 && *options.tolerance <= 0.1))
               throw mtf::UsageError("--tolerance: " + text + " is outside [1e-12, 0.1]");
           });
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_force(app, options.force);
  add_flag(app, "--accuracy", "measure the error against run time too, at every tolerance: takes longer",
           options.accuracy);
  add_word(app, "--shards", "N", "plan: how many",
           [&](const std::string& text) { options.shards = whole_number("--shards", text, 1, study::kMostShards); });
  add_word(app, "--shard", "I/N", "run: which one, such as 2/8",
           [&](const std::string& text) { options.shard = part_of("--shard", text); });
  add_word(app, "--engine", "NAME", "submit: slurm (a job array), parallel (GNU parallel) or local (one by one)",
           [&](const std::string& text) { options.engine = choice("--engine", text, kEngines); })
      .candidates = one_of(kEngines);
  add_flag(app, "--submit", "submit: run the script too", options.submit);
  app.run = [shared](const Global& global) { return run_sweep(*shared, global); };
  return app;
}

Command optimize_command() {
  const auto shared = std::make_shared<OptimizeCommandOptions>();
  OptimizeCommandOptions& options = *shared;
  Command app{
      "optimize", "the best design of a trade study, and what limits it",
      "Numeric axes are continuous from their lowest to their highest value, every combination of the values\n"
      "of other axes is tried (200 at most); links, constraints and objectives are those of the study. Reports\n"
      "which limits are active and what relaxing each would gain. Without a feasible design the nearest\n"
      "is shown with what contradicts, and the exit code is 3. Several objectives need --weights, --objective\n"
      "or --each.",
      "  mtf optimize study.toml --objective 1 -o best.toml\n"
      "  mtf optimize study.toml --weights 1,0.2 --format json --report best.json"};
  add_file(app, "study", "study file (TOML)", options.study);
  add_word(app, "--objective", "N", "take this one of several objectives, from 1",
           [&](const std::string& text) { options.objective = whole_number("--objective", text, 1, 1000); });
  add_word(app, "--weights", "A,B,...", "of all objectives as shown, in their order: what counts is the weighted sum",
           [&](const std::string& text) { options.weights = number_list("--weights", text); });
  add_flag(app, "--each", "each objective separately", options.each);
  add_choice(app, "--method", "METHOD", "smooth (default: by derivatives, going on as search) or search", kSearch,
             options.search);
  add_word(app, "--starts", "N",
           "searches from different designs, in each combination of values of discrete axes; default 8",
           [&](const std::string& text) { options.starts = whole_number("--starts", text, 1, 10'000); });
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_text(app, "-o,--out", "FILE",
           "sensor file of the best design; with --each a folder, with best-1.toml, best-2.toml, ...", options.out);
  add_text(app, "--report", "FILE", "everything that was found, as JSON", options.report);
  add_force(app, options.force);
  app.run = [shared](const Global& global) { return fits_module().optimize(*shared, global); };
  return app;
}

}  // namespace apps
