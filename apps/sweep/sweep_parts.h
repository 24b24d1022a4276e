// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf sweep` and its verbs share.

#include <filesystem>
#include <memory>

#include "apps/options.h"
#include "apps/study/design/evaluator.h"
#include "apps/study/rows/row_file.h"
#include "apps/study/rows/shard_plan.h"
#include "apps/terminal/output_set.h"

namespace apps {

/// A study with the layout of its rows.
struct SweepStudy {
  std::shared_ptr<const study::Study> study;
  std::vector<study::Column> columns;
  study::RowLayout layout;
};

/// Reads a study file; `tolerance` in place of the study's. Throws as load_study.
SweepStudy open_study(const std::filesystem::path& file, std::optional<double> tolerance);

/// A file that the folder of a sweep gets a copy of: its name there, and what is in it.
struct StudyCopy {
  std::filesystem::path name;
  std::string bytes;
};
/// Files that a sweep of the study cannot copy: they lie elsewhere than in or below its folder, or have a name that the
/// folder of a sweep uses itself.
std::vector<mtf::io::Diagnostic> copy_problems(const study::Study& study);
/// The study (as study.toml, the first), its sensor files and the files these name, by their names relative to the
/// study. Nothing is written. Throws UsageError with all copy_problems, RuntimeError.
std::vector<StudyCopy> copies_of(const study::Study& study);
/// Writes them into the folder. Throws RuntimeError.
std::vector<study::PlanFile> write_copies(const std::vector<StudyCopy>& copies, OutputSet& outputs);

/// What is in the files of a plan, each still as it was. Throws RuntimeError.
std::vector<StudyCopy> copies_of(const std::vector<study::PlanFile>& files, const std::filesystem::path& from);
/// The files that a study is read from.
std::vector<std::string> inputs_of(const study::Study& study);

/// The rows of a sweep that is being made.
std::filesystem::path parts_of(const std::filesystem::path& folder);
/// Throws where open_sweep_folder would, and changes nothing.
void check_sweep_folder(const std::filesystem::path& folder, const study::RowLayout& layout, bool force);
/// Makes the folder, or takes the one that a stopped run of the same study left. Throws UsageError for one that a
/// stopped run of another study left or that is not empty, unless `force`; the results in it stay until the new ones
/// take their place.
std::unique_ptr<OutputSet> open_sweep_folder(const std::filesystem::path& folder, const study::RowLayout& layout,
                                             const std::vector<StudyCopy>& copies, std::vector<std::string> inputs,
                                             bool force, const Global& global);
/// Removes the rows once all results are there: from now on the sweep is finished.
void close_sweep_folder(const std::filesystem::path& folder);

/// Makes the rows that are not there yet, with progress. `seconds`: what it took.
study::RowTally make_rows(const SweepStudy& sweep, study::RowRange range, const std::filesystem::path& folder,
                          const Global& global, double& seconds);
/// The run that make_rows makes or made.
study::RowRun row_run(const SweepStudy& sweep, study::RowRange range, const std::filesystem::path& folder,
                      const Global& global);

/// How the rows came about.
struct SweepRun {
  std::filesystem::path folder;  ///< as the user names it
  OutputSet* outputs = nullptr;  ///< into it
  std::vector<study::PlanFile> files;
  std::vector<study::RowPiece> pieces;
  study::RowTally tally;
  double seconds = 0.0;  ///< of making rows; NaN where that was done elsewhere
};

/// Everything after the rows: tables, counts, chosen designs, sensitivities, sweep.json, all put into place, and what
/// standard output says. Returns the exit code: 3 where --accuracy finds an error above its bound.
int finish_sweep(const SweepStudy& sweep, const SweepRun& run, const SweepOptions& options, const Global& global);

// The verbs.
int sweep_plan(const SweepOptions& options, const Global& global);
int sweep_run(const SweepOptions& options, const Global& global);
int sweep_merge(const SweepOptions& options, const Global& global);
int sweep_submit(const SweepOptions& options, const Global& global);

}  // namespace apps
