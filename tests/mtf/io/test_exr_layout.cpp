// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include "io_test_files.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "tests/expect_error.h"

namespace {

using io_test::sample;
using io_test::TempFolder;
using mtf::RuntimeError;
using mtf::UsageError;
using mtf::io::ImageFile;
using mtf::io::ReadOptions;

ReadOptions choose(std::optional<std::string> channel, std::optional<std::string> layer = {},
                   std::optional<int> part = {}) {
  return {std::move(channel), std::move(layer), part};
}

// Tiled file whose level (0, 0) holds `sample`; smaller levels hold -1. Tiles of `missing_row` are left out.
void write_tiled(const std::string& path, Imf::Header header, const Imf::TileDescription& tiles, int missing_row = -1) {
  header.setTileDescription(tiles);
  header.lineOrder() = Imf::INCREASING_Y;
  header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  std::vector<float> values = io_test::samples(header.dataWindow());
  std::vector<float> other(values.size(), -1.0F);
  Imf::TiledOutputFile file(path.c_str(), header);
  for (int ly = 0; ly < file.numYLevels(); ++ly) {
    for (int lx = 0; lx < file.numXLevels(); ++lx) {
      if (!file.isValidLevel(lx, ly)) continue;
      const bool full = lx == 0 && ly == 0;
      Imf::FrameBuffer buffer;
      buffer.insert("Y", io_test::slice_of(full ? values : other, header.dataWindow()));
      file.setFrameBuffer(buffer);
      for (int row = 0; row < file.numYTiles(ly); ++row)
        if (!full || row != missing_row) file.writeTiles(0, file.numXTiles(lx) - 1, row, row, lx, ly);
    }
  }
}

void expect_samples(const ImageFile& image, const Imath::Box2i& display, const Imath::Box2i& data) {
  ASSERT_EQ(image.planes.size(), 1U);
  for (int y = display.min.y; y <= display.max.y; ++y)
    for (int x = display.min.x; x <= display.max.x; ++x)
      ASSERT_EQ(image.planes[0].at(x - display.min.x, y - display.min.y),
                data.intersects(Imath::V2i(x, y)) ? sample(x, y) : 0.0F)
          << x << ' ' << y;
}

TEST(ExrLayout, TilesLevelsAndWindows) {
  const TempFolder folder;
  const Imath::Box2i display({-5, 3}, {70, 60});
  for (const Imath::Box2i& data : {display, Imath::Box2i({-12, -4}, {80, 77}), Imath::Box2i({0, 10}, {20, 30})}) {
    for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS}) {
      write_tiled(folder / "a.exr", Imf::Header(display, data), Imf::TileDescription(16, 24, mode));
      expect_samples(mtf::io::read_image(folder / "a.exr"), display, data);
    }
  }
  write_tiled(folder / "a.exr", Imf::Header(64, 32), Imf::TileDescription(16, 16, Imf::MIPMAP_LEVELS));
  EXPECT_EQ(mtf::io::read_info(folder / "a.exr").storage, "tiled zip, 7 mip-map levels");
}

TEST(ExrLayout, TilesLargerThanTheImage) {
  const TempFolder folder;
  const Imath::Box2i window({0, 0}, {2, 1});
  write_tiled(folder / "a.exr", Imf::Header(3, 2), Imf::TileDescription(1024, 1024));
  expect_samples(mtf::io::read_image(folder / "a.exr"), window, window);
}

TEST(ExrLayout, MissingTilesAreRefused) {
  const TempFolder folder;
  write_tiled(folder / "a.exr", Imf::Header(64, 64), Imf::TileDescription(16, 16), 2);
  expect_refused<RuntimeError>({"incomplete"}, [&] { mtf::io::read_image(folder / "a.exr"); });
}

