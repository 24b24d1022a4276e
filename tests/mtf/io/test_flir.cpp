// SPDX-License-Identifier: Apache-2.0
// Refusals and damage of FLIR's images; what is read of whole ones is compared with ExifTool in tests/python.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <random>

#include "io_test_files.h"
#include "jpeg_file.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"

namespace {

using io_test::TempFolder;
using mtf::io::ImageFile;

constexpr int kWidth = 5, kHeight = 4;

/// Bytes of which numbers can be set, the least first.
struct FlirText {
  std::string bytes;

  FlirText& set(std::size_t at, std::size_t size, std::uint32_t value) {
    for (std::size_t i = 0; i < size; ++i) bytes[at + i] = static_cast<char>(value >> (8 * i) & 255);
    return *this;
  }
};

/// An FFF of 5 x 4 counts 1000, 1001 ..., or of the bytes that take their place, with a record of the camera.
FlirText fff(const std::string& counts = {}) {
  FlirText raw{std::string(32 + 2 * kWidth * kHeight, '\0')};
  raw.set(0, 2, 2).set(2, 2, kWidth).set(4, 2, kHeight);
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) raw.set(32 + 2 * i, 2, 1000 + i);
  if (!counts.empty()) raw.bytes.replace(32, std::string::npos, counts);
  FlirText camera{std::string(0x3a0, '\0')};
  camera.set(0, 2, 2).set(0x308, 4, std::bit_cast<std::uint32_t>(-600));
  for (const auto& [at, value] : {std::pair{0x58, 15000.0F}, {0x5c, 1400.0F}, {0x60, 1.0F}, {0x30c, 0.01F}})
    camera.set(static_cast<std::size_t>(at), 4, std::bit_cast<std::uint32_t>(value));
  FlirText file{std::string(128, '\0')};
  file.bytes.replace(0, 4, std::string("FFF\0", 4));
  file.set(20, 4, 101).set(24, 4, 64).set(28, 4, 2);
  const auto size = static_cast<std::uint32_t>(raw.bytes.size());
  file.set(64, 2, 1).set(76, 4, 128).set(80, 4, size);
  file.set(96, 2, 0x20).set(108, 4, 128 + size).set(112, 4, static_cast<std::uint32_t>(camera.bytes.size()));
  file.bytes += raw.bytes + camera.bytes;
  return file;
}

class Flir : public testing::Test {
 protected:
  ImageFile read(const std::string& bytes, const mtf::io::ReadOptions& options = {}) {
    io_test::write_bytes(path, bytes);
    return mtf::io::read_image(path, options);
  }
  std::string refusal(const std::string& bytes) {
    return message_of([&] { read(bytes); });
  }
  std::string jpeg(const std::string& segments, std::int64_t width = 16, std::int64_t height = 8) {
    mtf::Image image(width, height);
    std::fill(image.data(), image.data() + image.size(), 100.0F);
    return io_test::JpegWriter::make(image.view(), io_test::jpeg_steps(90), false, segments);
  }
  static std::string segment(int number, int last, const std::string& data) {
    return io_test::JpegWriter::segment(
        0xe1, std::string("FLIR\0\1", 6) + static_cast<char>(number) + static_cast<char>(last) + data);
  }
  /// A picture whose Exif data are of that maker, with its counts in two segments.
  std::string dji(const std::string& bytes, std::int64_t width = 16, std::int64_t height = 8) {
    const auto app3 = [](const std::string& stretch) { return io_test::JpegWriter::segment(0xe3, stretch); };
    return jpeg(io_test::JpegWriter::segment(
                    0xe1, std::string("Exif\0\0II*\0\x08\0\0\0\1\0\x0f\1\2\0\4\0\0\0DJI\0\0\0\0\0", 32)) +
                    app3(bytes.substr(0, 50)) + app3(bytes.substr(50)),
                width, height);
  }
  /// Damage of every kind ends in one error of ours or in an image, in every form that counts have.
  void read_mutants(int rounds) {
    const std::string one = fff().bytes;
    const std::array goods{one, fff(png()).bytes, one + one, jpeg(segment(0, 0, one)), dji(std::string(256, 'c'))};
    std::mt19937 random(5);
    int read_well = 0, refused = 0;
    for (int round = 0; round < rounds; ++round) {
      std::string bytes = goods[static_cast<std::size_t>(round) % goods.size()];
      for (std::uint32_t k = 0; k <= random() % 4; ++k) {
        const std::size_t among = random() % 3 == 0 ? bytes.size() : std::min<std::size_t>(170, bytes.size());
        bytes[random() % among] = static_cast<char>(random() % 3 == 0 ? 255 : random());
      }
      if (round % 7 == 0) bytes.resize(random() % bytes.size());
      for (const mtf::io::ReadOptions& options :
           {mtf::io::ReadOptions{}, {.channel = "counts"}, {.channel = {}, .layer = {}, .part = 1}})
        try {
          static_cast<void>(read(bytes, options));
          ++read_well;
        } catch (const mtf::Error& error) {
          EXPECT_TRUE(says(error.what(), "a.fff"));
          ++refused;
        }
    }
    EXPECT_GT(read_well, rounds / 5);
    EXPECT_GT(refused, rounds / 5);
  }
  /// The counts as the PNG that another writer makes of them, in the order of the standard.
  std::string png() {
    mtf::Image image(kWidth, kHeight);
    for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<float>(1000 + i);
    mtf::io::write_integer(folder / "a.png", {{"Y", image.view()}}, {}, {});
    return io_test::read_bytes(folder / "a.png");
  }
  TempFolder folder;
  std::string path = folder / "a.fff";
};

