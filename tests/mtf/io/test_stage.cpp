// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/stage.h"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "io_test_files.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "tests/expect_error.h"

namespace {

namespace fs = std::filesystem;
using io_test::read_bytes;
using io_test::TempFolder;
using io_test::write_bytes;
using mtf::RuntimeError;
using mtf::io::Stage;
using mtf::io::write_text_file;

using Files = std::map<std::string, std::string>;

/// Every file below a folder, by its name there; folders end with a slash where they are empty.
Files files_in(const std::string& folder) {
  Files files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (entry.is_directory() && fs::is_empty(entry.path())) files[name + "/"] = "";
    if (!entry.is_directory()) files[name] = read_bytes(entry.path().string());
  }
  return files;
}

void write_old(const TempFolder& folder) {
  for (const char* name : {"a", "b", "stale"}) write_bytes(folder / name, std::string("old ") + name);
  fs::create_directory(folder / "chosen");
  write_bytes(folder / "chosen/1", "old 1");
  write_bytes(folder / "foreign", "mine");
}
const Files kOld{{"a", "old a"}, {"b", "old b"}, {"stale", "old stale"}, {"chosen/1", "old 1"}, {"foreign", "mine"}};
const Files kNew{{"a", "new a"}, {"b", "new b"}, {"d", "new d"}, {"chosen/2", "new 2"}, {"foreign", "mine"}};

void write_new(const Stage& stage) {
  for (const char* name : {"a", "b", "d"}) write_text_file(stage.at(name), std::string("new ") + name);
  write_text_file(stage.at("chosen/2"), "new 2");
}

void commit(Stage& stage) {
  stage.make_ready({"a", "b", "stale", "chosen", "never"});
  stage.move();
  stage.finish();
}

std::unique_ptr<Stage> stage_of(const TempFolder& folder) {
  return std::make_unique<Stage>(folder / "", "", false, "out");
}

TEST(Stage, FilesTakeTheirPlaceTogether) {
  const TempFolder folder;
  write_old(folder);
  ASSERT_EQ(::chmod((folder / "b").c_str(), 0640), 0);
  {
    const auto stage = stage_of(folder);
    write_new(*stage);
    EXPECT_EQ(read_bytes(folder / "a"), "old a");
    commit(*stage);
    EXPECT_EQ(read_bytes(folder / "a"), "new a");
    write_text_file(stage->at("later"), "more");  // another commit, of which nothing goes
    stage->make_ready({});
    stage->move();
    stage->finish();
  }
  Files all = kNew;
  all["later"] = "more";
  EXPECT_EQ(files_in(folder / ""), all);
  struct stat status {};
  ASSERT_EQ(::stat((folder / "b").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
}

TEST(Stage, WithoutACommitNothingChanges) {
  const TempFolder folder;
  write_old(folder);
  {
    const auto stage = stage_of(folder);
    write_new(*stage);
    stage->make_ready({"stale"});
  }
  EXPECT_EQ(files_in(folder / ""), kOld);
}

TEST(Stage, WhatFailsOnTheWayIsUndone) {
  const TempFolder folder;
  write_old(folder);
  fs::remove(folder / "b");
  fs::create_directories(folder / "b/is a folder");
  const Files before = files_in(folder / "");
  {
    const auto stage = stage_of(folder);
    write_new(*stage);
    expect_refused<RuntimeError>({"/b:", "a folder"}, [&] { commit(*stage); });
  }
  EXPECT_EQ(files_in(folder / ""), before);
  // The same for a stage whose own commit went well, when another one's did not.
  {
    const auto stage = stage_of(folder);
    write_text_file(stage->at("a"), "new a");
    stage->make_ready({"stale"});
    stage->move();
    EXPECT_EQ(read_bytes(folder / "a"), "new a");
    stage->undo();
  }
  EXPECT_EQ(files_in(folder / ""), before);
}

#if defined(__x86_64__)
/// Runs `work` in a process that is killed at its call number `at` of those that change names. False where it came to
/// its end before; nothing where processes cannot be traced.
std::optional<bool> killed_at(int at, const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) ::_exit(77);
    ::raise(SIGSTOP);
    work();
    ::_exit(0);
  }
  int status = 0;
  if (::waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) return std::nullopt;
  ::ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL);
  bool entering = true;
  for (int count = 0;;) {
    ::ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    ::waitpid(child, &status, 0);
    if (WIFEXITED(status)) return WEXITSTATUS(status) == 0 ? std::optional(false) : std::nullopt;
    if (!WIFSTOPPED(status) || WSTOPSIG(status) != (SIGTRAP | 0x80)) continue;
    if (!std::exchange(entering, !entering)) continue;
    user_regs_struct registers{};
    ::ptrace(PTRACE_GETREGS, child, nullptr, &registers);
    switch (registers.orig_rax) {
      case SYS_rename:
      case SYS_link:
      case SYS_unlink:
      case SYS_unlinkat:
      case SYS_rmdir:
      case SYS_mkdir:
        if (count++ < at) break;
        ::kill(child, SIGKILL);
        ::waitpid(child, &status, 0);
        return true;
      default:
        break;
    }
  }
}

