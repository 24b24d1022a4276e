// SPDX-License-Identifier: Apache-2.0
#include "calib/find/find_edges.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "calib/iso12233/iso12233.h"
#include "edge_truth.h"
#include "made_scenes.h"
#include "mtf/error.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using test::made_scene;
using test::Side;
using test::Square;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

bool inside(const mtf::Image& image, const Roi& roi) {
  return roi.width > 0 && roi.height > 0 && roi.x >= 0 && roi.y >= 0 && roi.x + roi.width <= image.width() &&
         roi.y + roi.height <= image.height();
}

/// Every region holds one side, of at least `least` pixels; returns the sides that were found.
std::set<std::size_t> expect_single_sides(const mtf::Image& image, const FoundEdges& found,
                                          const std::vector<Side>& sides, double least = 15.0) {
  std::set<std::size_t> seen;
  for (const FoundEdge& edge : found.edges) {
    EXPECT_TRUE(inside(image, edge.roi));
    int held = 0;
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const double length = test::length_inside(sides[i], edge.roi);
      if (length <= 0.5) continue;
      ++held;
      EXPECT_GE(length, least) << "side " << i;
      seen.insert(i);
    }
    EXPECT_EQ(held, 1) << "region " << edge.roi.x << "," << edge.roi.y << "," << edge.roi.width << ","
                       << edge.roi.height;
  }
  for (std::size_t i = 1; i < found.edges.size(); ++i) EXPECT_GE(found.edges[i - 1].score, found.edges[i].score);
  return seen;
}

std::vector<Square> chart(double step) {
  std::vector<Square> squares;
  const double angles[] = {0.0, 3.0, 12.0, 26.565, 45.0, 60.0, 78.0, 87.0};
  for (int k = 0; k < 8; ++k)
    squares.push_back({{90.0 + 170.3 * (k % 4), 90.0 + 170.7 * (k / 4)}, 42.0, angles[k], step});
  return squares;
}

TEST(FindEdges, SidesOfTiltedSquaresInNoise) {
  for (const double step : {-0.6, 0.6})
    for (const double noise : {0.0, 0.01, 0.05}) {
      SCOPED_TRACE(noise);
      const mtf::Image image = made_scene(690, 350, chart(step), noise, step < 0.0 ? 0.8 : 0.2);
      const FoundEdges found = find_edges(image.view());
      EXPECT_EQ(expect_single_sides(image, found, test::sides_of(chart(step))).size(), 32U) << found.reason;
      EXPECT_EQ(found.edges.size(), 32U);
    }
}

TEST(FindEdges, CheckerboardOfAnyTurn) {
  for (const double angle : {4.0, 20.0, 45.0}) {
    std::vector<Square> squares;
    const double c = std::cos(angle * std::numbers::pi / 180.0), s = std::sin(angle * std::numbers::pi / 180.0);
    for (int j = -8; j <= 8; ++j)
      for (int i = -8; i <= 8; ++i)
        if ((i + j) % 2 == 0)
          squares.push_back({{250.0 + 70.0 * (i * c - j * s), 250.0 + 70.0 * (i * s + j * c)}, 35.0, angle, -0.6});
    const mtf::Image image = made_scene(500, 500, squares, 0.01);
    const FoundEdges found = find_edges(image.view());
    EXPECT_GE(expect_single_sides(image, found, test::sides_of(squares)).size(), 50U) << angle << found.reason;
  }
}

mtf::Image single_edge(std::int64_t width, std::int64_t height, double angle_deg, double noise_sd,
                       double blur_px = 0.7) {
  const double angle = angle_deg * std::numbers::pi / 180.0;
  const Point centre{0.5 * static_cast<double>(width) - 1e4 * std::cos(angle),
                     0.5 * static_cast<double>(height) - 1e4 * std::sin(angle)};
  return made_scene(width, height, {{centre, 1e4, angle_deg, 0.6}}, noise_sd, 0.2, blur_px);
}

