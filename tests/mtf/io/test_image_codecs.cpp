// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <png.h>
#include <tiffio.h>

#include <cstdlib>
#include <filesystem>
#include <limits>

#include "io_test_files.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"

namespace {

using io_test::TempFolder;
using mtf::Image;
using mtf::RuntimeError;
using mtf::UsageError;
using mtf::io::ImageFile;
using mtf::io::IntegerScaling;
using mtf::io::NamedPlane;

Image filled(std::int64_t width, std::int64_t height, double first, double step) {
  Image image(width, height);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<float>(first + step * double(i));
  return image;
}

class Integers : public testing::TestWithParam<const char*> {};

TEST_P(Integers, RoundTripOfCountsAndMetadata) {
  const TempFolder folder;
  const std::string path = folder / GetParam();
  const Image image = filled(37, 23, 100, 7.5);
  mtf::io::Metadata metadata;
  metadata.text["mtf:units"] = "W.m^-2.sr^-1 \xc2\xb5m";
  metadata.pairs["mtf:pixelPitch"] = {15e-6, 12e-6};
  metadata.history = {"one", "two"};
  EXPECT_EQ(mtf::io::write_integer(path, {{"Y", image.view()}}, {0.1, 100}, metadata), 0);
  const ImageFile read = mtf::io::read_image(path);
  EXPECT_TRUE(read.integer);
  EXPECT_EQ(read.names, std::vector<std::string>{"Y"});
  EXPECT_EQ(read.info.channels.at(0).type, "uint16");
  EXPECT_EQ(read.info.storage, "16-bit");
  for (std::int64_t i = 0; i < image.size(); ++i) ASSERT_EQ(read.planes[0].data()[i], static_cast<float>(75 * i)) << i;
  const auto attributes = mtf::io::read_info(path).attributes;
  EXPECT_EQ(attributes.at("gain"), "0.1");
  EXPECT_EQ(attributes.at("offset"), "100");
  EXPECT_EQ(attributes.at("mtf:units"), metadata.text["mtf:units"]);
  EXPECT_EQ(attributes.at("mtf:pixelPitch"), "1.5e-05 1.2e-05");
  EXPECT_EQ(attributes.at("mtf:history"), "one\ntwo");
  EXPECT_EQ(folder.entries(), 1U);
}

TEST_P(Integers, ColoursKeepTheirOrder) {
  const TempFolder folder;
  const std::string path = folder / GetParam();
  const Image red = filled(5, 4, 1, 1), green = filled(5, 4, 1000, 1), blue = filled(5, 4, 60000, 1);
  mtf::io::write_integer(path, {{"R", red.view()}, {"G", green.view()}, {"B", blue.view()}}, {}, {});
  const ImageFile read = mtf::io::read_image(path);
  ASSERT_EQ(read.names, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_EQ(read.planes[0].at(4, 3), 20.0F);
  EXPECT_EQ(read.planes[1].at(4, 3), 1019.0F);
  EXPECT_EQ(read.planes[2].at(4, 3), 60019.0F);
  const ImageFile one = mtf::io::read_image(path, {.channel = "G", .layer = {}, .part = {}});
  ASSERT_EQ(one.planes.size(), 1U);
  EXPECT_EQ(one.planes[0].at(0, 0), 1000.0F);
}

TEST_P(Integers, ClampedSamplesAreCounted) {
  const TempFolder folder;
  Image image(5, 1);
  const float values[] = {-1.0F, 0.0F, 65535.0F, 65536.0F, std::numeric_limits<float>::quiet_NaN()};
  std::copy(std::begin(values), std::end(values), image.data());
  EXPECT_EQ(mtf::io::write_integer(folder / GetParam(), {{"Y", image.view()}}, {}, {}), 3);
  const ImageFile read = mtf::io::read_image(folder / GetParam());
  const float expected[] = {0, 0, 65535, 65535, 0};
  for (std::int64_t x = 0; x < 5; ++x) EXPECT_EQ(read.planes[0].at(x, 0), expected[x]);
}

TEST_P(Integers, EightBitsAreStoredAsTheyAre) {
  const TempFolder folder;
  Image image(6, 1);
  const float values[] = {-1.0F, 0.0F, 127.4F, 255.0F, 256.0F, 65535.0F};
  std::copy(std::begin(values), std::end(values), image.data());
  const IntegerScaling scaling{.gain = 1.0, .offset = 0.0, .bits = 8};
  for (const std::size_t colours : {1U, 3U}) {
    const std::vector<NamedPlane> planes(colours, NamedPlane{"", image.view()});
    const std::string path = folder / GetParam();
    EXPECT_EQ(mtf::io::write_integer(path, planes, scaling, {}), static_cast<std::int64_t>(3 * colours));
    const ImageFile read = mtf::io::read_image(path);
    EXPECT_EQ(read.info.storage, "8-bit");
    EXPECT_EQ(read.info.channels.at(0).type, "uint8");
    EXPECT_EQ(read.info.attributes.at("gain"), "1");
    const float expected[] = {0, 0, 127, 255, 255, 255};
    for (const Image& plane : read.planes)
      for (std::int64_t x = 0; x < 6; ++x) EXPECT_EQ(plane.at(x, 0), expected[x]);
  }
  EXPECT_THROW(mtf::io::write_integer(folder / GetParam(), {{"Y", image.view()}}, {.bits = 12}, {}), UsageError);
}

TEST_P(Integers, CutShortAnywhereIsRefused) {
  const TempFolder folder;
  const Image image = filled(40, 30, 0, 50);
  const std::string whole = folder / GetParam(), cut = folder / (std::string("cut_") + GetParam());
  mtf::io::write_integer(whole, {{"Y", image.view()}}, {}, {});
  const std::string bytes = io_test::read_bytes(whole);
  testing::internal::CaptureStderr();
  for (std::size_t length = 1; length < bytes.size(); length += 1 + bytes.size() / 60) {
    io_test::write_bytes(cut, bytes.substr(0, length));
    EXPECT_TRUE(says(message_of<RuntimeError>([&] { mtf::io::read_image(cut); }), cut)) << length;
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

INSTANTIATE_TEST_SUITE_P(Codecs, Integers, testing::Values("a.png", "a.tif", "a.TIFF"),
                         [](const auto& parameter) { return "Case" + std::to_string(parameter.index); });

TEST(Codecs, FullRangeScaling) {
  const Image image = filled(4, 4, -3, 0.5), flat = filled(4, 4, 7, 0);
  const std::vector<NamedPlane> planes{{"Y", image.view()}};
  const IntegerScaling scaling = mtf::io::full_range_scaling(planes);
  EXPECT_DOUBLE_EQ(scaling.offset, -3);
  EXPECT_DOUBLE_EQ(scaling.gain, 7.5 / 65535);
  EXPECT_DOUBLE_EQ(mtf::io::full_range_scaling({{"Y", flat.view()}}).gain, 1);
  const TempFolder folder;
  EXPECT_EQ(mtf::io::write_integer(folder / "a.png", planes, scaling, {}), 0);
  const ImageFile read = mtf::io::read_image(folder / "a.png");
  EXPECT_EQ(read.planes[0].at(0, 0), 0.0F);
  EXPECT_EQ(read.planes[0].at(3, 3), 65535.0F);
}

TEST(Codecs, Preview) {
  const TempFolder folder;
  const Image image = filled(3, 1, 0, 5);
  mtf::io::write_preview_png(folder / "a.png", {{"Y", image.view()}}, 0, 10);
  const ImageFile read = mtf::io::read_image(folder / "a.png");
  EXPECT_EQ(read.info.channels.at(0).type, "uint8");
  EXPECT_EQ(read.planes[0].at(0, 0), 0.0F);
  EXPECT_EQ(read.planes[0].at(1, 0), 128.0F);
  EXPECT_EQ(read.planes[0].at(2, 0), 255.0F);
  EXPECT_THROW(mtf::io::write_preview_png(folder / "a.tif", {{"Y", image.view()}}, 0, 1), UsageError);
}

TEST(Codecs, BadRequests) {
  const TempFolder folder;
  const Image image = filled(3, 1, 0, 5);
  const std::vector<NamedPlane> two{{"R", image.view()}, {"G", image.view()}};
  EXPECT_THROW(mtf::io::write_integer(folder / "a.png", two, {}, {}), UsageError);
  EXPECT_THROW(mtf::io::write_integer(folder / "a.exr", {{"Y", image.view()}}, {}, {}), UsageError);
  EXPECT_THROW(mtf::io::write_integer(folder / "a.png", {{"Y", image.view()}}, {0, 0}, {}), UsageError);
  EXPECT_THROW(mtf::io::write_integer(folder / "no/a.png", {{"Y", image.view()}}, {}, {}), RuntimeError);
  const auto message = message_of<UsageError>([] { mtf::io::format_from_extension("scene.jpg"); });
  expect_says(message, {".exr", ".png", ".tif", ".tiff"});
  EXPECT_EQ(mtf::io::format_from_extension("a.b/c.TiF"), mtf::io::Format::tiff);
  EXPECT_EQ(folder.entries(), 0U);
}

template <class T>
void write_tiff(const std::string& path, int width, int height, int samples, int format, const std::vector<T>& values,
                int pages = 1, int tile = 0, int photometric = -1) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  for (int page = 0; page < pages; ++page) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(T)));
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, samples);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    const int usual = samples >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, photometric >= 0 ? photometric : usual);
    std::vector<T> copy = values;
    if (tile > 0) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, tile);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, tile);
      TIFFWriteTile(tiff, copy.data(), 0, 0, 0, 0);
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4);
      for (int y = 0; y < height; ++y)
        TIFFWriteScanline(tiff, copy.data() + y * width * samples, static_cast<std::uint32_t>(y), 0);
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