// Whichever step was the last one: every file is one of the old ones or the new ones, and the next command finds, or
// makes, one whole set. Nothing of the stage stays.
TEST(Stage, KilledBetweenAnyTwoStepsItLeavesOneWholeSet) {
  bool old_seen = false, new_seen = false;
  for (int at = 0;; ++at) {
    ASSERT_LT(at, 1000);
    const TempFolder folder;
    write_old(folder);
    const auto killed = killed_at(at, [&] {
      const auto stage = stage_of(folder);
      write_new(*stage);
      commit(*stage);
    });
    if (!killed) GTEST_SKIP() << "processes cannot be traced here";
    for (const char* name : {"a", "b"})
      EXPECT_TRUE(read_bytes(folder / name) == kOld.at(name) || read_bytes(folder / name) == kNew.at(name)) << at;
    stage_of(folder).reset();
    const Files now = files_in(folder / "");
    EXPECT_TRUE(now == kOld || now == kNew) << "killed at step " << at;
    old_seen = old_seen || now == kOld;
    new_seen = new_seen || now == kNew;
    if (!*killed) break;
  }
  EXPECT_TRUE(old_seen && new_seen);
}
#endif

TEST(Stage, TwoCommandsIntoOnePlaceAreToldApart) {
  const TempFolder folder;
  auto first = stage_of(folder);
  write_text_file(first->at("a"), "first");
  expect_refused<RuntimeError>({"out: another mtf (process " + std::to_string(::getpid()), "is writing there"},
                               [&] { stage_of(folder); });
  const Stage beside(folder / "", "x.png", false, "x.png");  // a single file of the same folder is another place
  EXPECT_NE(message_of<RuntimeError>([&] { const Stage same(folder / "", "x.png", false, "x.png"); }), "");
  commit(*first);
  first.reset();
  EXPECT_NO_THROW(stage_of(folder));
  EXPECT_EQ(read_bytes(folder / "a"), "first");
}

