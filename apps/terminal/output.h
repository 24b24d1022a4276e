// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where text goes: results to standard output, messages to standard error. A result that cannot be written is an error.

#include <filesystem>
#include <string>
#include <string_view>

#include "apps/options.h"

namespace apps {

/// Writes to standard output at once. Throws RuntimeError when that fails (closed pipe, full disk).
void print(std::string_view text);

/// Writes a result to the file `path`, whole or not at all; "" and "-" stand for standard output. Throws RuntimeError.
void emit(const std::string& path, std::string_view text);

/// A line on standard error, unless --quiet.
void note(const Global& global, std::string_view text);

/// A line on standard error, always.
void complain(std::string_view text);

/// The text without control characters and broken UTF-8, so that no file name breaks a line.
std::string one_line(std::string_view text);

/// A word for a command line that can be pasted: quoted for the shell where that is needed.
std::string shell_word(std::string_view text);

/// Where a file of that name is written: links are followed, also one to a file that does not exist yet.
std::filesystem::path place_of(const std::string& name);

/// True when both names lead to one file, also through links and to a file that is yet to be written.
bool is_same_file(const std::string& a, const std::string& b);

/// Throws UsageError when `output` is the file `input` already there, by whatever name.
void require_different(const std::string& input, const std::string& output);

}  // namespace apps
