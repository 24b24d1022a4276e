// SPDX-License-Identifier: Apache-2.0

// Copies of a study and of all that it names, so that a folder is complete in itself.

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

#include "apps/config.h"
#include "apps/sweep/sweep_parts.h"
#include "apps/terminal/output.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
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

/// Names that a folder of results or a plan has for itself.
bool reserved(const fs::path& name) {
  constexpr std::array<std::string_view, 9> names{"study.toml",  "plan.json",   "sweep.json",
                                                  "designs.csv", "designs.npy", "columns.csv",
                                                  "parts",       "shards",      "chosen"};
  return std::find(names.begin(), names.end(), name.begin()->string()) != names.end();
}

fs::path home_of(const study::Study& study) { return fs::absolute(study.file).parent_path(); }

/// The name of a file from the folder of the study, as the study or its sensor writes it ("curves/../qe.csv"), so that
/// copies name each other as the files do; empty for a file elsewhere. A link counts where it lies, not where it
/// points.
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