template <class T>
std::vector<T> counting(std::size_t count) {
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(i + 1);
  return values;
}

TEST(Codecs, TiffKinds) {
  const TempFolder folder;
  const std::string path = folder / "a.tif";
  const auto check = [&](const std::string& type, int colours, bool integer) {
    const ImageFile read = mtf::io::read_image(path);
    ASSERT_EQ(read.planes.size(), static_cast<std::size_t>(colours)) << type;
    EXPECT_EQ(read.info.channels.at(0).type, type);
    EXPECT_EQ(read.integer, integer);
    const auto samples = static_cast<std::int64_t>(read.info.channels.size());
    for (std::int64_t i = 0; i < read.planes[0].size(); ++i)
      for (int c = 0; c < colours; ++c)
        ASSERT_EQ(read.planes[static_cast<std::size_t>(c)].data()[i], static_cast<float>(i * samples + c + 1)) << type;
  };
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_UINT, counting<std::uint8_t>(35));
  check("uint8", 1, true);
  write_tiff(path, 7, 5, 3, SAMPLEFORMAT_UINT, counting<std::uint8_t>(105));
  check("uint8", 3, true);
  write_tiff(path, 7, 5, 2, SAMPLEFORMAT_UINT, counting<std::uint8_t>(70));
  check("uint8", 1, true);
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_UINT, counting<std::uint16_t>(35));
  check("uint16", 1, true);
  write_tiff(path, 7, 5, 2, SAMPLEFORMAT_UINT, counting<std::uint16_t>(70));
  check("uint16", 1, true);
  write_tiff(path, 7, 5, 3, SAMPLEFORMAT_UINT, counting<std::uint16_t>(105));
  check("uint16", 3, true);
  write_tiff(path, 7, 5, 4, SAMPLEFORMAT_UINT, counting<std::uint16_t>(140));
  check("uint16", 3, true);
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_IEEEFP, counting<float>(35));
  check("float", 1, false);
  write_tiff(path, 7, 5, 3, SAMPLEFORMAT_IEEEFP, counting<float>(105));
  check("float", 3, false);
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_IEEEFP, counting<double>(35));
  check("double", 1, false);
  write_tiff(path, 7, 5, 3, SAMPLEFORMAT_IEEEFP, counting<double>(105));
  check("double", 3, false);
  auto high = counting<double>(105);
  for (double& value : high) value = 1e8 + 1e-2 * value;
  write_tiff(path, 7, 5, 3, SAMPLEFORMAT_IEEEFP, high);
  expect_refused<RuntimeError>({"a.tif", "channel R", "constant"}, [&] { mtf::io::read_image(path); });
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_UINT, counting<std::uint16_t>(35), 3);
  check("uint16", 1, true);
  write_tiff(path, 16, 16, 1, SAMPLEFORMAT_IEEEFP, counting<float>(256), 1, 16);
  check("float", 1, false);
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_INT, counting<std::int8_t>(35));
  check("int8", 1, true);
  write_tiff(path, 7, 5, 3, SAMPLEFORMAT_INT, counting<std::int16_t>(105));
  check("int16", 3, true);
}

