// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/light/path.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

TEST(Path, constants_and_absorbing_air) {
  const Path clear = Path{};
  EXPECT_EQ(evaluate(clear.transmission, 4.0), 1.0);
  EXPECT_EQ(evaluate(clear.radiance, 4.0), 0.0);
  const Path haze = absorbing_path(make_spectrum("tau", {3.0, 5.0}, {0.8, 0.6}), 290.0);
  EXPECT_NEAR(evaluate(haze.emissivity, 4.0), 0.3, 1e-16);
  EXPECT_EQ(haze.air_temperature_k, 290.0);
}

TEST(PathTable, follows_beer_between_ranges_and_starts_clear) {
  const double k3 = 2e-4, k5 = 1e-3;  // per m
  const PathTable table("air", {500.0, 2000.0}, {3.0, 5.0},
                        {{std::exp(-k3 * 500), std::exp(-k5 * 500)}, {std::exp(-k3 * 2000), std::exp(-k5 * 2000)}},
                        {{0.1, 0.2}, {0.4, 0.5}});
  for (const double range : {0.0, 1.0, 250.0, 500.0, 800.0, 2000.0}) {
    const Path path = table.at(range);
    EXPECT_NEAR(evaluate(path.transmission, 3.0), std::exp(-k3 * range), 2e-15) << range;
    EXPECT_NEAR(evaluate(path.transmission, 5.0), std::exp(-k5 * range), 2e-15) << range;
  }
  EXPECT_EQ(evaluate(table.at(0.0).radiance, 3.0), 0.0);
  EXPECT_NEAR(evaluate(table.at(250.0).radiance, 5.0), 0.1, 1e-16);
  EXPECT_NEAR(evaluate(table.at(1250.0).radiance, 3.0), 0.25, 1e-16);
}

TEST(PathTable, opaque_lines_and_single_wavelengths_work) {
  const PathTable table("air", {1000.0}, {4.3}, {{0.0}}, {{0.3}});
  EXPECT_EQ(evaluate(table.at(500.0).transmission, 4.3), 0.5);
  EXPECT_EQ(evaluate(table.at(1000.0).transmission, 8.0), 0.0);
}

TEST(PathTable, refusals) {
  const auto make = [](std::vector<double> range, std::vector<std::vector<double>> tau) {
    return [=] { PathTable("air.csv", range, {3.0, 5.0}, tau, std::vector(range.size(), std::vector{0.0, 0.0})); };
  };
  expect_refused({"air.csv", "no ranges"}, make({}, {}));
  expect_refused({"air.csv", "range 2 is 100 m"}, make({500.0, 100.0}, {{1, 1}, {1, 1}}));
  expect_refused({"range 1 is -1 m"}, make({-1.0}, {{1, 1}}));
  expect_refused({"2 ranges, 1 curves"}, make({1.0, 2.0}, {{1, 1}}));
  expect_refused({"range 7 m", "sample 2", "above 1"}, make({7.0}, {{1, 1.5}}));
  expect_refused({"2 wavelengths and 1 values"}, make({7.0}, {{1}}));
  const PathTable table("air.csv", {1000.0}, {4.3}, {{0.5}}, {{0.3}});
  expect_refused({"2000 m", "from 0 to 1000 m"}, [&] { table.at(2000.0); });
  expect_refused({"-1 m"}, [&] { table.at(-1.0); });
  expect_refused({"nan"}, [&] { table.at(std::nan("")); });
  expect_refused({"above 1"}, [] { constant_path(1.5, 0.0); });
  expect_refused({"negative"}, [] { constant_path(0.5, -1.0); });
  expect_refused({"air of -3 K"}, [] { absorbing_path(constant_spectrum("tau", 0.5), -3.0); });
  expect_refused({"above 1"}, [] { complement(constant_spectrum("e", 1.2)); });
}

}  // namespace
}  // namespace radiometry