TEST(Stage, AStopRemovesItAndTheFolderThatWasMadeForIt) {
  const TempFolder folder;
  fs::create_directory(folder / "fresh");
  fs::create_directory(folder / "there");
  const pid_t child = ::fork();
  if (child == 0) {
    const Stage fresh(folder / "fresh", "", true, "fresh"), there(folder / "there", "", false, "there");
    write_text_file(fresh.at("deep/er/a"), "lost");
    const mtf::io::AtomicFile open(there.at("b"));
    mtf::io::remove_temporaries();
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(files_in(folder / ""), (Files{{"there/", ""}}));
}

TEST(Stage, NamesAreBytes) {
  const TempFolder folder;
  const std::string name = "d\xe9j\xe0 vu";
  {
    const auto stage = stage_of(folder);
    write_text_file(stage->at(name), "latin");
    commit(*stage);
  }
  {
    Stage file(folder / "", name, false, name);
    write_text_file(file.at(name), "again");
    commit(file);
  }
  EXPECT_EQ(files_in(folder / ""), (Files{{name, "again"}}));
}

TEST(Stage, AFullDiskLeavesWhatWasThere) {
  const TempFolder folder;
  if (::mount("none", (folder / ".").c_str(), "tmpfs", 0, "size=64k") != 0) GTEST_SKIP() << "no right to mount";
  write_old(folder);
  {
    const auto stage = stage_of(folder);
    write_text_file(stage->at("a"), "new a");
    const std::string message =
        message_of<RuntimeError>([&] { write_text_file(stage->at("b"), std::string(100'000, 'x')); });
    expect_says(message, {"/b: No space left", "free space"});
    EXPECT_FALSE(says(message, "mtf-new")) << message;
  }
  EXPECT_EQ(files_in(folder / "."), kOld);
  ::umount((folder / ".").c_str());
}

/// Runs `work` as somebody who is not root.
void as_nobody(const std::function<void()>& work) {
  const uid_t self = ::geteuid();
  ASSERT_EQ(::seteuid(65534), 0);
  work();
  ASSERT_EQ(::seteuid(self), 0);
}

TEST(Stage, AFolderThatCannotBeWrittenIsNamed) {
  const TempFolder folder;
  if (::geteuid() != 0) GTEST_SKIP() << "only root may become somebody else";
  ASSERT_EQ(::chmod((folder / ".").c_str(), 0755), 0);
  std::string message;
  as_nobody([&] { message = message_of<RuntimeError>([&] { stage_of(folder); }); });
  expect_says(message, {"cannot write out", "Permission denied", "choose a folder"});
  EXPECT_EQ(folder.entries(), 0U);
}

// Linux gives no second name to a file of somebody else that one may not read: as a file system without second names.
TEST(Stage, WithoutSecondNamesFilesAreMoved) {
  const TempFolder folder;
  if (::geteuid() != 0) GTEST_SKIP() << "only root may become somebody else";
  ASSERT_EQ(::chmod((folder / ".").c_str(), 0777), 0);
  write_bytes(folder / "a", "old a");
  ASSERT_EQ(::chmod((folder / "a").c_str(), 0222), 0);
  as_nobody([&] {
    EXPECT_NE(::link((folder / "a").c_str(), (folder / "second").c_str()), 0);
    Stage stage(folder / "", "", false, "out");
    write_text_file(stage.at("a"), "new a");
    stage.make_ready({});
    stage.move();
    stage.undo();
    EXPECT_EQ(::access((folder / "a").c_str(), F_OK), 0);
    stage.make_ready({});
    stage.move();
    stage.finish();
  });
  EXPECT_EQ(files_in(folder / ""), (Files{{"a", "new a"}}));
}

TEST(Stage, TheCurrentFolderIsAPlaceToo) {
  const TempFolder folder;
  write_old(folder);
  const pid_t child = ::fork();
  if (child == 0) {
    if (::chdir((folder / "").c_str()) != 0) ::_exit(1);
    Stage stage(".", "", false, ".");
    write_new(stage);
    commit(stage);
    ::_exit(0);  // without its destructor
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  stage_of(folder).reset();
  EXPECT_EQ(files_in(folder / ""), kNew);
}

TEST(Stage, MessagesNameThePlaceAndNotTheStage) {
  EXPECT_EQ(mtf::io::without_stages("cannot write a b/.mtf-new/new/c/d.csv: full"), "cannot write a b/c/d.csv: full");
  EXPECT_EQ(mtf::io::without_stages("cannot write ./.x y.csv.mtf-new/new/x y.csv: full"), "cannot write x y.csv: full");
  EXPECT_EQ(mtf::io::without_stages("../.mtf-new/new/a and /.mtf-new/new/b"), "../a and /b");
  EXPECT_EQ(mtf::io::without_stages(".mtf-new"), ".mtf-new");
}

}  // namespace