TEST(FindEdges, AnImageCrossedByOneEdgeIsTakenWhole) {
  struct Case {
    std::int64_t width, height;
    double noise, blur;
  };
  for (const Case& c : {Case{128, 100, 0.0, 0.7},
                        {128, 100, 0.01, 0.3},
                        {128, 100, 0.05, 0.7},
                        {128, 100, 0.1, 0.7},
                        {128, 100, 0.01, 5.0},
                        {128, 32, 0.01, 0.7},
                        {24, 24, 0.0, 0.7},
                        {200, 200, 0.01, 8.0}})
    for (double angle = 0.0; angle < 360.0; angle += 9.5) {
      const mtf::Image image = single_edge(c.width, c.height, angle, c.noise, c.blur);
      const FoundEdges found = find_edges(image.view());
      SCOPED_TRACE(testing::Message() << angle << " degrees, noise " << c.noise << ", blur " << c.blur);
      ASSERT_EQ(found.edges.size(), 1U) << found.reason;
      EXPECT_EQ(found.edges[0].roi, (Roi{0, 0, c.width, c.height}));
    }
}

TEST(FindEdges, MaskedOrCurvedItIsStillOneEdge) {
  std::mt19937 random(5);
  for (double angle = 0.0; angle < 360.0; angle += 9.5) {
    for (const int keep : {0, 1, 2}) {
      mtf::Image image = single_edge(128, 100, angle, 0.02);
      for (std::int64_t y = 0; y < 100; ++y)
        for (std::int64_t x = 0; x < 128; ++x) {
          const bool masks[] = {x % 2 == 1 && y % 2 == 0, (x + y) % 2 == 0, random() % 2 == 0};
          if (!masks[keep]) image.at(x, y) = kNone;
        }
      const FoundEdges found = find_edges(image.view());
      ASSERT_EQ(found.edges.size(), 1U) << angle << " " << keep << found.reason;
      EXPECT_EQ(found.edges[0].roi, (Roi{0, 0, 128, 100})) << angle << " " << keep;
    }
    mtf::Image curved(128, 100);
    const double radius = 300.0, turn = angle * std::numbers::pi / 180.0;
    for (std::int64_t y = 0; y < 100; ++y)
      for (std::int64_t x = 0; x < 128; ++x) {
        const double d = std::hypot(static_cast<double>(x) - 64.0 - radius * std::cos(turn),
                                    static_cast<double>(y) - 50.0 - radius * std::sin(turn)) -
                         radius;
        curved.at(x, y) = static_cast<float>(0.2 + 0.3 * std::erfc(-d));
      }
    const FoundEdges found = find_edges(curved.view());
    ASSERT_EQ(found.edges.size(), 1U) << angle << found.reason;
    EXPECT_EQ(found.edges[0].roi, (Roi{0, 0, 128, 100})) << angle;
  }
}

TEST(FindEdges, TheSharedEdgesAreTakenWhole) {
  if (test::shared_data().empty()) GTEST_SKIP() << "no shared data";
  const nlohmann::json cases = test::shared_json("edges/truth.json").at("cases");
  EXPECT_EQ(cases.size(), 19U);
  for (const auto& edge : cases) {
    const std::string file = edge.at("file");
    const mtf::Image image = test::linear_image(test::shared_data() / "edges" / file);
    const FoundEdges found = find_edges(image.view());
    ASSERT_EQ(found.edges.size(), 1U) << file << found.reason;
    EXPECT_EQ(found.edges[0].roi, (Roi{0, 0, image.width(), image.height()})) << file;
  }
}

