// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/output_set.h"

#include <unistd.h>

#include <algorithm>
#include <system_error>

#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

void check_place(const std::string& folder) {
  std::error_code error;
  fs::path whole = fs::absolute(folder, error).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // "demo/" is "demo"
  const fs::path parent = whole.parent_path();
  if (!fs::is_directory(parent, error))
    throw mtf::RuntimeError("cannot create " + one_line(folder) + ": there is no folder " + one_line(parent.string()));
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    throw mtf::UsageError(one_line(folder) + " exists and is not a folder; choose another name");
}

/// True where the folder is new.
bool make_folder(const std::string& folder) {
  std::error_code error;
  const bool made = fs::create_directory(folder, error);
  if (error) throw mtf::RuntimeError("cannot create " + one_line(folder) + ": " + error.message());
  return made;
}

/// A device or pipe is written directly.
bool is_direct(const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return file.empty() || file == "-" ||
         (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status));
}

bool lies_below(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

}  // namespace

bool holds_nothing(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (!mtf::io::is_stage(entry.path().filename().string()) && !mtf::io::is_dead_temporary(entry.path().string()))
      return false;
  return true;
}

OutputSet::NewFolder::~NewFolder() {
  if (!path.empty()) ::rmdir(path.c_str());  // where it is empty
}

OutputSet::OutputSet(OutputPlan plan) : plan_(std::move(plan)) {
  while (plan_.folder.size() > 1 && plan_.folder.ends_with('/')) plan_.folder.pop_back();
  std::erase_if(plan_.files, is_direct);
  std::erase(plan_.inputs, "");
  const std::string& folder = plan_.folder;
  std::vector<std::string> outputs = plan_.files;
  if (!folder.empty()) {
    check_place(folder);
    if (make_folder(folder)) fresh_.path = folder;
    for (const std::string& name : plan_.names) outputs.push_back(folder + "/" + name);
    for (const std::string& name : plan_.subfolders)
      for (const std::string& input : plan_.inputs)
        if (lies_below(place_of(input), place_of(folder + "/" + name)))
          throw mtf::UsageError(one_line(folder) + " holds " + one_line(input) +
                                ", which this run reads and would replace; choose another folder");
  }
  require_writable(outputs, plan_.inputs);
  if (!folder.empty()) whole_ = std::make_unique<mtf::io::Stage>(folder, "", !fresh_.path.empty(), one_line(folder));
  // Only now is what a killed process had finished in its place.
  if (!folder.empty() && !plan_.force && !holds_nothing(folder))
    throw mtf::UsageError(one_line(folder) + " is not empty; choose another folder, or --force to replace files in it");
  for (const std::string& file : plan_.files) static_cast<void>(at(file));
}

OutputSet::~OutputSet() = default;

std::string OutputSet::in(const std::string& name) {
  for (const std::string& input : plan_.inputs) require_different(input, plan_.folder + "/" + name);
  return whole_->at(name);
}

mtf::io::Stage& OutputSet::stage_of(const std::string& folder, const std::string& file) {
  const auto known = std::find_if(places_.begin(), places_.end(), [&](const Place& p) { return p.folder == folder; });
  if (known != places_.end()) return *known->stage;
  places_.push_back(
      {folder, std::make_unique<mtf::io::Stage>(folder, fs::path(file).filename().string(), false, one_line(file))});
  return *places_.back().stage;
}

std::string OutputSet::at(const std::string& file) {
  if (is_direct(file)) return file;
  for (const std::string& input : plan_.inputs) require_different(input, file);
  std::error_code error;
  const std::string place = fs::is_symlink(fs::symlink_status(file, error)) ? place_of(file).string() : file;
  return stage_of(mtf::io::folder_of_file(place), place).at(fs::path(place).filename().string());
}

void OutputSet::commit() {
  std::vector<mtf::io::Stage*> stages;
  const auto take = [&](mtf::io::Stage& stage, const std::string& folder) {
    for (const std::string& name : stage.names())  // also what nobody asked a place for
      for (const std::string& input : plan_.inputs) require_different(input, folder + "/" + name);
    stages.push_back(&stage);
  };
  for (const Place& place : places_) take(*place.stage, place.folder);
  if (whole_) take(*whole_, plan_.folder);
  const mtf::io::Unstopped together;
  std::vector<std::string> gone = plan_.names;
  gone.insert(gone.end(), plan_.subfolders.begin(), plan_.subfolders.end());
  try {
    for (mtf::io::Stage* stage : stages) stage->make_ready(stage == whole_.get() ? gone : std::vector<std::string>());
    for (mtf::io::Stage* stage : stages) stage->move();
  } catch (...) {
    for (mtf::io::Stage* stage : stages) stage->undo();
    throw;
  }
  for (mtf::io::Stage* stage : stages) stage->finish();
  // Of the next commit nothing goes.
  plan_.names.clear();
  plan_.subfolders.clear();
  fresh_.path.clear();
}

void OutputSet::commit(const std::string& file, std::string_view text) {
  const bool later = is_direct(file);
  if (!later) emit(at(file), text);
  commit();
  if (later) emit(file, text);
}

}  // namespace apps
