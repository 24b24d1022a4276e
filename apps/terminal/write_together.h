// SPDX-License-Identifier: Apache-2.0
#pragma once

// Outputs of several files. Each file appears whole or not at all (mtf/io/atomic_file.h); here the same holds for the
// set, so that a full disk leaves no figure without its data and no half of a demo.

#include <functional>
#include <string>
#include <vector>

namespace apps {

/// Calls `write`, which writes `paths`. When it throws, those that did not exist before are removed, the last one
/// first, and the exception goes on. Folders may be among them, before their files; a folder that holds other files
/// stays.
void write_together(const std::vector<std::string>& paths, const std::function<void()>& write);

}  // namespace apps
