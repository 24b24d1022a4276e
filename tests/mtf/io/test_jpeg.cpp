// SPDX-License-Identifier: Apache-2.0
// JPEG files: the luminance plane, what its quantisation tables say of the errors of its pixels, and bad files.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "mtf/error.h"
#include "mtf/io/codecs/encoding.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"
#include "tests/mtf/io/jpeg_file.h"

namespace {

using io_test::jpeg_steps;
using io_test::JpegSteps;
using io_test::JpegWriter;

/// A ramp with noise, of sides that are no multiples of 8.
mtf::Image noisy_ramp() {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.0F, 12.0F);
  mtf::Image image(45, 37);
  for (std::int64_t y = 0; y < image.height(); ++y)
    for (std::int64_t x = 0; x < image.width(); ++x)
      image.at(x, y) = std::round(90.0F + 1.5F * static_cast<float>(x) + noise(random));
  return image;
}

struct Jpeg : testing::Test {
  io_test::TempFolder folder;
  std::string path = folder / "image.jpg";

  void write(const std::string& bytes) const { std::ofstream(path, std::ios::binary) << bytes; }
  std::string refusal() const {
    return message_of<mtf::RuntimeError>([&] { mtf::io::read_image(path); });
  }
};

double rms_difference(const mtf::Image& a, const mtf::Image& b) {
  double sum = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i) sum += std::pow(a.data()[i] - b.data()[i], 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST_F(Jpeg, TheLuminancePlaneAsItIsStored) {
  const mtf::Image image = noisy_ramp();
  JpegSteps ones;
  ones.fill(1);
  for (const bool colour : {false, true}) {
    io_test::write_jpeg(path, image.view(), ones, colour);
    const mtf::io::ImageFile file = mtf::io::read_image(path);
    EXPECT_EQ(file.names, std::vector<std::string>{"Y"});
    EXPECT_TRUE(file.integer);
    EXPECT_EQ(file.info.format, mtf::io::Format::jpeg);
    EXPECT_EQ(file.info.encoding.word, "srgb");
    EXPECT_EQ(file.info.storage, colour ? "8-bit, luminance of a colour image, chroma 2x2" : "8-bit");
    ASSERT_EQ(file.planes.at(0).width(), image.width());
    // Two roundings: of coefficients in steps of 1, and of the decoded pixels.
    EXPECT_LT(rms_difference(file.planes[0], image), 0.45);
    mtf::io::ReadOptions choice;
    choice.channel = "R";
    EXPECT_THROW(mtf::io::read_image(path, choice), mtf::UsageError);
    choice.channel = "Y";
    EXPECT_NO_THROW(mtf::io::read_image(path, choice));
  }
}

// Where the noise is larger than the steps, errors are spread evenly over them, and the sum over the table is the
// error.
TEST_F(Jpeg, QuantisationTablesSayTheErrorOfPixels) {
  const mtf::Image image = noisy_ramp();
  for (const int quality : {85, 92, 96}) {
    io_test::write_jpeg(path, image.view(), jpeg_steps(quality));
    const mtf::io::ImageFile file = mtf::io::read_image(path);
    ASSERT_EQ(file.info.dct_steps.size(), 64U);
    EXPECT_EQ(file.info.dct_steps[0], jpeg_steps(quality)[0]);
    EXPECT_EQ(file.info.dct_steps[2], jpeg_steps(quality)[8]);  // in the order of the zigzag
    const double limit = mtf::io::dct_rounding_sd(file.info.dct_steps);
    const double error = rms_difference(file.planes.at(0), image);
    EXPECT_GT(error, 0.85 * limit) << quality;
    EXPECT_LT(error, std::hypot(1.05 * limit, std::sqrt(1.0 / 12.0))) << quality;
  }
  EXPECT_EQ(mtf::io::dct_rounding_sd({}), 0.0);
}

TEST_F(Jpeg, SegmentsOfApplications) {
  using std::string_literals::operator""s;
  const mtf::Image image = noisy_ramp();
  const std::string exif =
      "Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"s;  // turned by a quarter
  io_test::write_jpeg(path, image.view(), jpeg_steps(95), false, JpegWriter::segment(0xe1, exif));
  EXPECT_EQ(mtf::io::read_image(path).planes.at(0).width(), image.width());
  EXPECT_EQ(mtf::io::read_info(path).encoding.source, "JPEG, sRGB by convention");

  std::string profile(128, '\0');
  profile +=
      "\0\0\0\x01"
      "desc\0\0\0\x90\0\0\0\x16"s +
      "desc\0\0\0\0\0\0\0\x0a"
      "Display P3"s;
  io_test::write_jpeg(path, image.view(), jpeg_steps(95), false,
                      JpegWriter::segment(0xe2, "ICC_PROFILE\0\x01\x01"s + profile));
  EXPECT_EQ(mtf::io::read_info(path).encoding.source, "JPEG with the ICC profile \"Display P3\"");
  EXPECT_EQ(mtf::io::read_info(path).encoding.word, "srgb");

  io_test::write_jpeg(path, image.view(), jpeg_steps(95), true, JpegWriter::segment(0xee, "Adobe\0\x64\0\0\0\0\0"s));
  expect_says(refusal(), {"red, green and blue"});
}

// Whole by its segments, damaged inside: a decoder makes an image of that too.
TEST_F(Jpeg, DamagedPixelDataAreRefused) {
  const std::string good = JpegWriter::make(noisy_ramp().view(), jpeg_steps(90));
  const std::size_t frame = good.find("\xff\xc0");
  std::string taller = good, shorter = good, overwritten = good;
  taller[frame + 6] = static_cast<char>(taller[frame + 6] + 16);
  shorter[frame + 6] = static_cast<char>(shorter[frame + 6] - 16);
  for (std::size_t i = 0; i < 60; ++i) overwritten[good.size() / 2 + 10 + i] = static_cast<char>(0x5b + i % 7);
  for (const std::string& bytes : {taller, shorter, overwritten}) {
    write(bytes);
    expect_says(refusal(), {"damaged", "JPEG"});
  }
}

TEST_F(Jpeg, BadFilesAreRefusedBeforeTheyAreDecoded) {
  const std::string good = JpegWriter::make(noisy_ramp().view(), jpeg_steps(90));
  for (const std::size_t length :
       {std::size_t{3}, std::size_t{30}, std::size_t{100}, good.size() / 2, good.size() - 1}) {
    write(good.substr(0, length));
    EXPECT_TRUE(says(refusal(), length == 3 ? "JPEG" : "damaged or incomplete JPEG")) << length;
  }
  const std::size_t frame = good.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  const auto with = [&](std::size_t at, char byte) {
    std::string bytes = good;
    bytes[frame + at] = byte;
    write(bytes);
    return refusal();
  };
  expect_says(with(1, '\xc9'), {"arithmetic"});
  expect_says(with(4, 12), {"12 bits"});
  expect_says(with(9, 4), {"JPEG"});
  std::string flat = good;
  flat[flat.find("\xff\xdb") + 5] = '\0';
  write(flat);
  expect_says(refusal(), {"quantisation step of 0"});
  write(good);
  EXPECT_EQ(refusal(), "");
}

}  // namespace
