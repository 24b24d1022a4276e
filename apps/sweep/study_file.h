// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "apps/options.h"

namespace apps {

/// True for a file whose keys are those of a study; false also for a file that is no TOML. Throws RuntimeError
/// when the file cannot be read.
bool is_study_file(const std::string& file);

/// `mtf config check` of a study. Returns the exit code, 0 or 2. Throws RuntimeError when the file cannot be read,
/// UsageError in a build without studies.
int check_study(const std::string& file, Format format);

}  // namespace apps
