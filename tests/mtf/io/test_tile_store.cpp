// SPDX-License-Identifier: Apache-2.0
// Scenes in windows, tiled output, and what a stopped run leaves.
#include "mtf/io/tile_store.h"

#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/io/exr/exr_read.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"

namespace {

using io_test::TempFolder;
using mtf::Image;
using mtf::ImageView;
using mtf::Region;
using mtf::io::TileStore;

Image pattern(std::int64_t width, std::int64_t height, float shift = 0.0F) {
  Image image(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) image.at(x, y) = io_test::sample(x, y) + shift;
  return image;
}

void expect_windows_of_the_image(const std::string& path) {
  const mtf::io::ImageFile whole = mtf::io::read_image(path);
  const mtf::io::ExrWindows windows(path, {});
  const std::int64_t width = whole.planes[0].width(), height = whole.planes[0].height();
  for (const Region w : {Region{0, 0, width, height}, Region{3, 5, 7, 9}, Region{width - 4, height - 2, 4, 2}})
    for (std::size_t c = 0; c < whole.planes.size(); ++c) {
      Image part(w.width, w.height);
      windows.read(c, w.x, w.y, part.view());
      for (std::int64_t y = 0; y < w.height; ++y)
        for (std::int64_t x = 0; x < w.width; ++x)
          ASSERT_EQ(part.at(x, y), whole.planes[c].at(w.x + x, w.y + y)) << path << " " << x << " " << y;
    }
}

TEST(ExrWindows, EqualTheWholeImage) {
  const TempFolder folder;
  io_test::write_scanline(folder / "lines.exr", Imf::Header(70, 700), {"R", "G", "B"});
  expect_windows_of_the_image(folder / "lines.exr");
  // A data window that is shifted against the display window.
  Imf::Header shifted(Imath::Box2i({0, 0}, {59, 49}), Imath::Box2i({-5, 10}, {40, 70}));
  io_test::write_scanline(folder / "shifted.exr", shifted, {"Y"});
  expect_windows_of_the_image(folder / "shifted.exr");
  const Image plane = pattern(300, 530);
  mtf::io::write_tiled_exr(
      folder / "tiles.exr", {"Y"}, 300, 530,
      [&](std::int64_t first, std::span<const ImageView<float>> rows) {
        for (std::int64_t y = 0; y < rows[0].height; ++y) std::copy_n(plane.view().row(first + y), 300, rows[0].row(y));
      },
      {}, 2);
  const mtf::io::ImageFile back = mtf::io::read_image(folder / "tiles.exr");
  expect_says(back.info.storage, {"tiled"});
  for (std::int64_t i = 0; i < plane.size(); ++i) ASSERT_EQ(back.planes[0].data()[i], plane.data()[i]);
  expect_windows_of_the_image(folder / "tiles.exr");
}

class Store : public testing::Test {
 protected:
  // Four tiles of 10 x 10 in 20 x 20 pixels, with three counts each.
  mtf::io::TileStoreLayout layout(const std::string& key = "a run", std::size_t counts = 3) const {
    return {key, 20, 20, 1, 4, counts, [](std::int64_t i) { return Region{i % 2 * 10, i / 2 * 10, 10, 10}; }};
  }
  void put(TileStore& store, std::int64_t tile) const {
    const Image plane = pattern(10, 10, static_cast<float>(tile));
    const ImageView<const float> view = plane.view();
    store.write(tile, std::span(&view, 1), {tile, 5, 6});
  }
  void stop_after_two() const {
    TileStore store(out, layout(), true);
    put(store, 0);
    put(store, 3);
  }
  const TempFolder folder;
  const std::string out = folder / "out.exr";
};

TEST_F(Store, GoesOnWithFinishedTiles) {
  stop_after_two();
  TileStore store(out, layout(), true);
  EXPECT_EQ(store.resumed(), 2);
  EXPECT_EQ(store.note(), "");
  EXPECT_TRUE(store.done(0) && store.done(3) && !store.done(1));
  Image rows(20, 20);
  put(store, 1);
  put(store, 2);
  store.read_rows(0, 0, rows.view());
  for (std::int64_t y = 0; y < 20; ++y)
    for (std::int64_t x = 0; x < 20; ++x)
      ASSERT_EQ(rows.at(x, y), io_test::sample(x % 10, y % 10) + static_cast<float>(x / 10 + y / 10 * 2));
  store.remove();
  EXPECT_EQ(folder.entries(), 0U);
}

TEST_F(Store, KeepsTheCountsOfFinishedTiles) {
  const Image plane = pattern(10, 10);
  const ImageView<const float> view = plane.view();
  {
    TileStore store(out, layout(), true);
    EXPECT_TRUE(store.resumed_counts().empty());
    store.write(2, std::span(&view, 1), {1, -2, 3});
    store.write(1, std::span(&view, 1), {4, 0, 0});
  }
  TileStore store(out, layout(), true);
  EXPECT_EQ(store.resumed_counts(), (std::vector<mtf::io::TileCounts>{{1, -2, 3}, {4, 0, 0}}));
  expect_refused({"1 counts"}, [&] { store.write(0, std::span(&view, 1), {4}); });
  store.remove();
}

TEST_F(Store, StartsOverWhenAskedOrForAnotherRun) {
  stop_after_two();
  EXPECT_EQ(TileStore(out, layout(), false).resumed(), 0);
  for (const auto& another : {layout("another run"), layout("a run", 12)}) {
    stop_after_two();
    const TileStore other(out, another, true);
    EXPECT_EQ(other.resumed(), 0);
    expect_says(other.note(), {"another run or scene"});
  }
}

TEST_F(Store, StartsOverWhenDamagedAndSaysSo) {
  for (const int damage : {0, 1, 2, 3}) {
    stop_after_two();
    const std::string path = out + (damage == 0 ? ".part" : ".part.tiles");
    std::string bytes = io_test::read_bytes(path);
    if (damage == 0) bytes[100] = static_cast<char>(bytes[100] ^ 1);    // a pixel of tile 0
    if (damage == 1) bytes[bytes.size() - 12] = static_cast<char>(99);  // a tile that there is not
    if (damage == 2) bytes[3] = '?';                                    // the header
    if (damage == 3) bytes[bytes.size() - 30] = static_cast<char>(99);  // a count
    io_test::write_bytes(path, bytes);
    TileStore store(out, layout(), true);
    EXPECT_EQ(store.resumed(), 0) << damage;
    EXPECT_TRUE(says(store.note(), "starting over")) << damage << store.note();
    store.remove();
  }
}

TEST_F(Store, ARecordCutShortIsATileToBeDoneAgain) {
  stop_after_two();
  const std::string path = out + ".part.tiles";
  const std::string bytes = io_test::read_bytes(path);
  io_test::write_bytes(path, bytes.substr(0, bytes.size() - 5));
  TileStore store(out, layout(), true);
  EXPECT_EQ(store.resumed(), 1);
  put(store, 3);
}

TEST_F(Store, TwoRunsDoNotShareAStore) {
  const TileStore first(out, layout(), true);
  expect_refused<mtf::RuntimeError>({"another run"}, [&] { TileStore(out, layout(), true); });
  EXPECT_THROW(TileStore(folder / "no/such/out.exr", layout(), true), mtf::RuntimeError);
}

}  // namespace