TEST_F(Flir, CountsNeedNoScaling) {
  const ImageFile image = read(fff().bytes);
  EXPECT_EQ(image.names, std::vector<std::string>{"counts"});
  EXPECT_EQ(image.planes.front().at(4, 3), 1019.0F);
  EXPECT_FALSE(image.integer);
  EXPECT_EQ(image.info.attributes.at("mtf:quantity"), "counts");
  EXPECT_EQ(image.info.attributes.at("camera_counts.O"), "-600");
  EXPECT_TRUE(image.info.notes.empty());
  EXPECT_EQ(read(fff(png()).bytes).planes.front().at(4, 3), 1019.0F);
  const ImageFile without = read(fff().set(96, 2, 0x21).bytes);
  EXPECT_TRUE(says(without.info.notes.at(0), "constants of its camera are not in it"));
}

TEST_F(Flir, AJpegIsAPictureOfItsCounts) {
  const std::string bytes = fff().bytes, half = bytes.substr(0, 300), rest = bytes.substr(300);
  const std::string file = jpeg(segment(1, 1, rest) + segment(0, 1, half));  // by number, not by place
  const ImageFile picture = read(file);
  EXPECT_EQ(picture.names, std::vector<std::string>{"Y"});
  EXPECT_TRUE(says(picture.info.notes.at(0), "--channel counts"));
  EXPECT_EQ(read(file, {.channel = "counts"}).planes.front().at(4, 3), 1019.0F);
  const ImageFile part = read(jpeg(segment(0, 1, half)));
  EXPECT_TRUE(says(part.info.notes.at(0), "1 of 2 segments"));
  EXPECT_EQ(part.names, std::vector<std::string>{"Y"});
  expect_says(message_of([&] { read(jpeg(segment(0, 1, half)), {.channel = "counts"}); }), {"1 of 2 segments"});
  expect_says(read(jpeg(segment(0, 0, half) + segment(1, 0, rest))).info.notes.at(0), {"2 in place of 1 segments"});
  EXPECT_TRUE(says(read(jpeg(segment(0, 0, half))).info.notes.at(0), "are not readable"));
}

TEST_F(Flir, CountsOfDjiAreOfThePicturesSize) {
  FlirText counts{std::string(2 * 16 * 8, '\0')};
  counts.set(2 * (16 * 7 + 15), 2, 21000);
  const ImageFile image = read(dji(counts.bytes), {.channel = "counts"});
  EXPECT_EQ(image.planes.front().at(15, 7), 21000.0F);
  EXPECT_TRUE(says(image.info.notes.at(0), "what a count is worth"));
  FlirText upright{std::string(2 * 16 * 24, '\0')};  // rows of 16
  for (std::uint32_t i = 0; i < 16 * 24; ++i) upright.set(2 * i, 2, 100 * (i % 16) + i / 16);
  const ImageFile turned = read(dji(upright.bytes, 24, 16), {.channel = "counts"});
  ASSERT_EQ(turned.planes.front().width(), 16);
  EXPECT_EQ(turned.planes.front().at(15, 23), 1523.0F);
  EXPECT_TRUE(says(turned.info.notes, "rows of 16"));
  EXPECT_EQ(read(dji(upright.bytes, 16, 24), {.channel = "counts"}).info.notes.size(), 1U);
  EXPECT_EQ(read(dji(counts.bytes.substr(192)), {.channel = "counts"}).planes.front().at(7, 3), 21000.0F);
  EXPECT_TRUE(says(read(dji(counts.bytes.substr(2))).info.notes.at(0), "columns and rows are not known"));
}

TEST_F(Flir, LyingSizesAreRefused) {
  expect_says(refusal(fff().bytes.substr(0, 190)), {"record 1 of type 1 ends at byte 200 of 190"});
  expect_says(refusal(fff().set(28, 4, 5000).bytes), {"5000 records"});
  expect_says(refusal(fff().set(24, 4, 0xfffffff0U).bytes), {"list of records", "beyond"});
  expect_says(refusal(fff().set(20, 4, 7).bytes), {"version"});
  expect_says(refusal(fff().set(130, 4, 0xffffffffU).bytes), {"pixels"});
  expect_says(refusal(fff().set(132, 2, 400).bytes), {"5x400 counts need 4000 bytes"});
  expect_says(refusal(fff().set(128, 2, 7).bytes), {"tells its order of bytes"});
  expect_says(refusal(fff().set(64, 2, 9).bytes), {"no record of counts"});
  expect_says(refusal(fff(std::string("\xff\xd8\xff\xf7", 4) + std::string(40, 'x')).bytes), {"JPEG-LS"});
  std::string small = png();
  small[19] = 4;  // the width, and with it the checksum of the header
  expect_says(refusal(fff(small).bytes), {"the PNG of its counts", "checksum"});
}

using FlirLong = Flir;
TEST_F(Flir, Mutants) { read_mutants(400); }
TEST_F(FlirLong, Mutants) { read_mutants(5'000); }

}  // namespace
