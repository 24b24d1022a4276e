// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names of files that are going to be written, checked before any work is done: no output replaces an input or another
// output, and every folder is there.

#include <filesystem>
#include <string>
#include <vector>

namespace apps {

/// Where a file of that name is written: links are followed, also one to a file that does not exist yet.
std::filesystem::path place_of(const std::string& name);

/// True when both names lead to one file, also through links and to a file that is yet to be written.
bool is_same_file(const std::string& a, const std::string& b);

/// Throws UsageError when `output` is the file `input` already there, by whatever name.
void require_different(const std::string& input, const std::string& output);

/// Throws UsageError for outputs that are inputs and for two of one name, RuntimeError where a folder is missing or an
/// output is one.
void require_writable(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

}  // namespace apps
