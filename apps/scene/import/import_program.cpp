// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>
#include <vector>

#include "apps/scene/import/import_process.h"
#include "mtf/error.h"
#include "mtf/work/module.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;

// The folders in which the loader searches for libraries: the run path of the program is among them.
std::vector<fs::path> run_path() {
  std::vector<fs::path> folders;
  void* const program = ::dlopen(nullptr, RTLD_LAZY);
  if (program == nullptr) return folders;
  Dl_serinfo size{};
  if (::dlinfo(program, RTLD_DI_SERINFOSIZE, &size) == 0) {
    std::vector<Dl_serinfo> storage(size.dls_size / sizeof(Dl_serinfo) + 1, size);
    if (::dlinfo(program, RTLD_DI_SERINFO, storage.data()) == 0)
      for (unsigned i = 0; i < size.dls_cnt; ++i) folders.emplace_back(storage.front().dls_serpath[i].dls_name);
  }
  ::dlclose(program);
  return folders;
}

// In the folder or one of those above; empty when it is not there.
fs::path found_above(fs::path folder) {
  constexpr int depth = 5;  // of a test program or a Python module below the build folder or the prefix
  for (int up = 0; up < depth && folder != folder.root_path(); ++up, folder = folder.parent_path()) {
    const fs::path program = folder / "libexec" / "mtfkit" / "mtfkit-import";
    std::error_code error;
    if (fs::is_regular_file(program, error)) return program;
  }
  return {};
}

}  // namespace

fs::path import_program() {
  if (const char* chosen = std::getenv("MTFKIT_IMPORT"); chosen != nullptr && *chosen != '\0') return chosen;
  const fs::path own = mtf::code_folder(reinterpret_cast<const void*>(&import_program));
  if (const fs::path program = found_above(own); !program.empty()) return program;
  // A program linked with the static libraries may lie anywhere, but its run path leads to the installation.
  for (const fs::path& folder : run_path())
    if (const fs::path program = found_above(folder); !program.empty()) return program;
  throw mtf::RuntimeError(
      "cannot find libexec/mtfkit/mtfkit-import, the program that reads mesh files, neither above " + own.string() +
      " nor above the folders of the run path; install mtfkit with it, or name it in the "
      "environment variable MTFKIT_IMPORT");
}

}  // namespace apps::scene