TEST(FindEdges, MaskedPixelsAreNoData) {
  const std::vector<Square> squares = chart(-0.6);
  const std::vector<Side> sides = test::sides_of(squares);
  const auto masked = [&](auto keep) {
    mtf::Image image = made_scene(690, 350, squares, 0.01);
    for (std::int64_t y = 0; y < image.height(); ++y)
      for (std::int64_t x = 0; x < image.width(); ++x)
        if (!keep(x, y)) image.at(x, y) = kNone;
    return image;
  };
  const mtf::Image red = masked([](std::int64_t x, std::int64_t y) { return x % 2 == 0 && y % 2 == 0; });
  EXPECT_GE(expect_single_sides(red, find_edges(red.view()), sides).size(), 28U);
  const mtf::Image green = masked([](std::int64_t x, std::int64_t y) { return (x + y) % 2 == 0; });
  EXPECT_GE(expect_single_sides(green, find_edges(green.view()), sides).size(), 28U);
  std::mt19937 random(3);
  const mtf::Image dead = masked([&](std::int64_t, std::int64_t) { return random() % 5 != 0; });
  EXPECT_GE(expect_single_sides(dead, find_edges(dead.view()), sides).size(), 28U);
  // With the right half masked the squares left of it are found, and the mask's border is no edge.
  const mtf::Image half = masked([](std::int64_t x, std::int64_t) { return x < 345; });
  const FoundEdges found = find_edges(half.view());
  EXPECT_EQ(expect_single_sides(half, found, sides).size(), 16U);
}

TEST(FindEdges, CurvedEdgesAndDisks) {
  mtf::Image image(500, 500);
  for (std::int64_t y = 0; y < 500; ++y)
    for (std::int64_t x = 0; x < 500; ++x) {
      const double d = std::hypot(static_cast<double>(x) - 249.5, static_cast<double>(y) - 249.5) - 160.0;
      image.at(x, y) = static_cast<float>(0.2 + 0.3 * std::erfc(-d / 1.2));
    }
  const FoundEdges found = find_edges(image.view());
  EXPECT_GE(found.edges.size(), 6U) << found.reason;
  for (const FoundEdge& edge : found.edges) {
    EXPECT_TRUE(inside(image, edge.roi));
    EXPECT_LT(edge.roi.width * edge.roi.height, 250 * 250);
  }
}

TEST(FindEdges, HalfWidthIsKeptWhereItFits) {
  const mtf::Image image = made_scene(690, 350, chart(-0.6), 0.01);
  FindOptions options;
  options.half_width_px = 16.0;
  const FoundEdges found = find_edges(image.view(), options);
  EXPECT_EQ(expect_single_sides(image, found, test::sides_of(chart(-0.6))).size(), 32U);
  // Sides along an axis are wanted width x 2 wide, and a little for the drift of the edge.
  for (const FoundEdge& edge : found.edges) EXPECT_GE(std::min(edge.roi.width, edge.roi.height), 24);
  options.most = 5;
  EXPECT_EQ(find_edges(image.view(), options).edges.size(), 5U);
  EXPECT_EQ(find_edges(image.view(), options).left_out, 27U);
}

TEST(FindEdges, FaintEdgesNeedTheContrastAskedFor) {
  const double noise = 0.05;
  const mtf::Image image = made_scene(300, 300, {{{150.0, 150.0}, 80.0, 6.0, -10.0 * noise}}, noise);
  EXPECT_EQ(find_edges(image.view()).edges.size(), 4U);
  FindOptions options;
  options.min_cnr = 20.0;
  const FoundEdges none = find_edges(image.view(), options);
  EXPECT_TRUE(none.edges.empty());
  expect_says(none.reason, {"contrast/noise"});
}

TEST(FindEdges, NothingToFindIsSaid) {
  const auto reason = [](const mtf::Image& image) {
    const FoundEdges found = find_edges(image.view());
    EXPECT_TRUE(found.edges.empty());
    EXPECT_FALSE(found.reason.empty());
    return found.reason;
  };
  expect_says(reason(made_scene(300, 200, {}, 0.05)), {"above the noise"});
  expect_says(reason(made_scene(300, 200, {})), {"same value"});
  expect_says(reason(made_scene(1, 1, {})), {"same value"});
  for (const auto& [width, height] : {std::pair{1, 7}, {2, 2}, {3, 3}, {1000, 1}, {5, 4}}) {
    const mtf::Image small = made_scene(width, height, {}, 0.1);
    EXPECT_TRUE(find_edges(small.view()).edges.empty()) << width << " x " << height;
  }
  mtf::Image masked(40, 30);
  std::fill_n(masked.data(), masked.size(), kNone);
  expect_says(reason(masked), {"masked"});
  // As float64 values of 1e302 arrive.
  mtf::Image beyond(40, 30);
  std::fill_n(beyond.data(), beyond.size(), INFINITY);
  expect_says(reason(beyond), {"1200", "3.4e38"});
  expect_says(measure_edge(beyond.view(), {0, 0, 40, 30}).reason, {"beyond 3.4e38"});
  masked.at(3, 3) = 1.0F;
  reason(masked);
  std::fill_n(masked.data(), masked.size(), std::numeric_limits<float>::infinity());
  reason(masked);
  expect_says(find_edges({}).reason, {"empty"});
  // Stripes too close to each other for a plateau between them.
  mtf::Image stripes(200, 200);
  for (std::int64_t i = 0; i < stripes.size(); ++i) stripes.data()[i] = static_cast<float>((i % 200) / 6 % 2);
  expect_says(reason(stripes), {"plateau on both sides"});
}

