// SPDX-License-Identifier: Apache-2.0
// Lines and words over a picture.

#include <gtest/gtest.h>

#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/drawing.h"

namespace {

using mtf::io::Drawing;
using mtf::io::RasterData;

RasterData grey(std::int64_t width, std::int64_t height, std::uint16_t value) {
  RasterData data{width, height, 3, 8, {}, {}};
  data.samples.assign(static_cast<std::size_t>(3 * width * height), value);
  return data;
}

/// Rectangle of the pixels with at least half of red, of a picture without red.
struct Ink {
  std::int64_t left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
};
Ink ink_of(const RasterData& picture) {
  Ink ink;
  for (std::int64_t y = 0; y < picture.height; ++y)
    for (std::int64_t x = 0; x < picture.width; ++x)
      if (picture.samples[static_cast<std::size_t>(3 * (y * picture.width + x))] >= 128)
        ink = {std::min(ink.left, x), std::max(ink.right, x), std::min(ink.top, y), std::max(ink.bottom, y)};
  return ink;
}

TEST(PicturesDrawnUpon, LinesLieWhereTheirPointsAre) {
  Drawing drawing;
  drawing.zoom = 4;
  drawing.strokes.push_back({{{2.125, 3.125}, {8.125, 3.125}}, {255, 0, 0}});  // the middle of pixel (8, 12)
  const RasterData picture = drawn(grey(12, 6, 0), drawing);
  ASSERT_EQ(picture.width, 48);
  ASSERT_EQ(picture.height, 24);
  const Ink ink = ink_of(picture);
  EXPECT_EQ(ink.top, 12);
  EXPECT_EQ(ink.bottom, 12);
  EXPECT_EQ(ink.left, 8);
  EXPECT_EQ(ink.right, 32);
}

TEST(PicturesDrawnUpon, WordsStandOnTheirBaseLine) {
  const auto ink = [](const std::string& text, double alignment, double size = 1.0) {
    Drawing drawing;
    drawing.captions.push_back({100, 50, text, {255, 0, 0}, size, alignment});
    return ink_of(drawn(grey(200, 80, 0), drawing));
  };
  const Ink left = ink("MTF", 0.0), middle = ink("MTF", 0.5), right = ink("MTF", 1.0), large = ink("MTF", 0.0, 3.0);
  EXPECT_NEAR(double(left.bottom), 50.0, 1.0);
  EXPECT_NEAR(double(left.bottom - left.top), 9.0, 1.0);
  EXPECT_NEAR(double(large.bottom - large.top), 27.0, 2.0);
  EXPECT_NEAR(double(left.left), 102.0, 2.0);
  EXPECT_NEAR(double(right.right), 98.0, 2.0);
  EXPECT_NEAR(double(middle.left + middle.right), 200.0, 2.0);
  EXPECT_EQ(middle.right - middle.left, left.right - left.left);
  EXPECT_EQ(ink(" ", 0.0).right, -1);
  EXPECT_LT(ink("^", 0.0).bottom, 48);
  EXPECT_GT(ink("j", 0.0).bottom, left.bottom + 1);
  EXPECT_GT(ink("\xc3", 0.0).right, 0);  // beyond ASCII: a question mark
}

// The ends and the middle of the published map.
TEST(PicturesDrawnUpon, FalseColoursAreThoseOfInferno) {
  Drawing drawing;
  drawing.false_colour = true;
  const std::array<std::array<int, 4>, 3> cases{{{0, 0, 0, 4}, {128, 188, 55, 84}, {255, 252, 255, 164}}};
  for (const auto& [value, red, green, blue] : cases) {
    const RasterData picture = drawn(grey(1, 1, static_cast<std::uint16_t>(value)), drawing);
    EXPECT_NEAR(picture.samples[0], red, 1) << value;
    EXPECT_NEAR(picture.samples[1], green, 1) << value;
    EXPECT_NEAR(picture.samples[2], blue, 1) << value;
  }
}

}  // namespace
