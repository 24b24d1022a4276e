// SPDX-License-Identifier: Apache-2.0
#include "apps/sweep/output_folder.h"

#include <system_error>

#include "apps/terminal/output.h"
#include "mtf/error.h"

namespace apps {

namespace fs = std::filesystem;

void check_folder(const fs::path& folder, bool force) {
  std::error_code error;
  fs::path whole = fs::absolute(folder, error).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // "demo/" is "demo"
  const fs::path parent = whole.parent_path();
  if (!fs::is_directory(parent, error))
    throw mtf::RuntimeError("cannot create " + one_line(folder.string()) + ": there is no folder " +
                            one_line(parent.string()));
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    throw mtf::UsageError(one_line(folder.string()) + " exists and is not a folder; choose another name");
  if (fs::is_directory(folder, error) && !fs::is_empty(folder, error) && !force)
    throw mtf::UsageError(one_line(folder.string()) +
                          " is not empty; choose another folder, or --force to replace files in it");
}

void prepare_folder(const fs::path& folder, bool force) {
  check_folder(folder, force);
  std::error_code error;
  fs::create_directory(folder, error);
  if (error) throw mtf::RuntimeError("cannot create " + one_line(folder.string()) + ": " + error.message());
}

}  // namespace apps
