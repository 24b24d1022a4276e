// SPDX-License-Identifier: Apache-2.0
// Variance-based indices against functions whose indices are known in closed form.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "apps/study/statistics/indices.h"
#include "tests/apps/study/evaluated.h"

namespace {

constexpr double kPi = std::numbers::pi;

/// Ishigami and Homma (1990) with a = 7, b = 0.1, x uniform in (-pi, pi).
double ishigami(std::span<const double> unit) {
  const auto x = [&](std::size_t j) { return kPi * (2.0 * unit[j] - 1.0); };
  return std::sin(x(0)) + 7.0 * std::pow(std::sin(x(1)), 2) + 0.1 * std::pow(x(2), 4) * std::sin(x(0));
}

study::IndexJob job_of(std::int64_t samples, int threads, const study::PointMaker& point, std::size_t results) {
  return {.parameters = 3, .results = results, .samples = samples, .seed = 1, .threads = threads, .make = [point] {
            return point;
          }};
}

// What was taken until then is a sample of its own, and says how much it was.
TEST(Indices, EndWhenTheTimeIsOver) {
  const study::PointMaker point = [](std::span<const double> unit, std::span<double> results) {
    results[0] = ishigami(unit);
  };
  study::IndexJob job = job_of(1 << 16, 1, point, 1);
  int asked = 0;
  job.go_on = [&] { return ++asked < 64; };
  const study::Indices some = study::sensitivity_indices(job);
  EXPECT_EQ(some.samples, 64 * 16);
  EXPECT_EQ(some.used.front(), some.samples);
  EXPECT_NEAR(some.of[0][0].first, 0.3139, 5.0 * some.of[0][0].first_sd);
  job.samples = some.samples;
  job.go_on = {};
  EXPECT_EQ(study::sensitivity_indices(job).of[0][1].total, some.of[0][1].total);
}

TEST(Indices, IshigamiHasItsAnalyticIndices) {
  // V1 = (1 + b pi^4/5)^2/2, V2 = a^2/8, V13 = b^2 pi^8 (1/18 - 1/50).
  const double v1 = std::pow(1.0 + 0.1 * std::pow(kPi, 4) / 5.0, 2) / 2.0, v2 = 49.0 / 8.0,
               v13 = 0.01 * std::pow(kPi, 8) * (1.0 / 18.0 - 1.0 / 50.0), v = v1 + v2 + v13;
  EXPECT_NEAR(v1 / v, 0.3139, 1e-4);
  const std::array<double, 3> first{v1 / v, v2 / v, 0.0}, total{(v1 + v13) / v, v2 / v, v13 / v};
  const study::PointMaker point = [](std::span<const double> unit, std::span<double> results) {
    results[0] = ishigami(unit);
    results[1] = 1e9 + 1e-3 * ishigami(unit);  // the same behind a large constant
    results[2] = -1e200 * ishigami(unit);
  };
  const study::Indices indices = study::sensitivity_indices(job_of(1 << 16, 2, point, 3));
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t j = 0; j < 3; ++j) {
      const study::Index& index = indices.of[r][j];
      // Four standard errors, which are themselves small: at n = 65536 some 0.01 (first) and 0.005 (total).
      EXPECT_NEAR(index.first, first[j], 4.0 * index.first_sd) << r << " " << j;
      EXPECT_NEAR(index.total, total[j], 4.0 * index.total_sd) << r << " " << j;
      EXPECT_LT(index.first_sd, 0.01) << r << " " << j;
      EXPECT_LT(index.total_sd, 0.01) << r << " " << j;
    }
}

TEST(Indices, StandardErrorsAreThoseOfRepeatedRuns) {
  const study::PointMaker point = [](std::span<const double> unit, std::span<double> results) {
    results[0] = ishigami(unit);
  };
  constexpr int kRuns = 200;
  double mean = 0.0, square = 0.0, said = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    study::IndexJob job = job_of(512, 1, point, 1);
    job.seed = static_cast<std::uint64_t>(run) + 100;
    const study::Index index = study::sensitivity_indices(job).of[0][1];
    mean += index.first / kRuns;
    square += index.first * index.first / kRuns;
    said += index.first_sd / kRuns;
  }
  const double scatter = std::sqrt(square - mean * mean);
  // The scatter of 200 runs is known to 1 / sqrt(400) = 5 %; four of that, and the bootstrap's own bias of some 1 / n.
  EXPECT_NEAR(said / scatter, 1.0, 0.2);
  EXPECT_NEAR(mean, 0.4424, 4.0 * scatter / std::sqrt(static_cast<double>(kRuns)));
}

