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
#include "mtf/io/csv/number_text.h"
#include "mtf/io/file_checks.h"

#ifndef MTFKIT_LIBDIR
#define MTFKIT_LIBDIR "lib"  // the build system gives the real one, e.g. lib/x86_64-linux-gnu
#endif

namespace mtf::io {
namespace {

namespace fs = std::filesystem;
constexpr const char* module_name = "libmtfkit_codecs.so";

std::vector<fs::path> candidates() {
  if (const char* chosen = std::getenv("MTFKIT_CODECS"); chosen != nullptr && *chosen != '\0') return {chosen};
  const fs::path here = code_folder(reinterpret_cast<const void*>(&codecs));
  std::vector<fs::path> paths{here / module_name, here / "mtfkit" / module_name,
                              here.parent_path() / MTFKIT_LIBDIR / "mtfkit" / module_name,
                              here.parent_path() / "lib" / "mtfkit" / module_name};
  // Build folder and prefix have the same shape; test programs lie a few folders deeper than the command.
  fs::path up = here.parent_path();
  for (int folder = 0; folder < 3; ++folder) {
    up = up.parent_path();
    paths.push_back(up / "lib" / "mtfkit" / module_name);
  }
  return paths;
}

const Codecs* table_of(void* module, const std::string& path, const std::string& remedy) {
  const auto factory = reinterpret_cast<const Codecs* (*)()>(::dlsym(module, codecs_symbol));
  const Codecs* table = factory != nullptr ? factory() : nullptr;
  if (table == nullptr || table->version != codecs_version)
    throw RuntimeError("cannot use the PNG and TIFF codecs in " + path +
                       ": they belong to another version of mtfkit; rebuild or reinstall" + remedy);
  return table;
}

const Codecs* load() {
  const std::string remedy =
      "; install mtfkit with its codecs module, or name the module in the environment variable MTFKIT_CODECS "
      "(OpenEXR files need no module)";
  std::string tried;
  for (const fs::path& path : candidates()) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) {
      append_word(tried, path.string());
      continue;
    }
    void* module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (module == nullptr)
      throw RuntimeError("cannot open the PNG and TIFF codecs: " + printable(::dlerror(), 400) + remedy);
    return table_of(module, path.string(), remedy);
  }
  // A program that links the installed static library lies anywhere; its run path leads to the module.
  void* module = std::getenv("MTFKIT_CODECS") == nullptr ? ::dlopen(module_name, RTLD_NOW | RTLD_LOCAL) : nullptr;
  if (module != nullptr) return table_of(module, module_name, remedy);
#ifndef MTFKIT_HAVE_CODECS
  if (std::getenv("MTFKIT_CODECS") == nullptr)
    throw RuntimeError("this build reads and writes OpenEXR only; build with MTFKIT_WITH_OPENCV=ON for PNG and TIFF");
#endif
  throw RuntimeError("cannot find the PNG and TIFF codecs (looked for " + tried + ")" + remedy);
}

}  // namespace

const Codecs& codecs() {
  static const Codecs* const table = load();
  return *table;
}

bool has_codecs() {
  const std::vector<fs::path> paths = candidates();
  return std::any_of(paths.begin(), paths.end(), [](const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error);
  });
}

OpenCvFilter opencv_filter(const OpenCvJob& job) { return codecs().opencv_filter(job); }

}  // namespace mtf::io
