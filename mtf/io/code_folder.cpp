// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/code_folder.h"

#include <dlfcn.h>

namespace mtf::io {

namespace fs = std::filesystem;

fs::path code_folder(const void* code) {
  std::error_code error;
  Dl_info where{};
  fs::path object;
  if (::dladdr(code, &where) != 0 && where.dli_fname != nullptr) object = fs::canonical(where.dli_fname, error);
  // For an executable dladdr gives argv[0], which need not be a path.
  if (object.empty() || error) object = fs::canonical("/proc/self/exe", error);
  return object.parent_path();
}

}  // namespace mtf::io
