// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/write_together.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace apps {

void write_together(const std::vector<std::string>& paths, const std::function<void()>& write) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  std::vector<std::string> created = paths;
  std::erase_if(created, [&](const std::string& path) {
    return fs::symlink_status(path, ignored).type() != fs::file_type::not_found;
  });
  try {
    write();
  } catch (...) {
    std::for_each(created.rbegin(), created.rend(), [&](const std::string& path) { fs::remove(path, ignored); });
    throw;
  }
}

}  // namespace apps
