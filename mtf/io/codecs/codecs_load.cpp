// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/code_folder.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/opencv_filters.h"
#include "mtf/io/csv/number_text.h"
#include "mtf/io/file_checks.h"

namespace mtf::io {
namespace {

namespace fs = std::filesystem;

/// A part of the toolkit in a file of its own.
struct Module {
  const char* file;
  const char* variable;  ///< of the environment, names the file
  const char* what;      ///< "the PNG and TIFF codecs"
  const char* package;   ///< of Debian, that has it
};

constexpr Module kCodecs{"libmtfkit_codecs.so", "MTFKIT_CODECS", "the PNG and TIFF codecs", "mtfkit"};
constexpr Module kOpenCv{"libmtfkit_opencv.so", "MTFKIT_OPENCV", "OpenCV", "mtfkit-codecs"};

bool is_chosen(const Module& module) {
  const char* chosen = std::getenv(module.variable);
  return chosen != nullptr && *chosen != '\0';
}

std::vector<fs::path> candidates(const Module& module) {
  if (is_chosen(module)) return {std::getenv(module.variable)};
  const fs::path here = code_folder(reinterpret_cast<const void*>(&codecs));
  std::vector<fs::path> paths{here / module.file, here / "mtfkit" / module.file};
  // Build folder and prefix have the same shape; test programs and Python's modules lie deeper than the command.
  constexpr int depth = 4;
  fs::path up = here;
  for (int folder = 0; folder < depth && up != up.root_path(); ++folder) {
    up = up.parent_path();
    for (const char* libraries : {MTFKIT_LIBDIR, "lib"}) paths.push_back(up / libraries / "mtfkit" / module.file);
  }
  return paths;
}

/// What the function of the module's table of this name gives; `version` is that of its header.
template <class Table>
const Table* table_of(const Module& module, void* handle, const char* symbol, int version, const std::string& path) {
  const auto factory = reinterpret_cast<const Table* (*)()>(::dlsym(handle, symbol));
  const Table* table = factory != nullptr ? factory() : nullptr;
  if (table == nullptr || table->version != version)
    throw RuntimeError("cannot use " + std::string(module.what) + " in " + path +
                       ": the file belongs to another version of mtfkit; rebuild, or install " + module.package +
                       " again");
  return table;
}

template <class Table>
const Table* load(const Module& module, const char* symbol, int version) {
  const std::string what = module.what, remedy = std::string("; install ") + module.package +
                                                 ", or name the file in the environment variable " + module.variable;
  std::string tried;
  for (const fs::path& path : candidates(module)) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) {
      append_word(tried, path.string());
      continue;
    }
    void* handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) throw RuntimeError("cannot open " + what + ": " + printable(::dlerror(), 400) + remedy);
    return table_of<Table>(module, handle, symbol, version, path.string());
  }
  // A program that links the installed static library lies anywhere; its run path leads to the module.
  if (void* handle = is_chosen(module) ? nullptr : ::dlopen(module.file, RTLD_NOW | RTLD_LOCAL); handle != nullptr)
    return table_of<Table>(module, handle, symbol, version, module.file);
  throw RuntimeError("cannot find " + what + " (looked for " + tried + ")" + remedy);
}

}  // namespace

const Codecs& codecs() {
  static const Codecs* const table = load<Codecs>(kCodecs, codecs_symbol, codecs_version);
  return *table;
}

bool has_codecs() {
  const std::vector<fs::path> paths = candidates(kCodecs);
  return std::any_of(paths.begin(), paths.end(), [](const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error);
  });
}

OpenCvFilter opencv_filter(const OpenCvJob& job) {
  static const OpenCv* const table = load<OpenCv>(kOpenCv, opencv_symbol, opencv_version);
  return table->filter(job);
}

}  // namespace mtf::io
