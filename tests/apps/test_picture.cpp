// SPDX-License-Identifier: Apache-2.0

// Pictures for the eye: grey values, the bar and what it says of clipped values.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "apps/figures/picture.h"
#include "mtf/io/image_io.h"
#include "tests/apps/command.h"

namespace apps_test {
namespace {

mtf::Image image_of(std::initializer_list<float> row) {
  mtf::Image image(static_cast<std::int64_t>(row.size()), 1);
  std::copy(row.begin(), row.end(), image.data());
  return image;
}

TEST(Picture, TheBarNamesItsRangeAndWhatIsClipped) {
  const mtf::Image image = image_of({1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  const apps::BarEnds whole = apps::bar_ends({"", image.view(), 1, 1.0, 10.0, ""});
  EXPECT_EQ(whole.low, "1");
  EXPECT_EQ(whole.high, "10");
  const apps::BarEnds clipped = apps::bar_ends({"", image.view(), 1, 3.0, 9.5, ""});
  EXPECT_EQ(clipped.low, "3 and below: 20 %");
  EXPECT_EQ(clipped.high, "9.5 and above: 10 %");
}

TEST(Picture, PixelsBecomeSquaresAndTheBarRunsFromBlackToWhite) {
  const Scratch scratch;
  const mtf::Image image = image_of({0, 5, 10});
  const std::string file = (scratch / "p.png").string();
  apps::write_picture(file, std::array{apps::Panel{"", image.view(), 100, 0.0, 10.0, ""}});
  const mtf::Image picture = std::move(mtf::io::read_image(file).planes.front());
  // The rows that hold the panel: exact grey values in squares of 100 pixels, a margin of 16 around them.
  std::int64_t rows = 0;
  for (std::int64_t y = 0; y < picture.height(); ++y) {
    if (picture.at(16, y) != 0.0F || picture.at(315, y) != 255.0F || picture.at(116, y) != 128.0F) continue;
    ++rows;
    EXPECT_EQ(picture.at(115, y), 0.0F);
    EXPECT_EQ(picture.at(215, y), 128.0F);
    EXPECT_EQ(picture.at(216, y), 255.0F);
  }
  EXPECT_EQ(rows, 100);
  // A row that rises all along is the bar: its frame covers the two ends.
  bool bar = false;
  for (std::int64_t y = 0; y < picture.height(); ++y) {
    const float* row = picture.view().row(y);
    bar = bar || (std::is_sorted(row + 18, row + 314) && row[18] < 4.0F && row[313] > 250.0F && row[165] == 127.0F);
  }
  EXPECT_TRUE(bar);
}

TEST(Picture, TheDemoClipsNothingAndSaturatesNothing) {
  const Scratch scratch;
  const Result demo = scratch.run("mtf demo -o d");
  ASSERT_EQ(demo.status, 0) << demo.err;
  EXPECT_FALSE(says(demo.out, "camera.exr is saturated")) << demo.out;
  const auto largest = [&](const char* name) {
    const mtf::Image image = std::move(mtf::io::read_image((scratch / "d" / name).string()).planes.front());
    return *std::max_element(image.data(), image.data() + image.size());
  };
  EXPECT_LT(largest("sensor.exr"), largest("scene.exr"));
  // The scene's whitest pixels are its highlights: less than 0.1 % of the left panel.
  const mtf::Image picture = std::move(mtf::io::read_image((scratch / "d/preview.png").string()).planes.front());
  std::int64_t white = 0;
  for (std::int64_t y = 60; y < 1060; ++y)
    white += std::count(picture.view().row(y) + 16, picture.view().row(y) + 16 + 1024, 255.0F);
  EXPECT_GT(white, 0);
  EXPECT_LT(white, 1024 * 1024 / 1000);
}

}  // namespace
}  // namespace apps_test
