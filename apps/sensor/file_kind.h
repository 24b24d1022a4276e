// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which of the toolkit's TOML files a file is, by its tables: a command that is given another one says so, in place of
// an error for each of its keys.

#include <string>

namespace apps {

enum class FileKind {
  sensor,
  study,   ///< `mtf sweep`
  scene,   ///< of 3-D, `mtf scene`
  unclear  ///< no table tells; no TOML
};

/// Throws RuntimeError when the file cannot be read.
FileKind file_kind(const std::string& file);

/// Throws UsageError for a file that is clearly of another kind: what it is, and which command reads it. RuntimeError
/// when it cannot be read.
void require_kind(const std::string& file, FileKind wanted);

}  // namespace apps
