// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "io_test_files.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"

namespace {

using io_test::read_bytes;
using io_test::TempFolder;
using mtf::RuntimeError;
using mtf::io::AtomicFile;

TEST(AtomicFile, AppearsOnlyAtCommit) {
  const TempFolder folder;
  const std::string path = folder / "out.bin";
  AtomicFile file(path);
  file.write("abcdef", 6);
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_TRUE(std::filesystem::exists(path + ".tmp." + std::to_string(::getpid())));
  file.seek(2);
  file.write("XY", 2);
  EXPECT_EQ(file.position(), 4U);
  file.commit();
  EXPECT_EQ(read_bytes(path), "abXYef");
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, WithoutCommitNothingChanges) {
  const TempFolder folder;
  const std::string path = folder / "out.bin";
  io_test::write_bytes(path, "old");
  {
    AtomicFile file(path);
    file.write("new", 3);
  }
  EXPECT_EQ(read_bytes(path), "old");
  EXPECT_EQ(folder.entries(), 1U);
}

// The child ends as a killed process does: no destructor runs.
TEST(AtomicFile, WhatIsKeptOutlivesTheProcess) {
  const TempFolder folder;
  const std::string path = folder / "out.bin", kept = folder / "kept.bin";
  io_test::write_bytes(path, "old");
  const pid_t child = ::fork();
  if (child == 0) {
    AtomicFile file(path);
    file.write("abc", 3);
    if (!file.keep_as(kept)) ::_exit(1);
    file.write("def", 3);
    if (!file.keep_as(kept)) ::_exit(1);
    file.write("lost", 4);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_EQ(status, 0);
  EXPECT_EQ(read_bytes(path), "old");
  EXPECT_EQ(read_bytes(kept), "abcdef");
  {
    AtomicFile file(path);  // removes the temporary that the child left
    EXPECT_EQ(folder.entries(), 3U);
    file.write("xyz", 3);
    ASSERT_TRUE(file.keep_as(kept));
    EXPECT_EQ(read_bytes(kept), "xyz");
  }
  EXPECT_EQ(folder.entries(), 2U);
  EXPECT_EQ(read_bytes(path), "old");
  EXPECT_EQ(read_bytes(kept), "xyz");
  AtomicFile file(path);
  EXPECT_THROW(static_cast<void>(file.keep_as(folder / "no/kept.bin")), RuntimeError);
}

TEST(AtomicFile, LargeWritesKeepTheirOrder) {
  const TempFolder folder;
  const std::string path = folder / "out.bin";
  std::string expected;
  AtomicFile file(path);
  for (int i = 0; i < 40; ++i) {
    const std::string piece(static_cast<std::size_t>(i) * 20011, static_cast<char>('a' + i % 26));
    file.write(piece.data(), piece.size());
    expected += piece;
  }
  file.commit();
  EXPECT_EQ(read_bytes(path), expected);
}

TEST(AtomicFile, TwoWritersOfOneTargetDoNotMeet) {
  const TempFolder folder;
  AtomicFile first(folder / "out.bin"), second(folder / "out.bin");
  first.write("first", 5);
  second.write("second", 6);
  first.commit();
  second.commit();
  EXPECT_EQ(read_bytes(folder / "out.bin"), "second");
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, FollowsALinkAndKeepsPermissions) {
  const TempFolder folder;
  io_test::write_bytes(folder / "real.txt", "old");
  ASSERT_EQ(::chmod((folder / "real.txt").c_str(), 0640), 0);
  std::filesystem::create_symlink(folder / "real.txt", folder / "link.txt");
  mtf::io::write_text_file(folder / "link.txt", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.txt"));
  EXPECT_EQ(read_bytes(folder / "real.txt"), "new");
  struct stat status {};
  ASSERT_EQ(::stat((folder / "real.txt").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
}

TEST(AtomicFile, ImpossibleTargetsAreNamed) {
  const TempFolder folder;
  const auto open = [](const std::string& path) {
    return message_of<RuntimeError>([&] { const AtomicFile file(path); });
  };
  expect_says(open(folder / "missing/out.exr"), {"folder " + (folder / "missing") + " does not exist"});
  expect_says(open(folder / "."), {"it is a folder"});
  expect_says(open("/dev/null"), {"device or pipe"});
  EXPECT_NE(open(folder / std::string(300, 'x')), "");
  EXPECT_EQ(folder.entries(), 0U);
  const std::string longest(255, 'x');
  mtf::io::write_text_file(folder / longest, "fits");
  EXPECT_EQ(read_bytes(folder / longest), "fits");
}

TEST(AtomicFile, UnwritableFolder) {
  const TempFolder folder;
  const uid_t self = ::geteuid();
  ASSERT_EQ(::chmod((folder / ".").c_str(), 0555), 0);
  if (self == 0 && ::seteuid(65534) != 0) GTEST_SKIP() << "root may write everywhere";
  const std::string message = message_of<RuntimeError>([&] { const AtomicFile file(folder / "out.exr"); });
  ASSERT_EQ(::seteuid(self), 0);
  ASSERT_EQ(::chmod((folder / ".").c_str(), 0755), 0);
  expect_says(message, {"out.exr: Permission denied", "choose a folder"});
}

TEST(AtomicFile, TextGoesStraightToADevice) {
  EXPECT_NO_THROW(mtf::io::write_text_file("/dev/null", "text"));
  expect_refused<RuntimeError>({"No space left", "free space", "another folder"},
                               [] { mtf::io::write_text_file("/dev/full", "text"); });
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(AtomicFile, RemoveTemporariesUnlinksOpenOnes) {
  const TempFolder folder;
  io_test::write_bytes(folder / "done.txt", "done");
  AtomicFile file(folder / "out.bin");
  EXPECT_EQ(folder.entries(), 2U);
  // In a process that ends with it, as it is meant.
  const pid_t child = ::fork();
  if (child == 0) {
    mtf::io::remove_temporaries();
    ::_exit(0);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  EXPECT_EQ(folder.entries(), 1U);
  EXPECT_EQ(read_bytes(folder / "done.txt"), "done");
}

// A full disk without mounting one: the file size limit makes write fail half-way in the same place.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

// Noise does not compress: 256 x 256 floats are far beyond the limits below.
mtf::Image noise() {
  mtf::Image image(256, 256);
  std::uint32_t state = 1;
  for (std::int64_t i = 0; i < image.size(); ++i) {
    state = state * 1664525U + 1013904223U;
    image.data()[i] = static_cast<float>(state >> 8U);
  }
  return image;
}

void expect_write_fails_cleanly(const std::string& name, const std::string& reason) {
  const TempFolder folder;
  const mtf::Image image = noise();
  const std::vector<mtf::io::NamedPlane> planes{{"Y", image.view()}};
  io_test::write_bytes(folder / name, "old");
  std::string message;
  {
    const FileSizeLimit limit(20000);
    message = message_of<RuntimeError>([&] {
      if (name.ends_with(".exr"))
        mtf::io::write_exr(folder / name, planes, {});
      else
        mtf::io::write_integer(folder / name, planes, mtf::io::full_range_scaling(planes), {});
    });
  }
  expect_says(message, {reason});
  EXPECT_EQ(read_bytes(folder / name), "old");
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(WriteFailure, ExrSurfacesAndLeavesTheOldFile) { expect_write_fails_cleanly("out.exr", "File too large"); }
TEST(WriteFailure, PngSurfacesAndLeavesTheOldFile) { expect_write_fails_cleanly("out.png", "File too large"); }
TEST(WriteFailure, TiffSurfacesAndLeavesTheOldFile) { expect_write_fails_cleanly("out.tif", "File too large"); }

TEST(WriteFailure, FullDisk) {
  const TempFolder folder;
  if (::mount("none", (folder / ".").c_str(), "tmpfs", 0, "size=16k") != 0) GTEST_SKIP() << "no right to mount";
  const mtf::Image image = noise();
  const std::vector<mtf::io::NamedPlane> planes{{"Y", image.view()}};
  for (const char* name : {"out.exr", "out.png", "out.tiff"}) {
    expect_refused<RuntimeError>({"No space left", "free space", "another folder"}, [&] {
      if (std::string(name) == "out.exr")
        mtf::io::write_exr(folder / name, planes, {});
      else
        mtf::io::write_integer(folder / name, planes, mtf::io::full_range_scaling(planes), {});
    });
  }
  EXPECT_EQ(folder.entries(), 0U);
  ::umount((folder / ".").c_str());
}

}  // namespace
