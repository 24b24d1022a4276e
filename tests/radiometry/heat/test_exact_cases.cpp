// SPDX-License-Identifier: Apache-2.0

// Closed forms: within the promise, and that within the tolerance, from a coarse tolerance to 1e-6 of the temperature
// difference.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/radiometry/heat/exact_cases.h"

namespace radiometry::heat::test {
namespace {

/// The last digits of the values themselves.
constexpr double kDigits = 2e-9;

void expect_within_promise(const ExactCase& exact) {
  const Batch batch{exact.construction, 1, {}};
  const Timeline timeline{0.0, exact.outputs_s.back(), exact.outputs_s, {}};
  for (const double tolerance_k : {1.0, 0.1, 0.01, 1e-6 * exact.scale_k}) {
    const Solution solution = solve(batch, exact.forcing, timeline, exact.start, tolerance_k);
    const double promised = solution.run.promised.total_k();
    double realised = 0.0;
    for (std::size_t i = 0; i < exact.front_k.size(); ++i)
      realised = std::max(realised, std::abs(solution.run.front_k[i] - exact.front_k[i]));
    EXPECT_LE(promised, tolerance_k) << exact.name;
    EXPECT_LE(realised, promised + kDigits * exact.scale_k + exact.form_k)
        << exact.name << " at " << tolerance_k << " K, nodes " << solution.plan.fine.nodes();
  }
}

TEST(HeatClosedForms, CoolingSlabs) {
  for (const ExactCase& exact : slabs()) expect_within_promise(exact);
}
TEST(HeatClosedForms, PeriodicFluxOnLayers) {
  for (const ExactCase& exact : periodic_layers()) expect_within_promise(exact);
}
TEST(HeatClosedForms, HalfSpaces) {
  for (const ExactCase& exact : half_spaces()) expect_within_promise(exact);
}
TEST(HeatClosedForms, RadiatingFoils) {
  for (const ExactCase& exact : foils()) expect_within_promise(exact);
}
TEST(HeatClosedForms, Equilibria) {
  for (const ExactCase& exact : equilibria()) expect_within_promise(exact);
}

}  // namespace
}  // namespace radiometry::heat::test
