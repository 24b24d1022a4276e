// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/temporaries.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <functional>
#include <thread>

#include "io_test_files.h"
#include "mtf/io/atomic_file.h"

namespace {

using io_test::read_bytes;
using io_test::TempFolder;
using mtf::io::AtomicFile;
using mtf::io::write_text_file;

/// Runs `work` in a process of its own and returns its id.
pid_t started(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  work();
  ::_exit(0);
}

/// The id of a process that has ended.
pid_t dead_process() {
  const pid_t child = started([] {});
  EXPECT_EQ(::waitpid(child, nullptr, 0), child);
  return child;
}

TEST(Temporaries, WhatAKilledProcessLeftGoesWithTheNextOutput) {
  for (const std::string& name : {std::string("out.bin"), std::string(255, 'x')}) {
    const TempFolder folder;
    for (int i = 0; i < 2; ++i) {
      const pid_t child = started([&] {
        AtomicFile first(folder / name), second(folder / name);  // .tmp.<process> and .tmp.<process>.1
        first.write("part", 4);
        ::raise(SIGKILL);
      });
      int status = 0;
      ASSERT_EQ(::waitpid(child, &status, 0), child);
      ASSERT_TRUE(WIFSIGNALED(status));
      EXPECT_EQ(folder.entries(), 2U);  // the second killed process removed what the first had left
    }
    write_text_file(folder / name, "whole");
    EXPECT_EQ(read_bytes(folder / name), "whole");
    EXPECT_EQ(folder.entries(), 1U);
  }
}

TEST(Temporaries, ALiveProcessKeepsItsOwn) {
  const TempFolder folder;
  std::array<int, 2> ready{}, go{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  ASSERT_EQ(::pipe(go.data()), 0);
  const pid_t child = started([&] {
    char byte = 0;
    AtomicFile file(folder / "out.bin");
    file.write("child", 5);
    if (::write(ready[1], &byte, 1) != 1 || ::read(go[0], &byte, 1) != 1) ::_exit(1);
    file.commit();
  });
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  write_text_file(folder / "out.bin", "parent");
  EXPECT_EQ(folder.entries(), 2U);
  ASSERT_EQ(::write(go[1], &byte, 1), 1);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(read_bytes(folder / "out.bin"), "child");
  EXPECT_EQ(folder.entries(), 1U);
}

// In a container of its own a process has an id that means nothing, or somebody else, outside of it.
TEST(Temporaries, TheLockCountsWhereTheIdIsUnknown) {
  const TempFolder folder;
  const std::string name = folder / ("out.bin.tmp." + std::to_string(dead_process()));
  io_test::write_bytes(name, "part");
  const int descriptor = ::open(name.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(::flock(descriptor, LOCK_EX | LOCK_NB), 0);
  mtf::io::remove_dead_temporaries(folder / "out.bin");
  EXPECT_TRUE(std::filesystem::exists(name));
  ::close(descriptor);
  mtf::io::remove_dead_temporaries(folder / "out.bin");
  EXPECT_FALSE(std::filesystem::exists(name));
}

TEST(Temporaries, OnlyThoseOfThisOutputGo) {
  const TempFolder folder;
  const std::string dead = std::to_string(dead_process());
  const std::vector<std::string> others{"out.bin.tmp",       "out.bin.tmp.",      "out.bin.tmp.notes",
                                        "out.bin.tmp.1",     "out.bin.tmp.-5",    "out.bin.tmp." + dead + "x",
                                        "out.bin.tmp.0",     "out.bin.tmp.9.",    "other.bin.tmp." + dead,
                                        "xout.bin.tmp.7.7x", "out.bin.tmp.9.9.9", "out.bin.tmp.99999999999999999999"};
  for (const std::string& name : others) io_test::write_bytes(folder / name, "mine");
  std::filesystem::create_symlink(folder / "other.bin.tmp.", folder / ("out.bin.tmp." + dead + ".2"));
  std::filesystem::create_directory(folder / ("out.bin.tmp." + dead + ".3"));
  write_text_file(folder / "out.bin", "whole");
  for (const std::string& name : others) EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  EXPECT_EQ(folder.entries(), others.size() + 3);
  mtf::io::remove_dead_temporaries(folder / "missing/out.bin");
}

TEST(Temporaries, ThreadsThatWriteOneFileDoNotTakeEachOthersForDead) {
  const TempFolder folder;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&folder] {
        for (int i = 0; i < 100; ++i) EXPECT_NO_THROW(write_text_file(folder / "out.bin", "whole"));
      });
  }
  EXPECT_EQ(read_bytes(folder / "out.bin"), "whole");
  EXPECT_EQ(folder.entries(), 1U);
}

}  // namespace
