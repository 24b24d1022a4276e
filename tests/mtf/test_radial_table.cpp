// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/otf_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mtf::test {
namespace {

double circular(double r) { return r < 1.0 ? 2.0 / M_PI * (std::acos(r) - r * std::sqrt(1.0 - r * r)) : 0.0; }
double bell(double r) { return std::exp(-30.0 * r * r); }
double ringing(double r) { return r == 0.0 ? 1.0 : std::sin(40.0 * r) / (40.0 * r); }
double kinked(double r) { return std::max(0.0, 1.0 - 1.7 * r); }

RadialTable table_of(double (*f)(double), double end, double target) {
  return RadialTable(
      [&](std::span<const double> r, std::span<double> v) {
        for (std::size_t i = 0; i < r.size(); ++i) v[i] = f(r[i] / end);
      },
      end, target);
}

TEST(RadialTable, error_is_a_bound_at_random_points) {
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (double (*f)(double) : {circular, bell, ringing, kinked})
    for (const double end : {1e-20, 1.0, 125.0, 1e20})
      for (const double target : {1e-4, 1e-6, 1e-7}) {
        const RadialTable table = table_of(f, end, target);
        // A kink ends the table's refinement: then the error is what is left, not what was asked for.
        EXPECT_LE(table.error(), f == kinked ? std::max(10.0 * target, 3e-5) : 10.0 * target + 1e-6);
        std::vector<float> x2(500), value(500);
        for (int row = 0; row < 20; ++row) {
          const float y2 = static_cast<float>(std::pow(unit(generator), 2) * 0.4);
          for (float& v : x2) v = static_cast<float>(std::pow(unit(generator), 2));
          std::fill(value.begin(), value.end(), 1.0F);
          table.multiply(x2, y2, value);
          for (std::size_t i = 0; i < x2.size(); ++i) {
            const double r = std::sqrt(static_cast<double>(x2[i]) + static_cast<double>(y2));
            if (r >= 1.0) continue;
            ASSERT_NEAR(value[i], f(r), table.error()) << r << " target " << target;
          }
        }
      }
}

// A cutoff far below the first step: the samples at even steps are 1, 0, 0, ..., or the fall and rise are unseen.
TEST(RadialTable, a_structure_within_its_first_interval_shows_in_the_error) {
  const auto dip = [](double r) { return r > 0.0 && r < 1e-8 ? 0.3 : 1.0; };
  const RadialTable table = table_of(dip, 7.0, 1e-6);
  EXPECT_GE(table.error(), 0.7);
  const auto spike = [](double r) { return circular(1e9 * r); };
  EXPECT_GE(table_of(spike, 7.0, 1e-6).error(), 0.9);
}

TEST(RadialTable, stays_at_its_last_value_beyond_the_end) {
  const RadialTable cut = table_of(circular, 10.0, 1e-6);
  const std::vector<float> x2{1.0F, 1.5F, 1e30F, HUGE_VALF};
  std::vector<float> value(4, 1.0F);
  cut.multiply(x2, 0.0F, value);
  for (const float v : value) EXPECT_EQ(v, 0.0F);
}

TEST(RadialTable, bound_from_covers_all_larger_radii) {
  const RadialTable table = table_of(ringing, 5.0, 1e-6);
  for (double r = 0.0; r <= 5.0; r += 0.0137) {
    double largest = 0.0;
    for (double t = r; t <= 5.0; t += 0.001) largest = std::max(largest, std::abs(ringing(t / 5.0)));
    ASSERT_GE(table.bound_from(r), largest);
  }
  EXPECT_LT(table.bound_from(5.0), 0.05);
}

}  // namespace
}  // namespace mtf::test
