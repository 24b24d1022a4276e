// SPDX-License-Identifier: Apache-2.0

// Copies of a study and of all that it names, so that a folder is complete in itself.

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

#include "apps/sensor/sensor_file.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/terminal/output.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/sha256.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw mtf::RuntimeError(one_line(file.string()) + ": cannot be read");
  return bytes;
}

void write_below(const fs::path& folder, const fs::path& name, const std::string& bytes) {
  std::error_code error;
  fs::create_directories((folder / name).parent_path(), error);
  if (error) throw mtf::RuntimeError("cannot create a folder for " + one_line(name.string()) + ": " + error.message());
  mtf::io::write_text_file((folder / name).string(), bytes);
}

/// Names that a folder of results or a plan has for itself.
bool reserved(const fs::path& name) {
  constexpr std::array<std::string_view, 9> names{"study.toml",  "plan.json",   "sweep.json",
                                                  "designs.csv", "designs.npy", "columns.csv",
                                                  "parts",       "shards",      "chosen"};
  return std::find(names.begin(), names.end(), name.begin()->string()) != names.end();
}

}  // namespace

std::vector<StudyCopy> copies_of(const study::Study& study) {
  const fs::path home = fs::weakly_canonical(fs::absolute(study.file)).parent_path();
  std::vector<StudyCopy> copies{{"study.toml", study.text}};
  for (const std::string& file : study::files_of(study)) {
    const fs::path name = fs::weakly_canonical(fs::absolute(file)).lexically_relative(home);
    if (name.empty() || *name.begin() == "..")
      throw mtf::UsageError(
          one_line(file) + ": lies outside of the study's folder " + one_line(home.string()) +
          "; copy it to the folder of the study, so that the results can hold all files that they were made from");
    if (reserved(name))
      throw mtf::UsageError(one_line(file) + ": has a name that the folder of a sweep uses itself; rename it");
    if (std::none_of(copies.begin(), copies.end(), [&](const StudyCopy& each) { return each.name == name; }))
      copies.push_back({name, bytes_of(file)});
  }
  return copies;
}

std::vector<study::PlanFile> write_copies(const std::vector<StudyCopy>& copies, const fs::path& folder) {
  std::vector<study::PlanFile> files;
  for (const StudyCopy& copy : copies) {
    write_below(folder, copy.name, copy.bytes);
    files.push_back({copy.name.generic_string(), mtf::io::sha256_hex(copy.bytes)});
  }
  return files;
}

void copy_files(const std::vector<study::PlanFile>& files, const fs::path& from, const fs::path& to) {
  for (const study::PlanFile& file : files) {
    const std::string bytes = bytes_of(from / file.file);
    if (mtf::io::sha256_hex(bytes) != file.sha256)
      throw mtf::RuntimeError(one_line((from / file.file).string()) + ": changed while it was copied");
    write_below(to, file.file, bytes);
  }
}

}  // namespace apps