TEST(FindEdges, ExtremeNumbersAreNoDanger) {
  mtf::Image image = single_edge(128, 100, 5.0, 0.01);
  for (const float scale : {1e-30F, 1e30F, 3e38F}) {
    mtf::Image scaled = image.clone();
    for (std::int64_t i = 0; i < scaled.size(); ++i) scaled.data()[i] *= scale;
    const FoundEdges found = find_edges(scaled.view());
    for (const FoundEdge& edge : found.edges) EXPECT_TRUE(inside(scaled, edge.roi));
  }
  image.at(60, 50) = 1e38F;
  image.at(61, 50) = -1e38F;
  const FoundEdges found = find_edges(image.view());
  for (const FoundEdge& edge : found.edges) EXPECT_TRUE(inside(image, edge.roi));
}

TEST(FindEdges, RefusesMisuse) {
  const mtf::Image image = single_edge(60, 50, 5.0, 0.0);
  const auto refused = [&](auto change) {
    FindOptions options;
    change(options);
    EXPECT_THROW(static_cast<void>(find_edges(image.view(), options)), mtf::UsageError);
  };
  refused([](FindOptions& o) { o.most = 0; });
  refused([](FindOptions& o) { o.most_pieces = 0; });
  refused([](FindOptions& o) { o.min_length_px = 0.0; });
  refused([](FindOptions& o) { o.min_cnr = -1.0; });
  refused([](FindOptions& o) { o.min_cnr = std::numeric_limits<double>::quiet_NaN(); });
  refused([](FindOptions& o) { o.half_width_px = -1.0; });
  refused([](FindOptions& o) { o.half_width_px = std::numeric_limits<double>::infinity(); });
}

/// There are more pixels than cells at most: the same squares, eight times as large.
TEST(FindEdges, LargeImages) {
  std::vector<Square> squares = chart(-0.6);
  for (Square& square : squares)
    square = {{8.0 * square.centre.x, 8.0 * square.centre.y}, 330.0, square.angle_deg, -0.6};
  const mtf::Image image = made_scene(5500, 3200, squares, 0.01);
  const FoundEdges found = find_edges(image.view());
  EXPECT_EQ(expect_single_sides(image, found, test::sides_of(squares), 200.0).size(), 32U);
}

/// More edges than were ever kept at a time: 4624.
mtf::Image crowded_chart() {
  mtf::Image image = made_scene(2312, 2312, {}, 0.01);
  for (int j = 0; j < 34; ++j)
    for (int i = 0; i < 34; ++i)
      test::add_rectangle(image, {34.3 + 68.0 * i, 34.7 + 68.0 * j}, 21.0, 21.0, 3.0 + (7 * i + 3 * j) % 30, -0.6);
  return image;
}

TEST(FindEdges, WhatIsNotReturnedIsCounted) {
  const mtf::Image image = crowded_chart();
  FindOptions options;
  options.most = 10'000;
  const FoundEdges all = find_edges(image.view(), options);
  EXPECT_EQ(all.edges.size(), 4624U);
  EXPECT_EQ(all.left_out, 0U);
  EXPECT_EQ(all.not_tried, 0U);
  options.most = 100;
  const FoundEdges few = find_edges(image.view(), options);
  ASSERT_EQ(few.edges.size(), 100U);
  EXPECT_EQ(few.left_out, 4524U);
  for (std::size_t i = 0; i < few.edges.size(); ++i) EXPECT_EQ(few.edges[i].roi, all.edges[i].roi) << i;
}

