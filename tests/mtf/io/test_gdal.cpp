// SPDX-License-Identifier: Apache-2.0
// NITF, HDF5 and JPEG 2000 by the module of GDAL. The files are those of gdal_translate, made of the PGM beside them;
// the PGM's pixels come by our own reader, another route.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "mtf/io/image_windows.h"
#include "tests/mtf/io/io_test_files.h"

namespace mtf::io {
namespace {

const std::string kSeeds = std::string(MTFKIT_SOURCE_DIR) + "/tests/fuzz/seeds/";
const std::string kFiles = kSeeds + "gdal/";

std::vector<float> pixels_of(const Image& image) { return {image.data(), image.data() + image.size()}; }

TEST(Gdal, PixelsAreThoseOfTheOriginal) {
  const std::vector<float> original = pixels_of(read_image(kSeeds + "pgmppm/p5").planes.at(0));
  for (const char* name : {"a.ntf", "geo.ntf", "a.jp2"}) {
    const ImageFile file = read_image(kFiles + name);
    EXPECT_EQ(file.info.format, Format::gdal) << name;
    EXPECT_TRUE(file.integer) << name;
    EXPECT_EQ(file.names, std::vector<std::string>{"Y"}) << name;
    EXPECT_EQ(pixels_of(file.planes.at(0)), original) << name;
    const ImageWindows windows(kFiles + name, {});
    Image part(3, 2);
    windows.read(0, 2, 1, part.view());
    EXPECT_EQ(part.data()[0], original[8 + 2]) << name;
    EXPECT_EQ(part.data()[5], original[2 * 8 + 4]) << name;
  }
}

TEST(Gdal, RowsOfHdf5AreAsStored) {  // netCDF, as GDAL writes it, begins with the bottom row
  const std::vector<float> original = pixels_of(read_image(kSeeds + "pgmppm/p5").planes.at(0));
  const std::vector<float> stored = pixels_of(read_image(kFiles + "a.h5").planes.at(0));
  for (std::size_t y = 0; y < 6; ++y)
    for (std::size_t x = 0; x < 8; ++x) EXPECT_EQ(stored[y * 8 + x], original[(5 - y) * 8 + x]);
  // gdal_translate -of netCDF -co FORMAT=NC4 -ot UInt16 -a_scale 0.01 -a_offset -50 -a_nodata 7: attributes of HDF5.
  const ImageFile scaled = read_image(kFiles + "scaled.h5");
  EXPECT_TRUE(scaled.info.storage.ends_with("scale 0.01 and offset -50 applied"));
  EXPECT_TRUE(scaled.info.no_data.starts_with("7 ")) << scaled.info.no_data;
  for (std::size_t i = 0; i < 48; ++i)
    if (stored[i] == 7.0F)
      EXPECT_TRUE(std::isnan(scaled.planes[0].data()[i]));
    else
      EXPECT_EQ(scaled.planes[0].data()[i], static_cast<float>(0.01 * double{stored[i]} - 50.0));
  EXPECT_EQ(std::ranges::count(stored, 7.0F), 1);
}

TEST(Gdal, PlacesAreKept) {
  const FileInfo info = read_info(kFiles + "geo.ntf");
  EXPECT_TRUE(info.attributes.at("geotransform").starts_with("9.00005952")) << info.attributes.at("geotransform");
  EXPECT_TRUE(info.attributes.at("coordinate system").starts_with("GEOGCS"));
  EXPECT_EQ(info.pixel_aspect, 1.0);  // degrees say nothing of lengths
  EXPECT_EQ(info.channels.at(0).type, "int16");
}

TEST(Gdal, CutFilesAreRefused) {
  const auto folder = std::filesystem::temp_directory_path() / "mtfkit-test-gdal";
  std::filesystem::create_directories(folder);
  for (const char* name : {"a.ntf", "a.jp2", "a.h5"}) {
    std::ifstream file(kFiles + name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    for (const double share : {0.05, 0.3, 0.6, 0.95}) {
      const std::string cut = (folder / name).string();
      std::ofstream(cut, std::ios::binary)
          << bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size())));
      EXPECT_THROW(read_image(cut), RuntimeError) << name << " " << share;
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace mtf::io
