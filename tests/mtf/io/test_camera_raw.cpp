// SPDX-License-Identifier: Apache-2.0
// DNG by the module of LibRaw. The files were written from the public specification of DNG 1.4 by a program of its own:
// count of row y and column x is 64 + 100 y + 3 x, 32 x 24 pixels, mosaic RGGB with the black levels 64, 64, 65, 66.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"

namespace mtf::io {
namespace {

const std::string kFiles = std::string(MTFKIT_SOURCE_DIR) + "/tests/fuzz/seeds/dngraw/";

TEST(CameraRaw, CountsAreThoseOfTheSensor) {
  for (const char* name : {"little.dng", "big.dng"}) {
    const ImageFile file = read_image(kFiles + name);
    ASSERT_EQ(file.planes.at(0).width(), 32) << name;
    ASSERT_EQ(file.planes.at(0).height(), 24) << name;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 32; ++x)
        ASSERT_EQ(file.planes[0].data()[y * 32 + x], static_cast<float>(64 + 100 * y + 3 * x)) << name;
    EXPECT_TRUE(file.integer);
    EXPECT_EQ(file.info.largest, 4000.0);
    EXPECT_EQ(file.info.attributes.at("mosaic"), "rggb");
    EXPECT_EQ(file.info.attributes.at("black level"), "64 64 65 66");
    EXPECT_EQ(file.info.attributes.at("exposure"), "0.005 s");
    EXPECT_EQ(file.info.attributes.at("camera"), "Acme One");
  }
}

TEST(CameraRaw, DamagedAndForeignFilesAreRefused) {
  const auto folder = std::filesystem::temp_directory_path() / "mtfkit-test-camera-raw";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "cut.dng").string();
  std::ifstream file(kFiles + "little.dng", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (const std::size_t length : {std::size_t{10}, std::size_t{300}, std::size_t{900}, bytes.size() - 1}) {
    std::ofstream(path, std::ios::binary) << bytes.substr(0, length);
    EXPECT_THROW(read_image(path), RuntimeError) << length;
  }
  std::ofstream(path, std::ios::binary) << "P5 2 2 255 abcd";
  expect_refused<RuntimeError>({"cut.dng", "LibRaw says", "TIFF"}, [&] { read_image(path); });
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace mtf::io
