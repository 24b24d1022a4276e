// SPDX-License-Identifier: Apache-2.0

// What the commands about trade studies take.

#include "apps/command_line.h"
#include "apps/commands.h"

namespace apps {
namespace {

constexpr std::array kSearch{std::pair{std::string_view("smooth"), false}, std::pair{std::string_view("search"), true}};

}  // namespace

Command optimize_command() {
  const auto shared = std::make_shared<OptimizeCommandOptions>();
  OptimizeCommandOptions& options = *shared;
  Command app{
      "optimize", "the best design of a trade study, and what limits it",
      "Numeric axes go continuously from their lowest to their highest value, every combination of the levels\n"
      "of other axes is tried (200 at most); links, constraints and objectives are those of the study. Reports\n"
      "which limits are reached and what more room in each would gain. Without a feasible design the nearest\n"
      "is shown with what contradicts, and the exit code is 3. Several objectives need --weights, --objective\n"
      "or --each.",
      "  mtf optimize study.toml --objective 1 -o best.toml\n"
      "  mtf optimize study.toml --weights 1,0.2 --format json --report best.json"};
  add_file(app, "study", "study file (TOML)", options.study);
  add_word(app, "--objective", "N", "take this one of several objectives, from 1",
           [&](const std::string& text) { options.objective = whole_number("--objective", text, 1, 1000); });
  add_word(app, "--weights", "A,B,...", "of all objectives as shown, in their order: what counts is the weighted sum",
           [&](const std::string& text) { options.weights = number_list("--weights", text); });
  add_flag(app, "--each", "every objective for itself", options.each);
  add_choice(app, "--method", "METHOD", "smooth (default: by derivatives, going on as search) or search", kSearch,
             options.search);
  add_word(app, "--starts", "N", "searches from different designs, in each combination of levels; default 8",
           [&](const std::string& text) { options.starts = whole_number("--starts", text, 1, 10'000); });
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_text(app, "-o,--out", "FILE",
           "sensor file of the best design; with --each a folder, with best-1.toml, best-2.toml, ...", options.out);
  add_text(app, "--report", "FILE", "everything that was found, as JSON", options.report);
  add_force(app, options.force);
  app.run = [shared](const Global& global) { return run_optimize(*shared, global); };
  return app;
}

}  // namespace apps
