// SPDX-License-Identifier: Apache-2.0

// Random facets against CVODE at a relative tolerance of 1e-10 on a grid four times finer, extrapolated: the promise
// holds for every one, at three tolerances, and is not wasteful.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

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
std::vector<double> ratios(std::uint32_t seed) {
  const RandomFacet facet = random_facet(seed);
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
    if (std::getenv("HEAT_VERBOSE")) {
      const Run& r = solution.run;
      std::printf(
          "seed %u inside %zu: nodes %zu steps %g grid %g depth %g realised %g ratio %.2f taken %ld refused %ld\n",
          seed, facet.batch.construction.inside.index(), solution.plan.fine.nodes(), r.promised.steps_k,
          r.promised.grid_k, r.promised.depth_k, realised, r.promised.total_k() / realised,
          static_cast<long>(r.steps.taken), static_cast<long>(r.steps.refused));
    }
    found.push_back(solution.run.promised.total_k() / realised);
  }
  return found;
}

void expect_promises(std::uint32_t first, std::uint32_t count) {
  std::vector<double> all;
  for (std::uint32_t seed = first; seed < first + count; ++seed) {
    const std::vector<double> found = ratios(seed);
    all.insert(all.end(), found.begin(), found.end());
  }
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
  EXPECT_LT(all[all.size() / 2], 10.0);
}

TEST(HeatOracle, PromisesHoldForRandomFacets) { expect_promises(1, 25); }
TEST(HeatOracle, One) {
  if (const char* s = std::getenv("HEAT_SEED")) expect_promises(std::atoi(s), 1);
}
TEST(HeatOracleLong, PromisesHoldForTwoHundredRandomFacets) { expect_promises(1, 200); }

}  // namespace
}  // namespace radiometry::heat::test
