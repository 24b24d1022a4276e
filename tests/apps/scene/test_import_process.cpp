// SPDX-License-Identifier: Apache-2.0
// The process that parses files: its limits, its end, and a machine that does not have it.
#include <dirent.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "apps/scene/import/import_mesh.h"
#include "mesh_samples.h"
#include "mtf/error.h"
#include "tests/expect_error.h"

namespace {

using namespace scene_test;
using apps::scene::import_mesh;
using apps::scene::ImportLimits;
using apps::scene::Up;

std::string refusal(const fs::path& file, const ImportLimits& limits) {
  return message_of<mtf::RuntimeError>([&] { static_cast<void>(import_mesh(file, 1.0, Up::of_format, limits)); });
}

TEST(ImportProcess, MemoryIsLimited) {
  const Folder folder;
  const fs::path file = folder.put("a.obj", std::string(128U << 20U, '\n'));
  expect_says(refusal(file, {.memory_bytes = 96U << 20U}), {"a.obj", "96 MiB"});
}

TEST(ImportProcess, ProcessorTimeIsLimited) {
  const Folder folder;
  const fs::path file = folder.put("a.obj", std::string(256U << 20U, '\n'));
  expect_says(refusal(file, {.cpu_s = 1}), {"a.obj", "1 s of processor"});
}

TEST(ImportProcess, OutputIsLimited) {
  const Folder folder;
  const fs::path file = folder.put("a.obj", obj);
  expect_says(refusal(file, {.output_bytes = 100}), {"a.obj", "larger than 100 bytes"});
  EXPECT_EQ(import_mesh(file, 1.0, Up::of_format, {.output_bytes = 1000}).faces(), 2U);
}

/// The variable while it lives.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) { ::setenv(name, value.c_str(), 1); }
  ~Variable() { ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

/// A program that takes the place of the real one.
fs::path program(const Folder& folder, const std::string& script) {
  const fs::path file = folder.put("program", "#!/bin/sh\n" + script + "\n");
  fs::permissions(file, fs::perms::owner_all);
  return file;
}

TEST(ImportProcess, WhatGoesWrongIsAnError) {
  const Folder folder;
  const fs::path file = folder.put("a.obj", obj);
  const std::pair<const char*, const char*> cases[] = {
      {"kill -SEGV $$", "crashed"},        {"exit 3", "crashed"},
      {"exit 0", "shorter than it says"},  {"echo nonsense", "no mesh"},
      {"kill -XCPU $$", "processor time"}, {"exec cat /dev/zero", "larger than"}};
  for (const auto& [script, what] : cases) {
    const Variable chosen("MTFKIT_IMPORT", program(folder, script).string());
    SCOPED_TRACE(script);
    expect_says(refusal(file, {.output_bytes = 1000000}), {"a.obj", what});
  }
  const Variable chosen("MTFKIT_IMPORT", (folder / "nowhere").string());
  expect_says(refusal(file, {}), {"cannot start the process"});
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // every one was waited for
}

TEST(ImportProcessLong, AProcessThatStandsStillIsEnded) {
  const Folder folder;
  const Variable chosen("MTFKIT_IMPORT", program(folder, "exec sleep 600").string());
  expect_says(refusal(folder.put("a.obj", obj), {.cpu_s = 1}), {"processor time"});  // not after 600 s
}

/// The process whose parent is `parent`; 0 when there is none.
pid_t child_of(pid_t parent) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string status = text_of(entry.path() / "status");
    if (says(status, "Name:\tmtfkit-import") && says(status, "PPid:\t" + std::to_string(parent) + "\n"))
      return std::stoi(name);
  }
  return 0;
}

template <class Condition>
bool comes_true(const Condition& condition) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

// The process is stopped as soon as it has asked the kernel to end it with its parent, its first act, so that it cannot
// end by itself; then its parent is interrupted.
TEST(ImportProcess, EndsWithTheCaller) {
  const Folder folder;
  const fs::path file = folder.put("a.obj", std::string(256U << 20U, '\n'));
  const pid_t caller = ::fork();
  ASSERT_GE(caller, 0);
  if (caller == 0) {
    static_cast<void>(refusal(file, {}));
    ::_exit(0);
  }
  pid_t child = 0;
  ASSERT_TRUE(comes_true([&] { return (child = child_of(caller)) != 0; }));
  ASSERT_TRUE(comes_true([&] { return says(text_of("/proc/" + std::to_string(child) + "/comm"), "mtfkit-import"); }));
  ::usleep(100'000);
  ASSERT_EQ(::kill(child, SIGSTOP), 0);
  ::kill(caller, SIGINT);
  int status = 0;
  ASSERT_EQ(::waitpid(caller, &status, 0), caller);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(comes_true([&] {
    const std::string state = text_of("/proc/" + std::to_string(child) + "/status");
    return state.empty() || says(state, "State:\tZ");
  }));
}

}  // namespace
