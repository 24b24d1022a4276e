// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs the `mtf` command that was built, in a folder of its own.

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {

namespace fs = std::filesystem;

inline std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void write_file(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

struct Result {
  int status = -1;  ///< exit code, or 128 + the signal that ended the shell
  std::string out, err;
};

/// Expects the exit code, and that the error says all the parts: its place and its remedy, in short (expect_error.h).
inline void expect_error(const Result& result, int status, std::initializer_list<std::string_view> parts,
                         const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (result.status != status) ADD_FAILURE_AT(file, line) << "exit code " << result.status << ": " << result.err;
  expect_says(result.err, parts, file, line);
}

/// A scratch folder that goes away. Commands run in it through the shell, with `mtf` on PATH.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "mtfkit_apps_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch folder");
    root_ = name;
    fs::create_directory(root_ / "work");
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  fs::path operator/(const std::string& name) const { return root_ / "work" / name; }

  Result run(const std::string& command) const {
    const std::string folder = fs::path(MTFKIT_COMMAND).parent_path().string();
    const fs::path script = root_ / "script", out = root_ / "out", err = root_ / "err";
    write_file(script, "PATH='" + folder + "':$PATH\nexport PATH\ncd '" + (root_ / "work").string() + "'\n" + command);
    const int status = std::system(
        ("sh '" + script.string() + "' >'" + out.string() + "' 2>'" + err.string() + "' </dev/null").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_file(out), read_file(err)};
  }

  /// sensor.toml: what `mtf config init` writes.
  void add_sensor() const {
    if (run("mtf config init -o sensor.toml").status != 0) throw std::runtime_error("mtf config init failed");
  }

 private:
  fs::path root_;
};

inline std::size_t lines(const std::string& text) {
  std::size_t count = 0;
  for (const char c : text) count += c == '\n' ? 1U : 0U;
  return count;
}

}  // namespace apps_test
