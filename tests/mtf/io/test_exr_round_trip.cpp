// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfStringVectorAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>

#include "io_test_files.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"

namespace {

using io_test::sample;
using io_test::TempFolder;
using mtf::Image;
using mtf::UsageError;
using mtf::io::NamedPlane;

Image ramp(std::int64_t width, std::int64_t height) {
  Image image(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) image.at(x, y) = sample(x, y);
  return image;
}

TEST(ExrRoundTrip, FloatsComeBackBitForBit) {
  const TempFolder folder;
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{{1, 1}, {1, 97}, {131, 1}, {37, 53}}) {
    Image red = ramp(width, height), green = ramp(width, height), blue = ramp(width, height);
    red.at(0, 0) = std::numeric_limits<float>::quiet_NaN();
    green.at(width - 1, height - 1) = std::numeric_limits<float>::infinity();
    blue.at(0, height - 1) = 1e-42F;
    mtf::io::write_exr(folder / "a.exr", {{"R", red.view()}, {"G", green.view()}, {"B", blue.view()}}, {});
    const mtf::io::ImageFile read = mtf::io::read_image(folder / "a.exr");
    ASSERT_EQ(read.names, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(std::memcmp(read.planes[0].data(), red.data(), sizeof(float) * static_cast<std::size_t>(red.size())), 0);
    EXPECT_EQ(std::memcmp(read.planes[1].data(), green.data(), sizeof(float) * static_cast<std::size_t>(red.size())),
              0);
    EXPECT_EQ(std::memcmp(read.planes[2].data(), blue.data(), sizeof(float) * static_cast<std::size_t>(red.size())), 0);
    EXPECT_EQ(read.missing_pixels, 0);
    EXPECT_FALSE(read.integer);
    EXPECT_EQ(read.info.storage, "scanline zip");
  }
}

TEST(ExrRoundTrip, ViewsWithAStrideAreWrittenAlone) {
  const TempFolder folder;
  const Image big = ramp(40, 30);
  const mtf::ImageView<const float> part{&big.view().at(5, 6), 11, 9, 40};
  mtf::io::write_exr(folder / "a.exr", {{"Y", part}}, {});
  const mtf::io::ImageFile read = mtf::io::read_image(folder / "a.exr");
  ASSERT_EQ(read.planes[0].width(), 11);
  for (std::int64_t y = 0; y < 9; ++y)
    for (std::int64_t x = 0; x < 11; ++x) ASSERT_EQ(read.planes[0].at(x, y), big.at(x + 5, y + 6));
}

TEST(ExrRoundTrip, MetadataIsTyped) {
  const TempFolder folder;
  const Image image = ramp(4, 3);
  mtf::io::Metadata metadata;
  metadata.text["mtf:units"] = "W.m^-2.sr^-1";
  metadata.pairs["mtf:pixelPitch"] = {15e-6, 0.1};
  metadata.lists["mtf:bandEdges"] = {3.4F, 4.8F};
  metadata.history = {"first", "second"};
  mtf::io::write_exr(folder / "a.exr", {{"Y", image.view()}}, metadata);

  const Imf::MultiPartInputFile file((folder / "a.exr").c_str());
  const auto* pitch = file.header(0).findTypedAttribute<Imf::V2dAttribute>("mtf:pixelPitch");
  ASSERT_NE(pitch, nullptr);
  EXPECT_EQ(pitch->value(), Imath::V2d(15e-6, 0.1));
  const auto* history = file.header(0).findTypedAttribute<Imf::StringVectorAttribute>("mtf:history");
  ASSERT_NE(history, nullptr);
  EXPECT_EQ(history->value(), metadata.history);

  const auto attributes = mtf::io::read_info(folder / "a.exr").attributes;
  EXPECT_EQ(attributes.at("mtf:units"), "W.m^-2.sr^-1");
  EXPECT_EQ(attributes.at("mtf:pixelPitch"), "1.5e-05 0.1");
  EXPECT_EQ(attributes.at("mtf:bandEdges"), "3.4 4.8");
  EXPECT_EQ(attributes.at("mtf:history"), "first\nsecond");
}

TEST(ExrRoundTrip, BadRequestsAreRefusedByName) {
  const TempFolder folder;
  const Image a = ramp(4, 3), b = ramp(5, 3);
  const auto write = [&](const std::vector<NamedPlane>& planes, const mtf::io::Metadata& metadata = {}) {
    return message_of<UsageError>([&] { mtf::io::write_exr(folder / "a.exr", planes, metadata); });
  };
  expect_says(write({}), {"no plane"});
  expect_says(write({{"R", a.view()}, {"G", b.view()}}), {"plane 'G'", "5 x 3"});
  expect_says(write({{"R", a.view()}, {"R", a.view()}}), {"two channels"});
  expect_says(write({{"", a.view()}}), {"channel name"});
  expect_says(write({{"Y", {a.data(), 0, 3, 4}}}), {"0 x 3 pixels"});
  mtf::io::Metadata reserved;
  reserved.text["dataWindow"] = "mine";
  expect_says(write({{"Y", a.view()}}, reserved), {"'dataWindow'"});
  EXPECT_EQ(folder.entries(), 0U);
}

TEST(ExrRoundTrip, HalfAndUnsigned) {
  const TempFolder folder;
  Imf::Header header(3, 1);
  header.channels().insert("H", Imf::Channel(Imf::HALF));
  header.channels().insert("U", Imf::Channel(Imf::UINT));
  const std::vector<half> halves{half(0.5F), half(65504.0F), half(-2.25F)};
  std::vector<unsigned> counts{0, 65536, 16777216};
  Imf::FrameBuffer buffer;
  buffer.insert("H", Imf::Slice::Make(Imf::HALF, halves.data(), header.dataWindow()));
  buffer.insert("U", Imf::Slice::Make(Imf::UINT, counts.data(), header.dataWindow()));
  const auto write = [&](const std::string& name) {
    Imf::OutputFile file((folder / name).c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(1);
  };
  write("a.exr");
  const auto half_plane = mtf::io::read_image(folder / "a.exr", {.channel = "H", .layer = {}, .part = {}});
  const auto count_plane = mtf::io::read_image(folder / "a.exr", {.channel = "U", .layer = {}, .part = {}});
  for (std::int64_t x = 0; x < 3; ++x) {
    EXPECT_EQ(half_plane.planes[0].at(x, 0), static_cast<float>(halves[static_cast<std::size_t>(x)]));
    EXPECT_EQ(count_plane.planes[0].at(x, 0), static_cast<float>(counts[static_cast<std::size_t>(x)]));
  }
  EXPECT_FALSE(half_plane.integer);
  EXPECT_TRUE(count_plane.integer);
  EXPECT_EQ(count_plane.info.channels[0].type, "half");
  EXPECT_EQ(count_plane.info.channels[1].type, "uint");
  counts = {4000000001, 4000000130, 4000000260};  // floats are 256 apart there
  write("b.exr");
  expect_refused<mtf::RuntimeError>({"b.exr", "channel U", "constant"}, [&] {
    mtf::io::read_image(folder / "b.exr", {.channel = "U", .layer = {}, .part = {}});
  });
}

TEST(ExrRoundTrip, EveryCompressionAndWindow) {
  const TempFolder folder;
  const Imath::Box2i display({-20, 10}, {59, 89});
  const std::vector<Imath::Box2i> windows{display,
                                          {{-30, 0}, {70, 100}},
                                          {{0, 30}, {10, 40}},
                                          {{-40, 60}, {0, 120}},
                                          {{100, 10}, {120, 20}},
                                          {{-20, 200}, {59, 210}}};
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    for (const Imath::Box2i& window : windows) {
      Imf::Header header(display, window);
      header.compression() = compression;
      io_test::write_scanline(folder / "a.exr", header, {"Y"});
      const mtf::io::ImageFile read = mtf::io::read_image(folder / "a.exr");
      ASSERT_EQ(read.planes[0].width(), 80);
      ASSERT_EQ(read.planes[0].height(), 80);
      std::int64_t missing = 0;
      for (int y = 0; y < 80; ++y) {
        for (int x = 0; x < 80; ++x) {
          const bool covered = window.intersects(Imath::V2i(x - 20, y + 10));
          missing += covered ? 0 : 1;
          ASSERT_EQ(read.planes[0].at(x, y), covered ? sample(x - 20, y + 10) : 0.0F) << x << ' ' << y;
        }
      }
      EXPECT_EQ(read.missing_pixels, missing);
      EXPECT_EQ(read.info.data_window, (std::array<int, 4>{window.min.x, window.min.y, window.max.x, window.max.y}));
    }
  }
}

// Bytes of this process in memory now, and at their peak.
double resident_bytes() {
  long size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE));
}
double peak_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0;
}

TEST(ExrRoundTrip, ReadingNeedsLittleMoreThanThePlane) {
  const TempFolder folder;
  {
    const Image image = ramp(4096, 4096);
    mtf::io::write_exr(folder / "a.exr", {{"Y", image.view()}}, {});
  }
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer needs more memory than the limit of this test";
#endif
  // A child, whose peak starts from what is in memory here. Free memory of earlier tests is given back first, so that
  // using it again counts.
  ::malloc_trim(0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    bool same = false;
    double planes = 0.0;
    try {
      const double before = resident_bytes();
      const mtf::io::ImageFile read = mtf::io::read_image(folder / "a.exr");
      planes = (peak_bytes() - before) / (4096.0 * 4096 * 4);
      same = read.planes[0].at(4095, 4095) == sample(4095, 4095);
    } catch (...) {
    }
    ::_exit(same ? static_cast<int>(std::min(250.0, 100.0 * planes)) : 255);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_NE(WEXITSTATUS(status), 255) << "the plane did not come back";
  EXPECT_GE(WEXITSTATUS(status), 95) << "per cent of the plane: the measurement sees the plane itself";
  EXPECT_LE(WEXITSTATUS(status), 130) << "per cent of the plane";
}

}  // namespace
