// SPDX-License-Identifier: Apache-2.0

// The folder of a sweep while it is made. parts/ holds the finished rows and parts/key, which says of what study,
// tolerance and version they are. A sweep is unfinished as long as the key is there: whenever it was stopped, the same
// command continues it. The key is the first file that is written and the first one that is removed, when all results
// are there.

#include <fstream>

#include "apps/sweep/sweep_parts.h"
#include "apps/terminal/output.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

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

}  // namespace apps
