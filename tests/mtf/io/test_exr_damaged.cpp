// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <limits>

#include "io_test_files.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"

namespace {

using io_test::TempFolder;
using mtf::RuntimeError;
using mtf::io::ReadOptions;

bool one_line(const std::string& text) {
  return !text.empty() && std::none_of(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\0'; });
}

// The message of the refusal, "" when the file was read.
std::string refusal(const std::string& path, const ReadOptions& options = {}) {
  return message_of<mtf::Error>([&] { mtf::io::read_image(path, options); });
}

TEST(ExrDamaged, EverySharedFileIsRefused) {
  const auto data = io_test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data / "exr_damaged")) {
    const std::string path = entry.path().string();
    if (path.ends_with("COPYING") || path.ends_with("README.rst")) continue;
    ++files;
    EXPECT_TRUE(one_line(refusal(path))) << path;
  }
  EXPECT_GT(files, 40);
  rusage usage{};
  ASSERT_EQ(::getrusage(RUSAGE_SELF, &usage), 0);
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(usage.ru_maxrss, 300 * 1024);
#endif
}

TEST(ExrDamaged, EverySharedSampleIsReadOrExplained) {
  const auto data = io_test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  int read = 0, explained = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data / "exr_samples")) {
    if (entry.path().extension() != ".exr") continue;
    const auto info = mtf::io::read_info(entry.path().string());
    const std::string message = refusal(entry.path().string());
    if (message.empty())
      ++read;
    else if (message.find("it has " + info.channels.at(0).name) != std::string::npos)
      ++explained;
    else
      ADD_FAILURE() << message;
  }
  EXPECT_GE(read, 8);
  EXPECT_EQ(explained, 1);  // the deep one
}

TEST(ExrDamaged, TruncatedAnywhereIsRefused) {
  const TempFolder folder;
  io_test::write_scanline(folder / "whole.exr", Imf::Header(50, 70), {"R", "G", "B"});
  const std::string bytes = io_test::read_bytes(folder / "whole.exr");
  ASSERT_EQ(refusal(folder / "whole.exr"), "");
  for (std::size_t length = 1; length < bytes.size(); length += length < 600 ? 1 : 97) {
    io_test::write_bytes(folder / "cut.exr", bytes.substr(0, length));
    EXPECT_TRUE(one_line(refusal(folder / "cut.exr"))) << length;
  }
}

TEST(ExrDamaged, FlippedHeaderBytesNeverCrash) {
  const TempFolder folder;
  io_test::write_scanline(folder / "whole.exr", Imf::Header(50, 70), {"Y"});
  const std::string bytes = io_test::read_bytes(folder / "whole.exr");
  int refused = 0, tried = 0;
  for (std::size_t at = 4; at < std::min<std::size_t>(bytes.size(), 450); ++at) {
    for (const char value : {'\0', '\x7f', '\xff'}) {
      std::string changed = bytes;
      changed[at] = value;
      io_test::write_bytes(folder / "changed.exr", changed);
      ++tried;
      refused += refusal(folder / "changed.exr").empty() ? 0 : 1;
    }
  }
  EXPECT_GT(refused, tried / 2);
}

// The bytes of a small file with one window replaced.
std::string with_window(const std::string& bytes, const std::string& name, const std::array<std::int32_t, 4>& window) {
  std::string changed = bytes;
  const std::string head = name + std::string("\0box2i\0\x10\0\0\0", 11);
  const auto at = changed.find(head);
  if (at == std::string::npos) std::abort();
  std::memcpy(changed.data() + at + head.size(), window.data(), sizeof window);
  return changed;
}

TEST(ExrDamaged, ImpossibleSizesAreRefusedWithTheBytes) {
  const TempFolder folder;
  io_test::write_scanline(folder / "whole.exr", Imf::Header(8, 8), {"Y"});
  const std::string bytes = io_test::read_bytes(folder / "whole.exr");
  constexpr std::int32_t largest = std::numeric_limits<std::int32_t>::max();
  const auto message = [&](const std::string& name, const std::array<std::int32_t, 4>& window) {
    io_test::write_bytes(folder / "huge.exr", with_window(bytes, name, window));
    return refusal(folder / "huge.exr");
  };
  expect_says(message("dataWindow", {-largest, -largest, largest, largest}), {"EiB"});
  expect_says(message("dataWindow", {0, 0, 65535, 65535}), {"GiB"});
  expect_says(message("dataWindow", {0, 0, 1 << 29, 0}), {"GiB"});
  expect_says(message("displayWindow", {0, 0, 99999, 99999}), {"37.3 GiB"});
  expect_says(message("displayWindow", {0, 0, 7, 9999999}), {"305 MiB"});
  EXPECT_NE(message("displayWindow", {-largest, 0, largest, 0}), "");
  expect_says(message("dataWindow", {5, 0, 2, 7}), {"inverted"});
}

TEST(ExrDamaged, WrongKindsOfFile) {
  const TempFolder folder;
  io_test::write_bytes(folder / "empty.exr", "");
  io_test::write_bytes(folder / "text.exr", "these are not the pixels you are looking for\n");
  io_test::write_bytes(folder / "short.exr", "v/1");
  const auto message = [](const std::string& path) {
    return message_of<RuntimeError>([&] { mtf::io::read_image(path); });
  };
  expect_says(message(folder / "empty.exr"), {"the file is empty"});
  expect_says(message(folder / "text.exr"), {"OpenEXR", "PNG", "TIFF"});
  expect_says(message(folder / "short.exr"), {"none of OpenEXR"});
  expect_says(message(folder / "."), {"it is a folder"});
  expect_says(message(folder / "missing.exr"), {"No such file"});
  expect_says(message("/dev/zero"), {"not an ordinary file"});
  const auto info = message_of<RuntimeError>([&] { mtf::io::read_info(folder / "text.exr"); });
  expect_says(info, {"none of OpenEXR"});
}

}  // namespace