TEST(Indices, ASumOfLinearTermsSharesItsVarianceWithoutInteraction) {
  const study::PointMaker point = [](std::span<const double> unit, std::span<double> results) {
    results[0] = unit[0] + 2.0 * unit[1];  // variances 1 : 4, the third parameter has no part
  };
  const study::Indices indices = study::sensitivity_indices(job_of(1 << 14, 2, point, 1));
  const std::array<double, 3> share{0.2, 0.8, 0.0};
  for (std::size_t j = 0; j < 3; ++j) {
    const study::Index& index = indices.of[0][j];
    EXPECT_NEAR(index.first, share[j], 4.0 * index.first_sd + 1e-12);
    EXPECT_NEAR(index.total, share[j], 4.0 * index.total_sd + 1e-12);
  }
  EXPECT_EQ(indices.of[0][2].total, 0.0);
}

TEST(Indices, ThreadsChangeNothing) {
  const study::PointMaker point = [](std::span<const double> unit, std::span<double> results) {
    results[0] = ishigami(unit);
  };
  const study::Index one = study::sensitivity_indices(job_of(1000, 1, point, 1)).of[0][1];
  const study::Index two = study::sensitivity_indices(job_of(1000, 3, point, 1)).of[0][1];
  EXPECT_EQ(one.first, two.first);
  EXPECT_EQ(one.total_sd, two.total_sd);
}

TEST(Indices, WhatDoesNotVaryOrIsMostlyMissingHasNone) {
  const study::PointMaker point = [](std::span<const double> unit, std::span<double> results) {
    results[0] = 3.25;
    results[1] = unit[0] < 0.5 ? std::nan("") : unit[1];  // half of A, half of B: a quarter of the samples or less
    results[2] = unit[0] < 0.05 ? std::nan("") : unit[1];
    results[3] = std::nan("");
  };
  const study::Indices indices = study::sensitivity_indices(job_of(4096, 2, point, 4));
  EXPECT_TRUE(std::isnan(indices.of[0][0].first));
  EXPECT_TRUE(std::isnan(indices.of[1][1].total));
  EXPECT_NEAR(indices.of[2][1].first, 1.0, 5.0 * indices.of[2][1].first_sd + 1e-9);
  EXPECT_LT(indices.used[2], 4096);
  EXPECT_TRUE(std::isnan(indices.of[3][0].first));
  EXPECT_EQ(indices.used[3], 0);
}

// Either end of a range may be the larger; what has one value has no part.
TEST(Indices, AnAxisMayFall) {
  const study_test::Folder folder;
  const auto axis = [](const std::string& ends) { return "[[axis]]\nparameter = \"pitch\"\n" + ends; };
  const auto shares = [&](const std::string& ends) {
    const study_test::Evaluated e = study_test::evaluated(
        folder, study_test::kHead + axis(ends) + "[[axis]]\nparameter = \"optics.obscuration\"\nvalues = [0.3]\n" +
                    study_test::kMetrics);
    return study::study_indices(e.study, e.columns, 0.5, 1, {}).indices.of[0];
  };
  for (const char* const ends :
       {"from = \"5 um\"\nto = \"8 um\"\ncount = 4\n", "from = \"8 um\"\nto = \"5 um\"\ncount = 4\n"}) {
    const std::vector<study::Index> of = shares(ends);
    EXPECT_NEAR(of[0].total, 1.0, 5.0 * of[0].total_sd) << ends;
    EXPECT_GT(of[0].total, 0.5) << ends;
    EXPECT_EQ(of[1].total, 0.0) << ends;
  }
  EXPECT_TRUE(std::isnan(shares("values = [\"5 um\"]\n")[0].total));
}

}  // namespace
