// SPDX-License-Identifier: Apache-2.0

// Pictures for the eye: grey values, the bar and what it says of clipped values.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "apps/figures/picture.h"
#include "mtf/io/image_io.h"
#include "tests/apps/chain_sensor.h"

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

/// A converter whose counts of a scene of 2 K are a few of the 65536 grey values of a PNG.
class CountsPicture : public ChainSensor {
 protected:
  void SetUp() override {
    ChainSensor::SetUp();
    sensor("[adc]\nbits = 14\n");
    Image ramp(64, 48);
    for (std::int64_t y = 0; y < 48; ++y)
      for (std::int64_t x = 0; x < 64; ++x) ramp.at(x, y) = 299.0F + static_cast<float>(x) / 32.0F;
    mtf::io::Metadata metadata;
    metadata.text["mtf:quantity"] = "temperature";
    mtf::io::write_exr((scratch / "ramp.exr").string(), {{"Y", ramp.view()}}, metadata);
  }
};

TEST_F(CountsPicture, ShowsWhatTheFileOfCountsHides) {
  const Result run = scratch.run("mtf simulate s.toml ramp.exr -o counts.png --picture view.png");
  ASSERT_EQ(run.status, 0) << run.err;
  const Image counts = read(scratch / "counts.png");
  const auto [least, most] = std::minmax_element(counts.data(), counts.data() + counts.size());
  const double share = 100.0 * static_cast<double>(*most - *least) / 65535.0;
  ASSERT_LT(share, 3.0);
  const std::size_t said = run.err.find(" uses ");
  ASSERT_NE(said, std::string::npos) << run.err;
  EXPECT_NEAR(std::stod(run.err.substr(said + 6)), share, 0.051 * share);
  expect_says(run.err, {"note: counts.png", "view.png"});
  // Scene and image, enlarged to 512 x 384 each: both run through the colours from one side to the other.
  const auto planes = mtf::io::read_image((scratch / "view.png").string()).planes;
  ASSERT_EQ(planes.size(), 3U);
  const auto light = [&](std::int64_t x) { return planes[0].at(x, 240) + planes[1].at(x, 240) + planes[2].at(x, 240); };
  EXPECT_GT(light(16 + 500) - light(16 + 12), 300.0F);
  EXPECT_GT(light(544 + 500) - light(544 + 12), 300.0F);
}

TEST_F(CountsPicture, IsNotAskedForWhereTheScaleIsUsed) {
  for (const char* other : {"-o counts.exr", "-o counts.png --range 8000:9000", "-o light.png --stage irradiance"}) {
    const Result run = scratch.run(std::string("mtf simulate s.toml ramp.exr ") + other);
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_FALSE(says(run.err, "grey scale")) << other << run.err;
  }
  expect_says(scratch.run("mtf simulate s.toml ramp.exr -o counts.png").err, {"--picture FILE.png"});
}

TEST_F(CountsPicture, IsOfOneWholeImage) {
  expect_refused("mtf simulate s.toml ramp.exr -o out.exr --picture view.jpg", {"--picture", "ending .png"});
  expect_refused("mtf simulate s.toml ramp.exr -o out.exr --picture view.png --memory 1GiB", {"--picture", "--memory"});
  expect_refused("mtf simulate s.toml frame.%04d.exr -o out.%04d.exr --picture view.png", {"--picture", "sequence"});
  expect_refused("cp ramp.exr ramp.png && mtf simulate s.toml ramp.png -o out.exr --picture ramp.png", {"ramp.png"});
  EXPECT_FALSE(fs::exists(scratch / "view.png"));
}

// Either size stands in a note of its own words: which of the two is meant is for the reader to say.
TEST_F(CountsPicture, TwoSizesOfOneDetectorAreBothSaid) {
  sensor("", "width = \"14.25 um\"", "width = \"14 um\"");
  expect_says(scratch.run("mtf config check s.toml").out,
              {"note: detector.width: detector area 14 x 15 um, footprint 15 x 15 um"});
  sensor("", "schema = 1", "schema = 2");
  expect_says(scratch.run("mtf config check s.toml").out,
              {"note: detector.width: detector area 14.2 x 14.2 um, footprint 15 x 15 um"});
  sensor("", "width = \"14.25 um\"", "width = \"15 um\"");
  EXPECT_FALSE(says(scratch.run("mtf config check s.toml").out, "detector area"));
}

TEST_F(CountsPicture, OneSideOfADetectorIsAWarningInAnOldFile) {
  const auto warns = [&] { return says(scratch.run("mtf config check s.toml").out, "warning: detector.width:"); };
  sensor("", "width = \"14.25 um\"", "width = \"14 um\"");
  EXPECT_TRUE(warns());
  sensor("", "width = \"14.25 um\"", "width = \"15 um\"");  // a square of the pitch either way
  EXPECT_FALSE(warns());
  sensor("", "schema = 1", "schema = 2");
  EXPECT_FALSE(warns());
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
