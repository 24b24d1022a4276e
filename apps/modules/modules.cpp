// SPDX-License-Identifier: Apache-2.0
#include "apps/modules/modules.h"

#include <dlfcn.h>

#include <filesystem>
#include <string_view>

#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/io/code_folder.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/version.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

struct Module {
  const char* name;   ///< of the function that gives the table; that of the file is lib<name>.so
  const char* what;   ///< for messages
  const char* build;  ///< what builds it
};

constexpr Module kFits{"mtfkit_fits", "fits and optima (mtf fit, mtf optimize)", "apps/quickstart"};
constexpr Module kScenes{"mtfkit_scenes", "3-D scenes (mtf scene, heat, render, fly)", "apps/quickstart all"};
constexpr Module kLive{"mtfkit_live", "the live view (mtf live)", "apps/quickstart all"};

/// All modules lie beside the library that this code is in.
fs::path file_of(const Module& module) {
  return mtf::io::code_folder(reinterpret_cast<const void*>(&modules_text)) /
         ("lib" + std::string(module.name) + ".so");
}

bool is_there(const Module& module) {
  std::error_code error;
  return fs::is_regular_file(file_of(module), error);
}

template <class Table>
const Table* open(const Module& module) {
  const fs::path file = file_of(module);
  const std::string remedy = "build it with " + std::string(module.build) + ", or install the Debian package mtfkit";
  if (!is_there(module))
    throw mtf::RuntimeError(std::string(module.what) + ": not part of this installation, which has no " +
                            one_line(file.string()) + "; " + remedy);
  void* const handle = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr)
    throw mtf::RuntimeError(std::string(module.what) + ": cannot open the module: " + one_line(::dlerror()) + "; " +
                            remedy);
  const auto table_of = reinterpret_cast<const Table* (*)()>(::dlsym(handle, module.name));
  const Table* const table = table_of != nullptr ? table_of() : nullptr;
  if (table == nullptr || std::string_view(table->build.version) != mtf::version ||
      std::string_view(table->build.commit) != mtf::git_commit)
    throw mtf::RuntimeError(std::string(module.what) + ": " + one_line(file.string()) +
                            " is of another build than the command, which is " + mtf::version + " of commit " +
                            mtf::git_commit + "; " + remedy + " again");
  return table;
}

}  // namespace

const FitsModule& fits_module() {
  static const FitsModule* const table = open<FitsModule>(kFits);
  return *table;
}

const ScenesModule& scenes_module() {
  static const ScenesModule* const table = open<ScenesModule>(kScenes);
  return *table;
}

const LiveModule& live_module() {
  static const LiveModule* const table = open<LiveModule>(kLive);
  return *table;
}

bool has_live_module() { return is_there(kLive); }

std::string modules_text() {
  std::string here, missing;
  const auto tell = [&](bool there, const std::string& what) {
    std::string& list = there ? here : missing;
    list += (list.empty() ? "" : "; ") + what;
  };
  tell(mtf::io::has_codecs(), "PNG, TIFF and JPEG");
  for (const Module& module : {kFits, kScenes, kLive}) tell(is_there(module), module.what);
  return "present: " + (here.empty() ? "the core only" : here) +
         "\nmissing: " + (missing.empty() ? "nothing" : missing);
}

}  // namespace apps
