// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/output_files.h"

#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "apps/text/message_words.h"
#include "mtf/error.h"

namespace apps {

namespace fs = std::filesystem;

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
  if (input.empty() || output.empty()) return;
  std::error_code ignored;
  if (fs::equivalent(input, output, ignored))
    throw mtf::UsageError(one_line(output) + ": is the input" + (input == output ? "" : " " + one_line(input)) +
                          ", which this run reads and would replace; choose another output");
}

void require_writable(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const std::string& input : inputs) require_different(input, outputs[i]);
    for (std::size_t j = 0; j < i; ++j)
      if (is_same_file(outputs[i], outputs[j]))
        throw mtf::UsageError(one_line(outputs[i]) +
                              (outputs[i] == outputs[j]
                                   ? " is named for two outputs"
                                   : " and " + one_line(outputs[j]) + " are one file, named for two outputs") +
                              "; give each its own name");
    const fs::path folder = fs::path(outputs[i]).parent_path();
    std::error_code error;
    if (fs::is_directory(outputs[i], error))
      throw mtf::RuntimeError("cannot write " + one_line(outputs[i]) + ": it is a folder; name a file in it");
    if (fs::exists(outputs[i], error) && ::access(outputs[i].c_str(), W_OK) != 0)
      throw mtf::RuntimeError("cannot write " + one_line(outputs[i]) + ": " + std::generic_category().message(errno) +
                              "; change its permissions, or name another file");
    if (!folder.empty() && !fs::is_directory(folder, error))
      throw mtf::RuntimeError("cannot write " + one_line(outputs[i]) + ": there is no folder " +
                              one_line(folder.string()) + "; create it first");
  }
}

}  // namespace apps
