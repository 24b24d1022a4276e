// SPDX-License-Identifier: Apache-2.0

// The folder of a sweep while it is made. parts/ holds the finished rows and parts/key, which says of what study,
// tolerance and version they are. A sweep is unfinished as long as the key is there: whenever it was stopped, the same
// command continues it. The key is the first file that is written and the first one that is removed, when all results
// are there.

#include <algorithm>
#include <fstream>

#include "apps/sweep/output_folder.h"
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
  const auto names = [](const fs::path& of) {
    std::vector<std::string> found;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(of, error))
      found.push_back(entry.path().filename().string());
    return found;
  };
  const auto inside = names(parts_of(folder));
  return names(folder) == std::vector<std::string>{"parts"} &&
         std::all_of(inside.begin(), inside.end(), [](const std::string& name) { return name.starts_with("key."); });
}

/// The files that a sweep writes, apart from copies.
void remove_results(const fs::path& folder) {
  for (const char* name : {"parts", "chosen", "sweep.json", "designs.csv", "designs.npy", "columns.csv"}) {
    std::error_code error;
    fs::remove_all(folder / name, error);
    if (error) throw mtf::RuntimeError("cannot remove " + one_line((folder / name).string()) + ": " + error.message());
  }
}

}  // namespace

fs::path parts_of(const fs::path& folder) { return folder / "parts"; }

void check_sweep_folder(const fs::path& folder, const study::RowLayout& layout, bool force) {
  std::error_code error;
  if (holds_key(folder)) {
    if (first_line(key_file(folder)) != layout.key && !force)
      throw mtf::UsageError(one_line(folder.string()) +
                            " holds a stopped sweep of another study, tolerance or version of mtf; choose another "
                            "folder, or --force to start over");
    return;
  }
  if (fs::exists(folder / "plan.json", error))
    throw mtf::UsageError(one_line(folder.string()) + " holds a plan and its shards; choose another folder");
  check_folder(folder, force || has_no_key_yet(folder));
}

void open_sweep_folder(const fs::path& folder, const study::RowLayout& layout, bool force, const Global& global) {
  check_sweep_folder(folder, layout, force);
  if (holds_key(folder) && first_line(key_file(folder)) == layout.key) {
    note(global, "note: " + one_line(folder.string()) + " holds a stopped sweep, which is continued");
    return;
  }
  prepare_folder(folder, true);
  remove_results(folder);
  std::error_code error;
  fs::create_directory(parts_of(folder), error);
  if (error) throw mtf::RuntimeError("cannot create " + one_line(parts_of(folder).string()) + ": " + error.message());
  mtf::io::write_text_file(key_file(folder).string(), layout.key + "\n");
}

void close_sweep_folder(const fs::path& folder) {
  std::error_code ignored;
  fs::remove(key_file(folder), ignored);
  fs::remove_all(parts_of(folder), ignored);
}

}  // namespace apps
