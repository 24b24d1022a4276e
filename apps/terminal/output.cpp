// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/output.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"

namespace apps {

void print(std::string_view text) {
  const bool whole = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (whole && std::fflush(stdout) == 0) return;
  if (errno == EPIPE) throw mtf::io::BrokenPipe("standard output: its reader has gone");
  throw mtf::RuntimeError("cannot write to standard output: " + std::generic_category().message(errno) +
                          "; give it a reader, or a file with room");
}

void emit(const std::string& path, std::string_view text) {
  if (path.empty() || path == "-")
    print(text);
  else
    mtf::io::write_text_file(path, text);
}

bool emit_for_editing(const std::string& file, const std::string& text, bool force) {
  const bool to_stdout = file.empty() || file == "-";
  struct stat status {};
  if (!to_stdout && !force && ::stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode))
    throw mtf::UsageError(file + ": exists already; --force replaces it, -o NAME writes another file");
  emit(file, text);
  return !to_stdout;
}

void note(const Global& global, std::string_view text) {
  if (!global.quiet) complain(text);
}

void complain(std::string_view text) {
  const std::string line = std::string(text) + "\n";
  // One call, so that lines of several writers do not mix; nobody is left to hear of a failure.
  static_cast<void>(std::fwrite(line.data(), 1, line.size(), stderr));
}

std::string shell_word(std::string_view text) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./+,:@%=").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return std::string(text);
  std::string quoted = "'";
  for (const char c : one_line(text)) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace apps
