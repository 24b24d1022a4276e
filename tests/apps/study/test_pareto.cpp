// SPDX-License-Identifier: Apache-2.0
// The Pareto front against its definition, point by point.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "apps/study/statistics/pareto.h"

namespace {

using study::FrontPoints;

/// Every point against every other.
std::vector<std::int64_t> by_definition(const FrontPoints& points) {
  std::vector<std::int64_t> front;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool stays = true;
    for (std::size_t j = 0; j < points.size() && stays; ++j) {
      bool as_good = true, better = false;
      for (std::size_t k = 0; k < points.objectives; ++k) {
        as_good = as_good && points.at(j)[k] >= points.at(i)[k];
        better = better || points.at(j)[k] > points.at(i)[k];
      }
      if (as_good && (better || points.designs[j] < points.designs[i])) stays = false;
    }
    if (stays) front.push_back(points.designs[i]);
  }
  std::sort(front.begin(), front.end());
  return front;
}

/// `levels` > 0: values of few levels, so that many are equal. `spread`: how far off a plane on which all are on the
/// front.
FrontPoints random_points(std::size_t count, std::size_t objectives, int levels, double spread, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  FrontPoints points{.objectives = objectives};
  std::vector<double> values(objectives);
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0.0;
    for (double& v : values) {
      v = uniform(random);
      if (levels > 0) v = std::floor(v * levels);
      sum += v;
    }
    if (spread < 1.0) values[0] += spread * uniform(random) - sum;
    points.add(static_cast<std::int64_t>(i), values);
  }
  return points;
}

TEST(Pareto, AgreesWithTheDefinition) {
  for (const std::size_t objectives : {1U, 2U, 3U, 4U, 6U})
    for (const int levels : {0, 2, 8})
      for (const double spread : {0.0, 0.1, 1.0})
        for (const std::size_t count : {0U, 1U, 2U, 33U, 700U, 1500U}) {
          const FrontPoints points = random_points(count, objectives, levels, spread, static_cast<unsigned>(count) + 7);
          EXPECT_EQ(study::front_of(points).designs, by_definition(points))
              << objectives << " objectives, " << levels << " levels, spread " << spread << ", " << count << " points";
        }
}

TEST(Pareto, OfEqualPointsTheFirstStays) {
  FrontPoints points{.objectives = 3};
  for (const std::int64_t design : {9, 4, 7}) points.add(design, std::array{1.0, 2.0, 3.0});
  EXPECT_EQ(study::front_of(points).designs, std::vector<std::int64_t>{4});
}

TEST(Pareto, InfinitiesAreValues) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  FrontPoints points{.objectives = 2};
  points.add(0, std::array{inf, -inf});
  points.add(1, std::array{-inf, -inf});
  points.add(2, std::array{-inf, 0.0});
  EXPECT_EQ(study::front_of(points).designs, (std::vector<std::int64_t>{0, 2}));
}

TEST(Pareto, StreamedInAnyPiecesItIsTheSame) {
  const FrontPoints points = random_points(150'000, 3, 40, 0.05, 3);
  const auto whole = study::front_of(points).designs;
  for (const std::size_t piece : {1000U, 70'000U}) {
    study::StreamingFront streaming(3);
    // From the end, so that order does not help.
    for (std::size_t end = points.size(); end > 0;) {
      const std::size_t begin = end > piece ? end - piece : 0;
      FrontPoints part{.objectives = 3};
      for (std::size_t i = begin; i < end; ++i) part.add(points.designs[i], points.at(i));
      streaming.add(part);
      end = begin;
    }
    EXPECT_EQ(streaming.result().designs, whole);
  }
}

}  // namespace
