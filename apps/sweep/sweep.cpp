// SPDX-License-Identifier: Apache-2.0

// `mtf sweep STUDY -o DIR`, and the choice among its verbs.

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

#include "apps/study/rows/sweep_rows.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/sha256.h"
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

fs::path key_file(const fs::path& folder) { return parts_of(folder) / "key"; }

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

bool holds_key(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(key_file(folder), error);
}

/// True when the folder was left by a run that was killed before its key was written: it holds nothing but parts/, and
/// this nothing but the temporary of the key.
bool has_no_key_yet(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(parts_of(folder), error) || !holds_nothing(parts_of(folder))) return false;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().filename() != "parts" && !mtf::io::is_stage(entry.path().filename().string())) return false;
  return true;
}

bool is_of(const fs::path& folder, const study::RowLayout& layout) {
  return holds_key(folder) && first_line(key_file(folder)) == layout.key;
}

void prepare_parts(const fs::path& folder, const study::RowLayout& layout, const Global& global) {
  if (is_of(folder, layout)) {
    note(global, "note: " + one_line(folder.string()) + " holds a stopped sweep, which is continued");
    return;
  }
  std::error_code error;
  fs::remove_all(parts_of(folder), error);
  if (!error) fs::create_directory(parts_of(folder), error);
  if (error) throw mtf::RuntimeError("cannot create " + one_line(parts_of(folder).string()) + ": " + error.message());
  mtf::io::write_text_file(key_file(folder).string(), layout.key + "\n");
}

// Copies of a study and of all that it names, so that a folder is complete in itself.

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw mtf::RuntimeError(one_line(file.string()) + ": cannot be read");
  return bytes;
}

/// Names that a folder of results or a plan has for itself.
bool reserved(const fs::path& name) {
  constexpr std::array<std::string_view, 9> names{"study.toml",  "plan.json",   "sweep.json",
                                                  "designs.csv", "designs.npy", "columns.csv",
                                                  "parts",       "shards",      "chosen"};
  return std::find(names.begin(), names.end(), name.begin()->string()) != names.end();
}

fs::path home_of(const study::Study& study) { return fs::absolute(study.file).parent_path(); }

/// The name of a file from the folder of the study, as the study or its sensor writes it ("curves/../qe.csv"), so that
/// copies name each other as the files do; empty for a file elsewhere. A link counts where it lies.
fs::path name_of(const study::Study& study, const std::string& file) {
  const auto below = [](const fs::path& whole, const fs::path& home) {
    const fs::path name = whole.lexically_relative(home), simple = name.lexically_normal();
    return simple.empty() || *simple.begin() == ".." ? fs::path() : name;
  };
  const fs::path name = below(fs::absolute(file), home_of(study));
  return !name.empty() ? name : below(fs::weakly_canonical(fs::absolute(file)), fs::weakly_canonical(home_of(study)));
}

/// Why a sweep cannot take a copy of a file; "" where it can.
std::string problem_of(const study::Study& study, const std::string& file) {
  const fs::path name = name_of(study, file);
  if (name.empty())
    return one_line(file) + " lies outside of the study's folder " +
           one_line(home_of(study).lexically_normal().string()) +
           "; copy it to the folder of the study, so that the results can hold all files that they were made from";
  if (reserved(name) || reserved(name.lexically_normal()))
    return one_line(file) + " has a name that the folder of a sweep uses itself; rename it";
  return "";
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

// The folder of a sweep while it is made. parts/ holds the finished rows and parts/key, which says of what study,
// tolerance and version they are. A sweep is unfinished as long as the key is there: whenever it was stopped, the same
// command continues it. The key is the first file that is written and the first one removed, when all results are
// there.

fs::path parts_of(const fs::path& folder) { return folder / "parts"; }

void check_sweep_folder(const fs::path& folder, const study::RowLayout& layout, bool force) {
  std::error_code error;
  if (holds_key(folder)) {
    if (!is_of(folder, layout) && !force)
      throw mtf::UsageError(one_line(folder.string()) +
                            " holds a stopped sweep of another study, tolerance or version of mtf; choose another "
                            "folder, or --force to start over");
    return;
  }
  if (fs::exists(folder / "plan.json", error))
    throw mtf::UsageError(one_line(folder.string()) + " holds a plan and its shards; choose another folder");
}

std::unique_ptr<OutputSet> open_sweep_folder(const fs::path& folder, const study::RowLayout& layout,
                                             const std::vector<StudyCopy>& copies, std::vector<std::string> inputs,
                                             bool force, const Global& global) {
  check_sweep_folder(folder, layout, force);
  OutputPlan plan{.folder = folder.string(),
                  .force = force || holds_key(folder) || has_no_key_yet(folder),
                  .names = {"sweep.json", "designs.csv", "designs.npy", "columns.csv"},
                  .subfolders = {"chosen"},
                  .inputs = std::move(inputs)};
  for (const StudyCopy& copy : copies) plan.names.push_back(copy.name.lexically_normal().string());
  auto outputs = std::make_unique<OutputSet>(std::move(plan));
  prepare_parts(folder, layout, global);
  return outputs;
}

void close_sweep_folder(const fs::path& folder) {
  std::error_code ignored;
  fs::remove(key_file(folder), ignored);
  fs::remove_all(parts_of(folder), ignored);
}

std::vector<mtf::io::Diagnostic> copy_problems(const study::Study& study) {
  std::vector<mtf::io::Diagnostic> problems;
  for (const study::StudyFile& named : study::files_of(study))
    if (std::string problem = problem_of(study, named.file); !problem.empty())
      problems.push_back({.error = true, .position = named.position, .path = named.path, .text = std::move(problem)});
  return problems;
}

std::vector<StudyCopy> copies_of(const study::Study& study) {
  mtf::io::cfg::require_no_errors(copy_problems(study), study.file);
  std::vector<StudyCopy> copies{{"study.toml", study.text}};
  for (const study::StudyFile& named : study::files_of(study)) {
    const fs::path name = name_of(study, named.file);
    if (std::none_of(copies.begin(), copies.end(), [&](const StudyCopy& each) { return each.name == name; }))
      copies.push_back({name, bytes_of(named.file)});
  }
  return copies;
}

std::vector<std::string> inputs_of(const study::Study& study) {
  std::vector<std::string> inputs{study.file};
  for (study::StudyFile& named : study::files_of(study)) inputs.push_back(std::move(named.file));
  return inputs;
}

std::vector<study::PlanFile> write_copies(const std::vector<StudyCopy>& copies, OutputSet& outputs) {
  std::vector<study::PlanFile> files;
  for (const StudyCopy& copy : copies) {
    emit(outputs.in(copy.name.string()), copy.bytes);
    files.push_back({copy.name.generic_string(), mtf::io::sha256_hex(copy.bytes)});
  }
  return files;
}

std::vector<StudyCopy> copies_of(const std::vector<study::PlanFile>& files, const fs::path& from) {
  std::vector<StudyCopy> copies;
  for (const study::PlanFile& file : files) {
    copies.push_back({file.file, bytes_of(from / file.file)});
    if (mtf::io::sha256_hex(copies.back().bytes) != file.sha256)
      throw mtf::RuntimeError(one_line((from / file.file).string()) + ": changed while it was copied");
  }
  return copies;
}

}  // namespace apps