TEST(Codecs, TiffKindsThatAreNotRead) {
  const TempFolder folder;
  const std::string path = folder / "a.tif";
  const auto message = [&] { return message_of<RuntimeError>([&] { mtf::io::read_image(path); }); };
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_INT, counting<std::int32_t>(35));
  expect_says(message(), {"signed 32-bit"});
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_UINT, counting<std::uint32_t>(35));
  expect_says(message(), {"32-bit"});
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_UINT, counting<std::uint8_t>(35), 1, 0, PHOTOMETRIC_MINISWHITE);
  expect_says(message(), {"the least is white"});
}

void write_png(const std::string& path, int width, int height, int colour, int bits,
               const std::vector<std::uint8_t>& rows) {
  FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits, colour,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  const png_color palette[] = {{1, 2, 3}, {40, 50, 60}};
  if (colour == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 2);
  png_write_info(png, info);
  const std::size_t bytes = rows.size() / static_cast<std::size_t>(height);
  for (int y = 0; y < height; ++y) png_write_row(png, rows.data() + static_cast<std::size_t>(y) * bytes);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

TEST(Codecs, PngKinds) {
  const TempFolder folder;
  const std::string path = folder / "a.png";
  write_png(path, 3, 2, PNG_COLOR_TYPE_GRAY_ALPHA, 8, {10, 1, 20, 2, 30, 3, 40, 4, 50, 5, 60, 6});
  ImageFile read = mtf::io::read_image(path);
  EXPECT_EQ(read.names, std::vector<std::string>{"Y"});
  EXPECT_EQ(read.planes[0].at(2, 1), 60.0F);
  EXPECT_EQ(
      message_of<UsageError>([&] { mtf::io::read_image(path, {.channel = "A", .layer = {}, .part = {}}); }).empty(),
      false);
  write_png(path, 2, 1, PNG_COLOR_TYPE_RGB_ALPHA, 8, {1, 2, 3, 4, 5, 6, 7, 8});
  read = mtf::io::read_image(path);
  EXPECT_EQ(read.names, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_EQ(read.planes[0].at(1, 0), 5.0F);
  EXPECT_EQ(read.planes[2].at(1, 0), 7.0F);
  write_png(path, 4, 1, PNG_COLOR_TYPE_GRAY, 2, {0x1b});  // counts 0 1 2 3
  read = mtf::io::read_image(path);
  EXPECT_EQ(read.info.storage, "2-bit");
  for (std::int64_t x = 0; x < 4; ++x) EXPECT_EQ(read.planes[0].at(x, 0), static_cast<float>(x));
}

TEST(Codecs, PngPalettesAndBothBytes) {
  const TempFolder folder;
  const std::string path = folder / "a.png";
  write_png(path, 3, 1, PNG_COLOR_TYPE_PALETTE, 1, {0x40});  // entries 0 1 0
  ImageFile read = mtf::io::read_image(path);
  ASSERT_EQ(read.names, (std::vector<std::string>{"R", "G", "B"}));
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(read.planes[c].at(0, 0), 1.0F + float(c));
    EXPECT_EQ(read.planes[c].at(1, 0), 40.0F + 10.0F * float(c));
  }
  write_png(path, 2, 1, PNG_COLOR_TYPE_GRAY_ALPHA, 16, {1, 2, 0, 0, 3, 4, 0, 0});
  read = mtf::io::read_image(path);
  EXPECT_EQ(read.planes[0].at(0, 0), 258.0F);
  EXPECT_EQ(read.planes[0].at(1, 0), 772.0F);
}

// Every byte of a PNG is covered by a length, a checksum or the signature.
TEST(Codecs, DamagedPngIsRefused) {
  const TempFolder folder;
  const std::string path = folder / "a.png";
  write_png(path, 3, 2, PNG_COLOR_TYPE_GRAY, 8, {10, 20, 30, 40, 50, 60});
  const std::string bytes = io_test::read_bytes(path);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x15);
    io_test::write_bytes(path, changed);
    EXPECT_NE(message_of<RuntimeError>([&] { mtf::io::read_image(path); }), "") << at;
  }
}

