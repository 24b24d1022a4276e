// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "radiometry/light/band_response.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<Spectrum> curves() {
  return {make_spectrum("qe", {3.0, 3.4, 4.6, 5.2}, {0.1, 0.7, 0.8, 0.0}, 1.0),
          make_spectrum("filter", {3.3, 3.5, 4.7, 4.9}, {0.0, 0.9, 0.88, 0.0}, 1.0)};
}

/// Two lines far apart, one of them 1e10 times weaker: the slope of log L changes within a few kelvin.
std::vector<Spectrum> two_lines() {
  return {make_spectrum("lines", {1.0, 1.01, 1.02, 10.0, 10.01, 10.02}, {0.0, 1.0, 0.0, 0.0, 1e-10, 0.0})};
}

struct Case {
  Interval band;
  std::vector<Spectrum> curves;
  double lo_k, hi_k;
};

TEST(RadianceTable, relative_error_below_1e_7_at_any_temperature) {
  std::mt19937_64 random(7);
  for (const auto& [band, factors, lo, hi] :
       {Case{{3.0, 5.0}, curves(), 250.0, 350.0}, Case{{3.0, 5.0}, curves(), 1.0, 6000.0},
        Case{{3.0, 5.0}, {}, 1.0, 1e9}, Case{{8.0, 14.0}, {}, 0.5, 3e38}, Case{{0.1, 0.2}, {}, 1.0, 1e9},
        Case{{1e5, 1e6}, {}, 1e-3, 1e9}, Case{{0.5, 12.0}, two_lines(), 100.0, 6000.0},
        Case{{3.0, 5.0}, {}, 300.0, 300.0}}) {
    const BandResponse response(band, factors);
    const RadianceTable table(response, lo, hi);
    std::uniform_real_distribution<double> log_t(std::log(lo), std::log(hi));
    double worst = 0.0;
    for (int i = 0; i < 4000; ++i) {
      const auto t = static_cast<float>(lo == hi ? lo : std::exp(log_t(random)));
      const double exact = response.radiance(Flux::photons, static_cast<double>(t));
      if (exact < 1e-44)
        EXPECT_LE(table(t), 1e-44) << t;
      else
        worst = std::max(worst, std::abs(table(t) / exact - 1.0));
    }
    EXPECT_LT(worst, 1e-7) << describe(band) << ", " << lo << " K to " << hi << " K";
  }
}

TEST(RadianceTable, rises_strictly_from_float_to_float) {
  const RadianceTable table(BandResponse({3.0, 5.0}, curves()), 200.0, 700.0);
  float t = 255.9F;
  for (int i = 0; i < 200000; ++i) {
    const float next = std::nextafter(t, kInfinity);
    ASSERT_LT(table(t), table(next)) << t;
    t = next;
  }
}

TEST(RadianceTable, nothing_at_0_K_nan_for_nan_infinite_for_infinite) {
  const RadianceTable table(BandResponse({3.0, 5.0}, {}), 0.0, 6000.0);
  EXPECT_EQ(table(0.0F), 0.0);
  EXPECT_EQ(table(-0.0F), 0.0);
  EXPECT_EQ(table(-5.0F), 0.0);
  EXPECT_EQ(table(1.0F), 0.0);
  EXPECT_EQ(table(std::numeric_limits<float>::denorm_min()), 0.0);
  EXPECT_TRUE(std::isnan(table(std::nanf(""))));
  EXPECT_EQ(table(kInfinity), static_cast<double>(kInfinity));
  EXPECT_EQ(table(7000.0F), table(6000.0F));
  EXPECT_GT(table(6000.0F), 0.0);
}

TEST(RadianceTable, cold_scenes_have_no_light) {
  for (const double hi : {0.0, 1e-30, 1.0, 5.0}) {
    const RadianceTable table(BandResponse({3.0, 5.0}, {}), 0.0, hi);
    for (const float t : {0.0F, 0.5F, 1.0F, 5.0F, 1e30F}) EXPECT_EQ(table(t), 0.0) << hi << " " << t;
    EXPECT_TRUE(std::isnan(table(std::nanf(""))));
  }
}

TEST(RadianceTable, refusals) {
  const BandResponse response({3.0, 5.0}, {});
  expect_refused({"from -1 K to 5 K"}, [&] { RadianceTable(response, -1.0, 5.0); });
  expect_refused({"from 6 K to 5 K"}, [&] { RadianceTable(response, 6.0, 5.0); });
  expect_refused({"inf K"}, [&] { RadianceTable(response, 6.0, HUGE_VAL); });
  expect_refused({"nan K"}, [&] { RadianceTable(response, std::nan(""), 5.0); });
}

}  // namespace
}  // namespace radiometry
