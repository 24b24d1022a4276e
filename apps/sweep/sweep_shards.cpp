// SPDX-License-Identifier: Apache-2.0

// The verbs of `mtf sweep` for more than one machine: plan, run, merge, submit.

#include <sys/stat.h>
#include <sys/wait.h>

#include <cstdlib>
#include <limits>

#include "apps/arguments.h"
#include "apps/study/rows/shard_plan.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/version.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

/// The plan in a folder and its study, which has to give rows that belong to the plan.
struct OpenPlan {
  study::ShardPlan plan;
  SweepStudy sweep;
};

OpenPlan open_plan(const fs::path& folder) {
  OpenPlan open;
  open.plan = study::read_plan(folder);
  if (open.plan.version != mtf::version || open.plan.commit != mtf::git_commit)
    throw mtf::UsageError(one_line(folder.string()) + ": planned by mtf " + one_line(open.plan.version) + " (" +
                          one_line(open.plan.commit) + "), this is " + mtf::version + " (" + mtf::git_commit +
                          "); use the same build for all shards, or make a new plan");
  open.sweep = open_study(folder / "study.toml", open.plan.tolerance);
  if (open.sweep.layout != open.plan.layout || open.sweep.study->designs != open.plan.designs)
    throw mtf::UsageError(one_line(folder.string()) +
                          ": its study is not the one that was planned; make a new plan in another folder");
  return open;
}

std::string shard_text(const study::ShardPlan& plan, int shard) {
  return "shard " + std::to_string(shard) + "/" + std::to_string(plan.shards) + " (" +
         describe(study::shard_range(plan, shard)) + ")";
}

/// From --shard, else from the job array that this is a task of.
int shard_of(const SweepOptions& options, const study::ShardPlan& plan) {
  if (options.shard) {
    const auto [shard, shards] = *options.shard;
    if (shards != plan.shards)
      throw mtf::UsageError("--shard: the plan has " + std::to_string(plan.shards) + " shards, not " +
                            std::to_string(shards));
    return shard;
  }
  const char* task = std::getenv("SLURM_ARRAY_TASK_ID");
  if (task == nullptr)
    throw mtf::UsageError(
        "--shard: not given, and this is no task of a Slurm job array (SLURM_ARRAY_TASK_ID); name the "
        "shard, such as --shard 1/" +
        std::to_string(plan.shards));
  return whole_number("SLURM_ARRAY_TASK_ID", task, 1, plan.shards);
}

/// Whether the file of a shard is whole; a damaged one is made again with a note. Throws for a foreign one: it may be
/// all that is left of another plan.
bool finished(const study::ShardPlan& plan, const fs::path& folder, int shard, const Global& global) {
  try {
    return !study::find_shard(plan, folder, shard).empty();
  } catch (const study::DamagedRows& error) {
    note(global, std::string("note: ") + error.what() + "; making it again");
    return false;
  }
}

/// Makes the rows of a shard and puts them into its file. Throws as run_rows.
study::RowTally make_shard(const OpenPlan& open, const fs::path& file, study::RowRange range, const Global& global,
                           double& seconds) {
  const fs::path pieces = study::parts_folder(file);
  const study::RowTally tally = make_rows(open.sweep, range, pieces, global, seconds);
  study::join_rows(study::rows_of(row_run(open.sweep, range, pieces, global)), file);
  study::remove_parts(file);
  return tally;
}

}  // namespace

int sweep_plan(const SweepOptions& options, const Global& global) {
  if (!options.shards) throw mtf::UsageError("--shards: not given; say how many, such as --shards 8");
  const SweepStudy sweep = open_study(options.words[1], options.tolerance);
  for (const auto& warning : sweep.study->warnings)
    note(global, one_line(mtf::io::format_diagnostic(warning, options.words[1])));
  if (*options.shards > sweep.study->designs)
    throw mtf::UsageError("--shards: " + std::to_string(*options.shards) + " are more than the study has designs (" +
                          std::to_string(sweep.study->designs) + ")");
  const fs::path folder = options.out;
  const std::size_t made = study::files_in_shards(folder).size();
  if (made > 0)
    throw mtf::UsageError(one_line(folder.string()) + " holds " + std::to_string(made) +
                          " finished shards; choose another folder, or remove " +
                          one_line((folder / "shards").string()) + " when they are not needed");
  const std::vector<StudyCopy> copies = copies_of(*sweep.study);
  OutputPlan files{
      .folder = options.out, .force = options.force, .names = {"plan.json"}, .inputs = inputs_of(*sweep.study)};
  for (const StudyCopy& copy : copies) files.names.push_back(copy.name.lexically_normal().string());
  OutputSet outputs(std::move(files));
  study::ShardPlan plan{.version = mtf::version,
                        .commit = mtf::git_commit,
                        .name = sweep.study->name,
                        .study_sha256 = sweep.study->sha256,
                        .tolerance = sweep.study->tolerance,
                        .designs = sweep.study->designs,
                        .shards = *options.shards,
                        .layout = sweep.layout,
                        .files = write_copies(copies, outputs)};
  study::write_plan(plan, outputs.in(""));
  open_plan(outputs.in(""));  // what every shard will do first
  outputs.commit();
  const std::string word = shell_word(options.out), first = "1/" + std::to_string(plan.shards);
  print(one_line(options.out) + "  " + std::to_string(plan.designs) + " designs in " + std::to_string(plan.shards) +
        " shards\n  mtf sweep run " + word + " --shard " + first + "\n  mtf sweep submit " + word +
        " --engine slurm\n  mtf sweep merge " + word + " -o FOLDER\n");
  return 0;
}

