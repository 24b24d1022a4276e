// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace apps {

/// Refuses what is bound to fail before any work is done: no parent folder, a file of that name, a folder that is not
/// empty (unless `force`). Throws UsageError and RuntimeError.
void check_folder(const std::filesystem::path& folder, bool force);

/// The same, then creates the folder (not its parents).
void prepare_folder(const std::filesystem::path& folder, bool force);

}  // namespace apps
