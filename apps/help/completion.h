// SPDX-License-Identifier: Apache-2.0
#pragma once

// Completion of command lines. The shells' scripts beside this file call `mtf --complete WORD...` with the words up to
// the cursor, the last of which ("" where it is not begun) is to be completed. The answer has a candidate a line; an
// empty line, which comes first, stands for names of files, which the shell knows best. Of "--name=part" candidates
// are values alone. No module is opened, and nothing is written.

#include <string>
#include <vector>

#include "apps/command_line.h"

namespace apps {

/// The lines of the answer. Never throws: there are no candidates where anything is wrong.
std::string completion(const Command& root, const std::vector<std::string>& words) noexcept;

}  // namespace apps