int sweep_run(const SweepOptions& options, const Global& global) {
  const fs::path folder = options.words[1];
  const OpenPlan open = open_plan(folder);
  const int shard = shard_of(options, open.plan);
  const fs::path file = study::shard_file(open.plan, folder, shard);
  if (finished(open.plan, folder, shard, global)) {
    study::remove_parts(file);  // of a run that was killed just before it did so
    print(shard_text(open.plan, shard) + " is finished already: nothing to do\n");
    return 0;
  }
  const InterruptNote interrupted("mtf: finished designs are kept; the same command continues with the others\n");
  double seconds = 0.0;
  study::RowTally tally;
  try {
    tally = make_shard(open, file, study::shard_range(open.plan, shard), global, seconds);
  } catch (const mtf::RuntimeError&) {
    // A task that was queued again while it still ran: the first to finish removes what both were making.
    if (!finished(open.plan, folder, shard, global)) throw;
    study::remove_parts(file);
    print(shard_text(open.plan, shard) + " was finished by another process meanwhile\n");
    return 0;
  }
  print(shard_text(open.plan, shard) + ": " + std::to_string(tally.made) + " designs in " + fixed(seconds, 2) + " s" +
        (tally.resumed > 0 ? ", " + std::to_string(tally.resumed) + " were there" : "") + "\n");
  return 0;
}

int sweep_merge(const SweepOptions& options, const Global& global) {
  const fs::path plan_folder = options.words[1], folder = options.out;
  const OpenPlan open = open_plan(plan_folder);
  check_sweep_folder(folder, open.plan.layout, options.force);
  SweepRun run;
  run.folder = folder;
  run.files = open.plan.files;
  run.pieces = study::all_shards(open.plan, plan_folder);
  run.tally.resumed = open.plan.designs;
  run.seconds = std::numeric_limits<double>::quiet_NaN();
  const std::vector<StudyCopy> copies = copies_of(run.files, plan_folder);
  const std::unique_ptr<OutputSet> outputs =
      open_sweep_folder(folder, open.plan.layout, copies, inputs_of(*open.sweep.study), options.force, global);
  run.outputs = outputs.get();
  write_copies(copies, *outputs);
  const int code = finish_sweep(open_study(outputs->in("study.toml"), open.plan.tolerance), run, options, global);
  close_sweep_folder(folder);
  for (int shard = 1; shard <= open.plan.shards; ++shard)
    study::remove_parts(study::shard_file(open.plan, plan_folder, shard));
  return code;
}

int sweep_submit(const SweepOptions& options, const Global& global) {
  if (!options.engine) throw mtf::UsageError("--engine: not given; one of slurm, parallel, local");
  const fs::path folder = options.words[1];
  const OpenPlan open = open_plan(folder);
  const auto engine = static_cast<study::Engine>(*options.engine);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const std::string script = study::submit_script({.engine = engine,
                                                   .command = error ? "mtf" : program.string(),
                                                   .plan = fs::absolute(folder).lexically_normal().string(),
                                                   .name = open.plan.name,
                                                   .shards = open.plan.shards,
                                                   .threads = global.threads});
  const std::string file = (folder / study::script_name(engine)).string();
  mtf::io::write_text_file(file, script);
  static_cast<void>(::chmod(file.c_str(), 0755));
  print(script);
  if (!options.submit) {
    note(global, "note: written to " + one_line(file) + "; --submit runs it");
    return 0;
  }
  const bool slurm = engine == study::Engine::slurm;
  const std::string runner = slurm ? "sbatch --chdir " + shell_word(folder.string()) : "sh";
  const int status = std::system((runner + " " + shell_word(file)).c_str());
  const int code = status >= 0 && WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  if (code == 127)
    throw mtf::RuntimeError(std::string(slurm                               ? "sbatch"
                                        : engine == study::Engine::parallel ? "parallel"
                                                                            : "sh") +
                            ": is not on this machine's PATH; install it (./apps/setup slurm), or choose another "
                            "--engine");
  if (code != 0)
    throw mtf::RuntimeError("`" + runner + " " + shell_word(file) + "` ended with " + std::to_string(code) +
                            "; finished shards stay, the same command continues with the others");
  return 0;
}

}  // namespace apps