TEST(ExrLayout, MissingScanLinesAreRefused) {
  const TempFolder folder;
  {
    Imf::Header header(32, 64);
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    std::vector<float> values = io_test::samples(header.dataWindow());
    Imf::FrameBuffer buffer;
    buffer.insert("Y", io_test::slice_of(values, header.dataWindow()));
    Imf::OutputFile file((folder / "a.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(40);
  }
  expect_refused<RuntimeError>({"incomplete"}, [&] { mtf::io::read_image(folder / "a.exr"); });
}

TEST(ExrLayout, LayersAndDefaultChoice) {
  const TempFolder folder;
  const std::string path = folder / "a.exr";
  const Imf::Header header(6, 4);
  const auto names = [&](const ReadOptions& options) { return mtf::io::read_image(path, options).names; };
  const auto refused = [&](const ReadOptions& options) {
    return message_of<UsageError>([&] { mtf::io::read_image(path, options); });
  };
  const std::vector<std::string> colours{"R", "G", "B"};

  io_test::write_scanline(path, header, {"A", "B", "G", "R", "depth.Z", "light.R", "light.G", "light.B", "light.A"});
  EXPECT_EQ(names({}), colours);
  EXPECT_EQ(names(choose({}, "light")), colours);
  EXPECT_EQ(names(choose({}, "")), colours);
  EXPECT_EQ(names(choose({}, "depth")), std::vector<std::string>{"depth.Z"});
  EXPECT_EQ(names(choose("depth.Z")), std::vector<std::string>{"depth.Z"});
  EXPECT_EQ(names(choose("G", "light")), std::vector<std::string>{"light.G"});
  expect_says(refused(choose("Q")), {"channel 'Q'", "A (float), B (float)"});
  expect_says(refused(choose({}, "shade")), {"no layer 'shade'"});
  expect_says(refused(choose({}, {}, 3)), {"part 3"});

  io_test::write_scanline(path, header, {"View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Combined.A"});
  EXPECT_EQ(names({}), colours);
  io_test::write_scanline(path, header, {"radiance", "A"});
  EXPECT_EQ(names({}), std::vector<std::string>{"radiance"});
  io_test::write_scanline(path, header, {"S0.550,000000nm", "S0.560,000000nm"});
  EXPECT_EQ(names({}), (std::vector<std::string>{"S0.550,000000nm", "S0.560,000000nm"}));
  EXPECT_EQ(names(choose("S0.560,000000nm")), std::vector<std::string>{"S0.560,000000nm"});
  io_test::write_scanline(path, header, {"u", "v"});
  expect_says(refused({}), {"u (float), v (float)", "--channel"});
  io_test::write_scanline(path, header, {"normal.X", "normal.Y", "normal.Z"});
  EXPECT_NE(refused({}), "");
}

void write_parts(const std::string& path, const std::vector<std::string>& part_names, bool same_channels) {
  std::vector<Imf::Header> headers;
  for (std::size_t i = 0; i < part_names.size(); ++i) {
    Imf::Header header(20, 10);
    header.setName(part_names[i]);
    header.setType(Imf::SCANLINEIMAGE);
    for (const char* name : {"R", "G", "B"})
      header.channels().insert(same_channels ? name : part_names[i] + "." + name, Imf::Channel(Imf::FLOAT));
    headers.push_back(header);
  }
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
  for (std::size_t i = 0; i < headers.size(); ++i) {
    std::vector<float> values(200, static_cast<float>(i + 1));
    Imf::FrameBuffer buffer;
    for (auto c = headers[i].channels().begin(); c != headers[i].channels().end(); ++c)
      buffer.insert(c.name(), io_test::slice_of(values, headers[i].dataWindow()));
    Imf::OutputPart part(file, static_cast<int>(i));
    part.setFrameBuffer(buffer);
    part.writePixels(10);
  }
}

TEST(ExrLayout, MultiPart) {
  const TempFolder folder;
  const std::string path = folder / "a.exr";
  write_parts(path, {"diffuse", "emission"}, true);
  expect_refused({"several parts", "R (float, part 1)", "--part"}, [&] { mtf::io::read_image(path); });
  EXPECT_EQ(mtf::io::read_image(path, choose({}, {}, 1)).planes[2].at(19, 9), 2.0F);
  EXPECT_EQ(mtf::io::read_image(path, choose({}, "diffuse")).planes[0].at(0, 0), 1.0F);
  EXPECT_EQ(mtf::io::read_image(path, choose("G", "emission")).planes[0].at(0, 0), 2.0F);
  EXPECT_EQ(mtf::io::read_info(path).storage, "2 parts: scanline zip, scanline zip");

  write_parts(path, {"diffuse", "emission"}, false);
  EXPECT_EQ(mtf::io::read_image(path, choose("emission.B")).planes[0].at(3, 3), 2.0F);
  EXPECT_EQ(mtf::io::read_image(path, choose({}, "emission")).names, (std::vector<std::string>{"R", "G", "B"}));
}

TEST(ExrLayout, LuminanceChroma) {
  const TempFolder folder;
  const std::string path = folder / "a.exr";
  {
    const std::vector<Imf::Rgba> pixels(32 * 16, Imf::Rgba(0.5F, 0.5F, 0.5F));
    Imf::RgbaOutputFile file(path.c_str(), 32, 16, Imf::WRITE_YC);
    file.setFrameBuffer(pixels.data(), 1, 32);
    file.writePixels(16);
  }
  const ImageFile image = mtf::io::read_image(path);
  EXPECT_EQ(image.names, std::vector<std::string>{"Y"});
  EXPECT_NEAR(image.planes[0].at(31, 15), 0.5, 1e-3);
  EXPECT_EQ(mtf::io::read_image(path, choose("Y")).planes[0].at(3, 3), image.planes[0].at(3, 3));
  expect_refused({"channel RY", "2x2", "full resolution"}, [&] { mtf::io::read_image(path, choose("RY")); });
}

TEST(ExrLayout, DeepIsRefusedByName) {
  const TempFolder folder;
  const std::string path = folder / "a.exr";
  {
    Imf::Header header(4, 2);
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    std::vector<unsigned> counts(8, 1);
    float depth = 3;
    std::vector<float*> pointers(8, &depth);
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(Imf::Slice::Make(Imf::UINT, counts.data(), header.dataWindow()));
    buffer.insert("Z", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers.data()), sizeof(float*),
                                      4 * sizeof(float*), sizeof(float)));
    Imf::DeepScanLineOutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(2);
  }
  expect_refused({"deep data", "flatten"}, [&] { mtf::io::read_image(path); });
  EXPECT_EQ(mtf::io::read_info(path).channels.at(0).type, "deep float");
}

}  // namespace
