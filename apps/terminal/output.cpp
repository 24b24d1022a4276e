// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/output.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <system_error>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/file_checks.h"

namespace apps {

namespace fs = std::filesystem;

void print(std::string_view text) {
  const bool whole = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (whole && std::fflush(stdout) == 0) return;
  throw mtf::RuntimeError("cannot write to standard output: " + std::generic_category().message(errno) +
                          "; give it a reader, or a file with room");
}

void emit(const std::string& path, std::string_view text) {
  if (path.empty() || path == "-")
    print(text);
  else
    mtf::io::write_text_file(path, text);
}

void note(const Global& global, std::string_view text) {
  if (!global.quiet) complain(text);
}

void complain(std::string_view text) {
  const std::string line = std::string(text) + "\n";
  // One call, so that lines of several writers do not mix; nobody is left to hear of a failure.
  static_cast<void>(std::fwrite(line.data(), 1, line.size(), stderr));
}

std::string one_line(std::string_view text) {
  return mtf::io::printable(text, std::numeric_limits<std::size_t>::max());
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

fs::path place_of(const std::string& name) {
  constexpr int kMostLinks = 40;  // as many as the kernel follows
  std::error_code error;
  fs::path path = name;
  for (int links = 0; links < kMostLinks && fs::is_symlink(fs::symlink_status(path, error)); ++links) {
    const fs::path target = fs::read_symlink(path, error);
    if (error) break;
    path = path.parent_path() / target;
  }
  const fs::path whole = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? path.lexically_normal() : whole;
}

bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return place_of(a) == place_of(b) || fs::equivalent(a, b, ignored);
}

void require_different(const std::string& input, const std::string& output) {
  if (output.empty()) return;
  std::error_code ignored;
  if (fs::equivalent(input, output, ignored))
    throw mtf::UsageError(output + ": is the input; name another file for the output");
}

}  // namespace apps
