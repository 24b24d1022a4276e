// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "apps/study/statistics/sampling.h"
#include "apps/study/study.h"
#include "tests/apps/study/study_files.h"

namespace study {
namespace {

TEST(Sampling, PermutationsHitEachPlaceOnce) {
  for (const std::uint64_t n : {1u, 2u, 3u, 5u, 8u, 100u, 1000u, 4097u})
    for (const std::uint32_t axis : {0u, 1u, 7u}) {
      std::vector<int> hit(n);
      for (std::uint64_t i = 0; i < n; ++i) {
        const std::uint64_t place = permuted(i, n, axis, 42);
        ASSERT_LT(place, n);
        ++hit[place];
      }
      EXPECT_EQ(std::count(hit.begin(), hit.end(), 1), static_cast<std::ptrdiff_t>(n)) << n << " axis " << axis;
    }
}

TEST(Sampling, PermutationsOfTwoAxesAreNotRelated) {
  // Correlation of the ranks of two axes of n points: 0 with a standard deviation of 1 / sqrt(n - 1).
  constexpr std::uint64_t n = 4096;
  for (const std::uint64_t seed : {0u, 1u, 2u, 3u}) {
    double sum = 0.0, neighbours = 0.0;
    for (std::uint64_t i = 0; i < n; ++i) {
      const auto centred = [&](std::uint64_t k, std::uint32_t axis) {
        return static_cast<double>(permuted(k, n, axis, seed)) - (n - 1) / 2.0;
      };
      sum += centred(i, 0) * centred(i, 1);
      neighbours += centred(i, 0) * centred((i + 1) % n, 0);
    }
    const double variance = (static_cast<double>(n) * n - 1.0) / 12.0;
    EXPECT_LT(std::abs(sum / (n * variance)), 4.0 / std::sqrt(n - 1.0)) << seed;
    EXPECT_LT(std::abs(neighbours / (n * variance)), 4.0 / std::sqrt(n - 1.0)) << seed;
  }
}

TEST(Sampling, LatinHypercubeHasOnePointAStratum) {
  for (const std::uint64_t n : {1u, 7u, 64u, 1000u})
    for (const std::uint32_t axis : {0u, 3u}) {
      std::vector<int> hit(n);
      for (std::uint64_t i = 0; i < n; ++i) {
        const double u = latin_hypercube(i, n, axis, 5);
        ASSERT_GT(u, 0.0);
        ASSERT_LT(u, 1.0);
        ++hit[static_cast<std::size_t>(u * static_cast<double>(n))];
      }
      EXPECT_EQ(std::count(hit.begin(), hit.end(), 1), static_cast<std::ptrdiff_t>(n));
    }
}

TEST(Sampling, LatinHypercubeOfABillionIsRandomAccess) {
  constexpr std::uint64_t n = 1'000'000'000;
  std::set<std::uint64_t> strata;
  for (std::uint64_t i = 0; i < 2000; ++i)
    strata.insert(static_cast<std::uint64_t>(latin_hypercube(n - 1 - i, n, 0, 1) * static_cast<double>(n)));
  EXPECT_EQ(strata.size(), 2000u);
  EXPECT_GT(*strata.rbegin() - *strata.begin(), n / 2);  // spread, not a run
}

TEST(Sampling, SobolHasThePublishedFirstPoints) {
  // Joe and Kuo (2008), their example program sobol.cc with new-joe-kuo-6, dimensions 1 to 3, first 8 points.
  constexpr double expected[8][3] = {{0, 0, 0},
                                     {0.5, 0.5, 0.5},
                                     {0.75, 0.25, 0.25},
                                     {0.25, 0.75, 0.75},
                                     {0.375, 0.375, 0.625},
                                     {0.875, 0.875, 0.125},
                                     {0.625, 0.125, 0.875},
                                     {0.125, 0.625, 0.375}};
  const auto axes = sobol_axes(3);
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(sobol_bits(axes[a], i) * 0x1p-32, expected[i][a]) << i << " " << a;
}

TEST(Sampling, SobolFillsEveryBinaryInterval) {
  // The first 2^m points of each axis, shifted or not, have one in each interval of 2^-m.
  const auto axes = sobol_axes(100);
  constexpr std::size_t n = 1024;
  for (std::uint32_t a = 0; a < axes.size(); ++a) {
    std::vector<int> plain(n), shifted(n);
    for (std::size_t i = 0; i < n; ++i) {
      ++plain[sobol_bits(axes[a], i) >> 22];
      ++shifted[static_cast<std::size_t>(sobol(axes[a], i, a, 9) * n)];
    }
    EXPECT_EQ(std::count(plain.begin(), plain.end(), 1), static_cast<std::ptrdiff_t>(n)) << a;
    EXPECT_EQ(std::count(shifted.begin(), shifted.end(), 1), static_cast<std::ptrdiff_t>(n)) << a;
  }
}

/// L2 star discrepancy by Warnock's formula (1972).
double discrepancy(const std::vector<std::vector<double>>& points) {
  const auto n = static_cast<double>(points.size());
  const std::size_t d = points[0].size();
  double single = 0.0, pairs = 0.0;
  for (const auto& x : points) {
    double product = 1.0;
    for (const double u : x) product *= 1.0 - u * u;
    single += product;
    for (const auto& y : points) {
      double both = 1.0;
      for (std::size_t k = 0; k < d; ++k) both *= 1.0 - std::max(x[k], y[k]);
      pairs += both;
    }
  }
  return std::sqrt(std::pow(3.0, -static_cast<double>(d)) - std::exp2(1.0 - static_cast<double>(d)) / n * single +
                   pairs / (n * n));
}

TEST(Sampling, SobolIsMoreEvenThanRandom) {
  constexpr std::size_t n = 512, d = 5;
  const auto axes = sobol_axes(d);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform;
  for (const std::uint64_t seed : {0u, 1u, 2u}) {
    std::vector<std::vector<double>> even(n, std::vector<double>(d)), rough = even;
    for (std::size_t i = 0; i < n; ++i)
      for (std::uint32_t a = 0; a < d; ++a) {
        even[i][a] = sobol(axes[a], i, a, seed);
        rough[i][a] = uniform(random);
      }
    // Random points: sqrt((2^-d - 3^-d) / n) on the mean square, 0.0073 here; Sobol's are less than half of it.
    EXPECT_NEAR(discrepancy(rough), std::sqrt((std::exp2(-5.0) - std::pow(3.0, -5.0)) / n), 0.003) << seed;
    EXPECT_LT(discrepancy(even), 0.5 * discrepancy(rough)) << seed;
  }
}

Study two_axes(Method method, std::int64_t points) {
  Study study;
  study.method = method;
  study.designs = points;
  study.seed = 11;
  study.parameters.resize(3);
  study.axes.push_back({.parameter = 0, .from = 1.0, .to = 100.0, .scale = Scale::log, .count = 3});
  study.axes.push_back({.parameter = 1, .values = {0.0, 1.0}, .levels = {"a", "b"}});
  study.axes.push_back({.parameter = 2, .values = {5.0, 7.0, 6.0}});
  study.sobol = sobol_axes(3);
  return study;
}

TEST(Sampling, GridsTurnTheLastAxisFastest) {
  const Study study = two_axes(Method::grid, 18);
  std::vector<double> x(3);
  std::vector<std::vector<double>> seen;
  for (std::int64_t i = 0; i < study.designs; ++i) {
    design_at(study, i, x);
    seen.push_back(x);
  }
  EXPECT_EQ(seen[0], (std::vector<double>{1.0, 0.0, 5.0}));
  EXPECT_EQ(seen[1], (std::vector<double>{1.0, 0.0, 7.0}));
  EXPECT_EQ(seen[3], (std::vector<double>{1.0, 1.0, 5.0}));
  EXPECT_NEAR(seen[6][0], 10.0, 1e-14);
  EXPECT_EQ(seen[17], (std::vector<double>{100.0, 1.0, 6.0}));
}

TEST(Sampling, AnyOrderGivesTheSameDesigns) {
  for (const Method method : {Method::grid, Method::latin_hypercube, Method::sobol}) {
    const Study study = two_axes(method, 18);
    std::vector<std::vector<double>> forward(18, std::vector<double>(3)), backward = forward;
    for (std::int64_t i = 0; i < 18; ++i) design_at(study, i, forward[static_cast<std::size_t>(i)]);
    for (std::int64_t i = 17; i >= 0; --i) design_at(study, i, backward[static_cast<std::size_t>(i)]);
    EXPECT_EQ(forward, backward);
    for (const auto& x : forward) {
      EXPECT_GE(x[0], 1.0);
      EXPECT_LE(x[0], 100.0);
      EXPECT_TRUE(x[1] == 0.0 || x[1] == 1.0);
      EXPECT_TRUE(x[2] == 5.0 || x[2] == 6.0 || x[2] == 7.0);
    }
    Study other = study;
    other.seed = 12;
    std::vector<double> x(3);
    design_at(other, 5, x);
    EXPECT_EQ(x[0] == forward[5][0], method == Method::grid);
  }
}

TEST(Sampling, ListsAndLevelsTakeEqualShares) {
  const Study study = two_axes(Method::latin_hypercube, 600);
  int b = 0, seven = 0;
  std::vector<double> x(3);
  for (std::int64_t i = 0; i < 600; ++i) {
    design_at(study, i, x);
    b += x[1] == 1.0;
    seven += x[2] == 7.0;
  }
  EXPECT_EQ(b, 300);
  EXPECT_EQ(seven, 200);
}

TEST(Sampling, QuantilesReachBothEnds) {
  const Study study = two_axes(Method::sobol, 8);
  std::vector<double> x(3);
  design_at_quantiles(study, std::vector{0.0, 0.0, 0.0}, x);
  EXPECT_EQ(x, (std::vector<double>{1.0, 0.0, 5.0}));
  design_at_quantiles(study, std::vector{1.0, 1.0, 1.0}, x);
  EXPECT_EQ(x, (std::vector<double>{100.0, 1.0, 6.0}));
  design_at_quantiles(study, std::vector{0.5, 0.49, 0.4}, x);
  EXPECT_NEAR(x[0], 10.0, 1e-14);
  EXPECT_EQ(x[1], 0.0);
  EXPECT_EQ(x[2], 7.0);
}

TEST(Sampling, RoundPointsOfAGridAreRound) {
  const study_test::Folder folder;
  const std::string text = study_test::kHead +
                           "[[axis]]\nname = \"lens\"\nfrom = \"12 mm\"\nto = \"96 mm\"\ncount = 22\n" +
                           "[[axis]]\nname = \"huge\"\nfrom = -1e308\nto = 1.5e308\ncount = 6\n" +
                           "[[axis]]\nname = \"tenths\"\nfrom = 0.1\nto = 0.7\ncount = 3\n" + study_test::kMetrics;
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  const auto values_at = [&](std::int64_t design) {
    std::vector<double> values(3);
    design_at(result.study, design, values);
    return values;
  };
  for (int i = 0; i < 22; ++i) EXPECT_EQ(values_at(18 * i)[0], 12.0 + 4.0 * i) << i;
  EXPECT_EQ(values_at(0)[1], -1e308);
  EXPECT_NEAR(values_at(9)[1] / 1e308, 0.5, 1e-15);  // its product with the count is no double
  EXPECT_EQ(values_at(15)[1], 1.5e308);
  EXPECT_EQ(values_at(0)[2], 0.1);
  EXPECT_EQ(values_at(2)[2], 0.7);
}

}  // namespace
}  // namespace study