TEST(Codecs, HugeAnnouncedSizesAreRefused) {
  const TempFolder folder;
  const std::string path = folder / "a.tif";
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_UINT, counting<std::uint8_t>(35));
  TIFF* tiff = TIFFOpen(path.c_str(), "r+");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 1000000);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1000000);
  TIFFRewriteDirectory(tiff);
  TIFFClose(tiff);
  expect_refused<RuntimeError>({"TiB"}, [&] { mtf::io::read_image(path); });
}

TEST(Codecs, DamagedTiffNeverCrashes) {
  const TempFolder folder;
  const std::string path = folder / "a.tif";
  write_tiff(path, 7, 5, 1, SAMPLEFORMAT_UINT, counting<std::uint16_t>(35));
  const std::string bytes = io_test::read_bytes(path);
  int refused = 0;
  testing::internal::CaptureStderr();
  for (std::size_t at = 4; at < bytes.size(); ++at) {
    for (const char value : {'\0', '\x7f', '\xff'}) {
      std::string changed = bytes;
      changed[at] = value;
      io_test::write_bytes(path, changed);
      refused += message_of<mtf::Error>([&] { mtf::io::read_image(path); }).empty() ? 0 : 1;
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(refused, 20);
}

TEST(Codecs, SharedPngsAreRead) {
  const auto data = io_test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  int files = 0;
  for (const char* sub : {"thermal", "edges"}) {
    for (const auto& entry : std::filesystem::directory_iterator(data / sub)) {
      if (entry.path().extension() != ".png") continue;
      const ImageFile read = mtf::io::read_image(entry.path().string());
      EXPECT_TRUE(read.integer);
      EXPECT_EQ(read.planes[0].width(), read.info.width);
      ++files;
    }
  }
  EXPECT_GT(files, 20);
}

TEST(Codecs, MissingModuleIsExplained) {
  const TempFolder folder;
  const std::string path = folder / "a.png";
  write_png(path, 1, 1, PNG_COLOR_TYPE_GRAY, 8, {10});
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a new process: here the module may be loaded already
  EXPECT_EXIT(
      {
        ::setenv("MTFKIT_CODECS", "/nowhere/codecs.so", 1);
        const std::string message = message_of<RuntimeError>([&] { mtf::io::read_image(path); });
        const bool clear = message.find("/nowhere/codecs.so") != std::string::npos &&
                           message.find("MTFKIT_CODECS") != std::string::npos;
        std::filesystem::remove_all(std::filesystem::path(path).parent_path());  // _exit runs no destructors
        ::_exit(clear ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
