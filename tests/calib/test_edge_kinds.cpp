// SPDX-License-Identifier: Apache-2.0
// The 95 % intervals hold on edges that measure_edge does not assume; tests/bench/bench_kinds.cpp prints more of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/calib/edge_kinds.h"

namespace {

enum Figure : std::size_t { kMtf005, kMtf01, kMtf025, kNyquist, kMtf50, kFwhm, kOvershoot };

struct Expected {
  const char* kind;
  std::vector<Figure> figures;  ///< those whose intervals did not hold before
  const char* word = "";        ///< that a warning of most draws holds
};

// Of the draws 95 % hold, less three standard deviations of that number; none is off by ten stated deviations.
void expect_coverage(int draws, const std::vector<Expected>& all) {
  const double least = 0.95 * draws - 3.0 * std::sqrt(0.95 * 0.05 * draws);
  for (const Expected& one : all) {
    SCOPED_TRACE(one.kind);
    const auto kinds = made::edge_kinds(one.kind);
    const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const auto& each) { return each.name == one.kind; });
    ASSERT_NE(kind, kinds.end());
    const made::Coverage found = made::coverage_of(*kind, draws, 3);
    EXPECT_EQ(found.refused, 0);
    for (const Figure k : one.figures) {
      EXPECT_EQ(found.stated[k], draws) << made::kFigureNames[k];
      EXPECT_GE(found.held[k], least) << made::kFigureNames[k];
      for (std::size_t i = 0; i < found.error[k].size(); ++i)
        EXPECT_LT(std::abs(found.error[k][i]), 10.0 * found.sd[k][i]) << made::kFigureNames[k] << ' ' << i;
    }
    const auto named = std::count_if(found.words.begin(), found.words.end(),
                                     [&](const std::string& word) { return word.find(one.word) != std::string::npos; });
    EXPECT_GE(named, 0.8 * draws);
  }
}

}  // namespace

// FWHM came out 3 to 8 times too small in one of fifteen.
TEST(EdgeKinds, BentEdgesInCorrelatedNoise) {
  expect_coverage(100, {{"bent shared noise 128x100 CNR 20", {kMtf025, kMtf50, kFwhm, kOvershoot}, "correlated"}});
}

// Was taken for a gradient of the light: no interval held.
TEST(EdgeKinds, LightScatteredFar) {
  expect_coverage(60, {{"halo 3 % 12 px Gauss 128x100 CNR 60", {kMtf005, kMtf01, kMtf025, kMtf50}, "slowly"}});
  expect_coverage(60, {{"short halo 3 % 20 px Airy 128x100 CNR 60", {kMtf005, kMtf01, kMtf025, kMtf50}, "slowly"}});
}

// As far as the sides extend, where the noise hides it: the warning says what the intervals do not hold, and how long
// the sides would have to be.
TEST(EdgeKinds, LightScatteredAsFarAsTheSides) {
  expect_coverage(100, {{"halo 3 % 20 px Airy 40x60 CNR 20", {}, "do not cover"},
                        {"halo 1 % 12 px Gauss 40x60 CNR 60", {kMtf005, kMtf01, kMtf50}, "px on each side"}});
}

TEST(EdgeKinds, StripesAlongTheEdge) {
  expect_coverage(60, {{"columns 0.25 Airy 128x100 CNR 60", {kMtf005, kMtf01, kMtf025, kMtf50}, "columns or rows"}});
}

TEST(EdgeKinds, LightThatFallsOffWithTheSquare) {
  expect_coverage(60, {{"vignetting 3 % Gauss 128x100 CNR 60", {kMtf005, kMtf01, kMtf50}, "the sides"}});
}

TEST(EdgeKinds, BlursThatTheReferenceLacks) {
  expect_coverage(60, {{"turbulent 0.40 128x100 CNR 60", {kMtf005, kMtf025, kNyquist, kMtf50}},
                       {"low-pass Airy 0.50 128x100 CNR 60", {kMtf005, kMtf025, kNyquist, kMtf50}},
                       {"sharpened Gauss 0.5 2.00 128x100 CNR 60", {kMtf005, kMtf01, kNyquist}}});
}

TEST(EdgeKindsLong, AThousandBentEdgesInCorrelatedNoise) {
  expect_coverage(1000, {{"bent shared noise 128x100 CNR 20", {kMtf025, kMtf50, kFwhm, kOvershoot}, "correlated"}});
}

TEST(EdgeKindsLong, AThousandOfOtherKinds) {
  expect_coverage(1000, {{"bent 40x60 CNR 20", {kMtf025, kMtf50, kFwhm, kOvershoot}},
                         {"straight 40x60 CNR 20", {kMtf025, kMtf50, kFwhm, kOvershoot}},
                         {"halo 3 % 20 px Airy 128x100 CNR 60", {kMtf005, kMtf01, kMtf025, kMtf50}, "slowly"},
                         {"columns 0.50 Gauss 40x60 CNR 60", {kMtf005, kMtf01, kMtf025, kMtf50}, "columns or rows"}});
}
