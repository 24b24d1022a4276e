// SPDX-License-Identifier: Apache-2.0
// What precedes a measurement: Bayer planes, masks, regions from text.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calib/find/no_data.h"
#include "calib/find/roi_file.h"
#include "mtf/error.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

/// The message of the refusal; "" when nothing was refused.
template <class Function>
std::string refusal(const Function& function) {
  return message_of<mtf::UsageError>(function);
}

mtf::Image counted(std::int64_t width, std::int64_t height) {
  mtf::Image image(width, height);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<float>(i);
  return image;
}

TEST(BayerPlane, EveryPixelBelongsToOnePlane) {
  const mtf::Image image = counted(7, 5);
  for (const std::string_view pattern : kBayerPatterns) {
    std::vector<int> owners(static_cast<std::size_t>(image.size()), 0);
    for (const std::string_view plane : {"r", "gr", "gb", "b"}) {
      const mtf::Image one = bayer_plane(image.view(), pattern, plane);
      ASSERT_EQ(one.width(), 7);
      ASSERT_EQ(one.height(), 5);
      for (std::int64_t i = 0; i < image.size(); ++i) {
        if (std::isnan(one.data()[i])) continue;
        EXPECT_EQ(one.data()[i], image.data()[i]);
        ++owners[static_cast<std::size_t>(i)];
      }
    }
    for (const int n : owners) EXPECT_EQ(n, 1) << pattern;
  }
}

TEST(BayerPlane, PatternsNameTheirFirstRows) {
  const mtf::Image image = counted(4, 4);
  const auto first = [&](std::string_view pattern, std::string_view plane) {
    const mtf::Image one = bayer_plane(image.view(), pattern, plane);
    for (int i = 0; i < 16; ++i)
      if (!std::isnan(one.data()[i])) return i;
    return -1;
  };
  struct Case {
    const char* pattern;
    int r, gr, gb, b;  // pixels 0 1 / 4 5
  };
  for (const Case& c : {Case{"rggb", 0, 1, 4, 5}, {"grbg", 1, 0, 5, 4}, {"gbrg", 4, 5, 0, 1}, {"BGGR", 5, 4, 1, 0}}) {
    EXPECT_EQ(first(c.pattern, "r"), c.r) << c.pattern;
    EXPECT_EQ(first(c.pattern, "gr"), c.gr) << c.pattern;
    EXPECT_EQ(first(c.pattern, "Gb"), c.gb) << c.pattern;
    EXPECT_EQ(first(c.pattern, "b"), c.b) << c.pattern;
    EXPECT_EQ(first(c.pattern, "g"), std::min(c.gr, c.gb)) << c.pattern;
  }
  int greens = 0;
  const mtf::Image green = bayer_plane(image.view(), "rggb", "g");
  for (int i = 0; i < 16; ++i) greens += std::isnan(green.data()[i]) ? 0 : 1;
  EXPECT_EQ(greens, 8);
}

TEST(BayerPlane, RefusesUnknownNames) {
  const mtf::Image image = counted(2, 2);
  expect_says(refusal([&] { static_cast<void>(bayer_plane(image.view(), "rgbg", "r")); }), {"grbg"});
  expect_says(refusal([&] { static_cast<void>(bayer_plane(image.view(), "rggb", "all")); }), {"gr, gb"});
  EXPECT_NE(refusal([&] { static_cast<void>(bayer_plane(image.view(), "", "")); }), "");
  EXPECT_EQ(bayer_plane({}, "rggb", "r").size(), 0);
}

TEST(Mask, ZeroAndNaNAreNoData) {
  mtf::Image image = counted(3, 2), mask(3, 2);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float values[] = {0.0F, 1.0F, 255.0F, -0.0F, nan, 0.5F};
  std::copy(std::begin(values), std::end(values), mask.data());
  image.at(2, 1) = nan;
  EXPECT_EQ(apply_mask(image.view(), mask.view()), 2);
  for (const int gone : {0, 3, 4, 5}) EXPECT_TRUE(std::isnan(image.data()[gone])) << gone;
  EXPECT_EQ(image.data()[1], 1.0F);
  EXPECT_EQ(image.data()[2], 2.0F);
  const mtf::Image other = counted(2, 3);
  expect_says(refusal([&] { static_cast<void>(apply_mask(image.view(), other.view())); }), {"2 x 3"});
}

TEST(RoiFile, ReadsRegionsNamesAndComments) {
  const auto regions = parse_roi_file(
      "\xEF\xBB\xBF# lens 12\r\nx,y,width,height,name\r\n120,80,64,96,upper left\r\n\r\n  480 ;90; "
      "64;96\r\n1\t2\t3\t4\t\"a, b\"",
      "r.csv");
  ASSERT_EQ(regions.size(), 3U);
  EXPECT_EQ(regions[0].roi, (Roi{120, 80, 64, 96}));
  EXPECT_EQ(regions[0].name, "upper left");
  EXPECT_EQ(regions[0].line, 3);
  EXPECT_EQ(regions[1].roi, (Roi{480, 90, 64, 96}));
  EXPECT_EQ(regions[1].name, "");
  EXPECT_EQ(regions[2].name, "a, b");
  EXPECT_EQ(regions[2].line, 6);
  EXPECT_EQ(parse_roi_file("5,6,7,8", "r").front().roi, (Roi{5, 6, 7, 8}));
}

TEST(RoiFile, SaysEveryLineThatIsWrong) {
  const std::string said = refusal([] {
    static_cast<void>(
        parse_roi_file("1,2,3,4\n1,2,3\n1,2,0,4\n-1,2,3,4\n1.5,2,3,4\n1,2,3,4,n,m\n9223372036854775807,1,1,1\n"
                       "99999999999999999999,1,1,1",
                       "r.csv"));
  });
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 6);
  expect_says(said, {"r.csv:2: 3 values", "r.csv:3: width", "r.csv:4: x and y", "r.csv:5: \"1.5\"", "r.csv:6: 6 values",
                     "r.csv:7: 9223372036854775807", "r.csv:8: \"99999999999999999999\""});
  EXPECT_FALSE(says(said, "r.csv:1:")) << said;
  // A header is only where no number is.
  expect_says(refusal([] { static_cast<void>(parse_roi_file("x,2,3,4", "r.csv")); }), {"r.csv:1: \"x\""});
  for (const char* empty : {"", "# nothing\n\n", "x,y,width,height\n"})
    expect_says(refusal([&] { static_cast<void>(parse_roi_file(empty, "r.csv")); }), {"no region"});
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "a\x1b[31m,b\x07\n";
  const std::string twenty = refusal([&] { static_cast<void>(parse_roi_file(many, "r")); });
  EXPECT_EQ(std::count(twenty.begin(), twenty.end(), '\n'), 19);
  EXPECT_FALSE(says(twenty, "\x1b")) << twenty;
}

TEST(RoiFile, OneRegionOfTheCommandLine) {
  EXPECT_EQ(parse_roi("10,20,30,40"), (Roi{10, 20, 30, 40}));
  for (const char* wrong :
       {"", "1", "1,2,3", "1,2,3,4,5", "a,b,c,d", "1,2,0,3", "1,2,-3,3", "-1,2,3,3", "1e3,2,3,4", "0x1,2,3,4"})
    EXPECT_NE(refusal([&] { static_cast<void>(parse_roi(wrong)); }), "") << wrong;
}

}  // namespace
}  // namespace calib