TEST(FindEdges, WhereMemoryEndsTheBestAreKept) {
  // One square of three times the contrast among many: its sides have the best score and must be kept.
  mtf::Image image = made_scene(700, 700, {}, 0.01, 0.2);
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i)
      test::add_rectangle(image, {80.3 + 77.0 * i, 80.7 + 77.0 * j}, 22.0, 22.0, 7.0, i == 5 && j == 3 ? 0.6 : 0.2);
  FindOptions options;
  options.most = 1000;
  EXPECT_EQ(find_edges(image.view(), options).edges.size(), 256U);
  options.most_pieces = 4;
  const FoundEdges found = find_edges(image.view(), options);
  EXPECT_EQ(found.not_tried, 252U);
  EXPECT_EQ(expect_single_sides(image, found, test::sides_of({{{465.3, 311.7}, 22.0, 7.0, 0.6}})).size(), 4U);
}

/// Bars of seven times their contrast, each with two sides long enough to be edges and no plateau between them,
/// surround four squares.
TEST(FindEdges, StrongClutterHidesNoEdge) {
  mtf::Image image = made_scene(2000, 2000, {}, 0.002, 0.2);
  std::vector<Square> squares;
  for (int k = 0; k < 4; ++k)
    squares.push_back({{500.0 + 1000.0 * (k % 2), 500.0 + 1000.0 * (k / 2)}, 60.0, 5.0 + 20.0 * k, 0.1});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform;
  int bars = 0;
  for (double y = 20.0; y < 1980.0; y += 36.0)
    for (double x = 20.0; x < 1980.0; x += 36.0) {
      const bool near = std::any_of(squares.begin(), squares.end(), [&](const Square& square) {
        return std::hypot(x - square.centre.x, y - square.centre.y) < 150.0;
      });
      const double turn = 180.0 * uniform(random);
      if (near) continue;
      test::add_rectangle(image, {x, y}, 13.0, 1.5, turn, 0.7);
      ++bars;
    }
  EXPECT_GT(2 * bars, 4096);
  for (const Square& square : squares)
    test::add_rectangle(image, square.centre, square.half_px, square.half_px, square.angle_deg, square.step);
  const FoundEdges found = find_edges(image.view());
  EXPECT_EQ(expect_single_sides(image, found, test::sides_of(squares), 60.0).size(), 16U) << found.reason;
}

/// Real scenes: outlines of a tower, a hot bowl and a car are smooth edges with room beside them; the rest is crowded,
/// which the reason says. Another method confirms that each region found holds one smooth edge.
TEST(FindEdges, ThermalImages) {
  if (test::shared_data().empty()) GTEST_SKIP() << "no shared data";
  const std::map<std::string, std::size_t> wanted{{"tower.png", 1}, {"water_pipe.png", 3}, {"moving_mercedes.png", 1}};
  const nlohmann::json manifest = test::shared_json("thermal/manifest.json");
  EXPECT_EQ(manifest.size(), 8U);
  for (const auto& entry : manifest) {
    const std::string file = entry.at("file");
    SCOPED_TRACE(file);
    const mtf::Image image = test::linear_image(test::shared_data() / "thermal" / file);
    const FoundEdges found = find_edges(image.view());
    EXPECT_EQ(found.edges.empty(), !found.reason.empty());
    const auto least = wanted.find(file);
    EXPECT_GE(found.edges.size(), least == wanted.end() ? 0U : least->second);
    for (const FoundEdge& edge : found.edges) {
      ASSERT_TRUE(inside(image, edge.roi));
      const Iso12233Result result = measure_iso12233(image.view(), edge.roi);
      EXPECT_EQ(result.trouble, Trouble::none) << result.reason;
      EXPECT_LT(result.edge_rms_px, 1.0);
    }
  }
}

}  // namespace
}  // namespace calib
