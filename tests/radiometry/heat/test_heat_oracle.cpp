// SPDX-License-Identifier: Apache-2.0

// Random facets against CVODE at a relative tolerance of 1e-10 on a grid four times finer, extrapolated: the promise
// holds for every one, at three tolerances, and its median is less than ten times the realised error.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/radiometry/heat/oracle.h"
#include "tests/radiometry/heat/random_facets.h"

namespace radiometry::heat::test {
namespace {

constexpr double kOracle_k = 1e-7;  ///< 1e-10 of the temperature a step, a few of them

double worst_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

/// Promised over realised error of one facet at 1, 0.1 and 0.01 K.
std::vector<double> ratios(const RandomFacet& facet, std::uint32_t seed) {
  std::vector<Solution> solutions;
  for (const double tolerance_k : {1.0, 0.1, 0.01}) {
    solutions.push_back(solve(facet.batch, facet.forcing, facet.timeline, UniformStart{facet.start_k}, tolerance_k));
    EXPECT_LE(solutions.back().run.promised.total_k(), tolerance_k) << "seed " << seed;
  }
  GridRequest request = solutions.back().plan.request;
  request.density = std::max(4.0 * request.density, 4.0);
  const OracleRun truth = oracle_extrapolated(facet.batch, 0, request, facet.forcing, facet.timeline, facet.start_k);
  std::vector<double> found;
  for (const Solution& solution : solutions) {
    const double realised = std::max(worst_difference(solution.run.front_k, truth.front_k),
                                     worst_difference(solution.run.back_k, truth.back_k));
    EXPECT_LE(realised, solution.run.promised.total_k() + kOracle_k) << "seed " << seed;
    found.push_back(solution.run.promised.total_k() / realised);
  }
  return found;
}

/// Facets of the seeds first, first + step, ...
void expect_promises(std::uint32_t first, std::uint32_t step, std::uint32_t count,
                     RandomFacet (*made)(std::uint32_t) = random_facet) {
  std::vector<double> all;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::vector<double> found = ratios(made(first + i * step), first + i * step);
    all.insert(all.end(), found.begin(), found.end());
  }
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  EXPECT_LT(*middle, 10.0);
  std::printf("median of promised over realised: %.2f\n", *middle);
}

// A seed's remainder by 5 is the kind of its inside.
TEST(HeatOracle, AdiabaticFacetsKeepTheirPromise) { expect_promises(5, 5, 5); }
TEST(HeatOracle, FacetsAtAFixedTemperatureKeepTheirPromise) { expect_promises(1, 5, 5); }
TEST(HeatOracle, FacetsBeforeAnInteriorKeepTheirPromise) { expect_promises(2, 5, 5); }
TEST(HeatOracle, FacetsWithAFluxKeepTheirPromise) { expect_promises(3, 5, 5); }
TEST(HeatOracle, SheetsKeepTheirPromise) { expect_promises(4, 5, 5); }

TEST(HeatOracle, WetFacetsKeepTheirPromise) { expect_promises(1, 1, 10, random_wet_facet); }

TEST(HeatOracle, FacetsThatGenerateHeatKeepTheirPromise) { expect_promises(1, 1, 10, random_heated_facet); }

// Where the wind falls to 0 the film of tarp, its root, has no slope.
TEST(HeatOracle, FacetsThatAreBecalmedKeepTheirPromise) { expect_promises(6, 1, 3, random_calm_facet); }

TEST(HeatOracleLong, TwoHundredRandomFacetsKeepTheirPromise) { expect_promises(1, 1, 200); }

}  // namespace
}  // namespace radiometry::heat::test
