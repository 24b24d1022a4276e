// SPDX-License-Identifier: Apache-2.0
#pragma once

// The descriptor of a set of frames for EMVA 1288, EMVA1288_Data.txt. The letter that opens a line says what it holds:
//   # ...                         comment
//   v 3.0                         release of the standard
//   n 12 640 480                  bits of a count; columns and rows, which the frames themselves say
//   l InterfaceType GigE          words for the data sheet; skipped
//   b 40000.0 120.0               a stack with light: exposure in ns, photons at a pixel
//   i images\b_000_snap_001.png   one of its frames, from the folder of this file
//   d 40000.0                     a dark stack
// (Documentation of the reference implementation, https://github.com/EMVA1288/emva1288, doc/datasets.)

#include <string>

#include "apps/characterize/stacks_file.h"

namespace apps {

/// By its name, *.txt.
bool is_emva_descriptor(const std::string& file);

/// What TOML would give; stacks are named by their lines, as in what refuses them later: light without a dark stack of
/// its exposure. Throws RuntimeError where the file cannot be read, UsageError "file:line: ..." for another letter, for
/// numbers or files that are missing, and for a stack of fewer than two frames.
StacksFile load_emva_descriptor(const std::string& file);

}  // namespace apps
