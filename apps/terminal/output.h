// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where text goes: results to standard output, messages to standard error. A result that cannot be written is an error.

#include <string>
#include <string_view>

#include "apps/options.h"
#include "apps/text/message_words.h"

namespace apps {

/// Writes to standard output at once. Throws BrokenPipe where its reader has gone, RuntimeError for another failure
/// (full disk).
void print(std::string_view text);

/// Writes a result to the file `path`, whole or not at all; "" and "-" stand for standard output. Throws RuntimeError.
void emit(const std::string& path, std::string_view text);

/// Writes what will be edited by hand as emit() does: an existing file is kept unless `force`, for losing one is worse
/// than losing an output. True where it went to a file.
bool emit_for_editing(const std::string& file, const std::string& text, bool force);

/// A line on standard error, unless --quiet.
void note(const Global& global, std::string_view text);

/// A line on standard error, always.
void complain(std::string_view text);

/// A word for a command line that can be pasted: quoted for the shell where that is needed.
std::string shell_word(std::string_view text);

}  // namespace apps
