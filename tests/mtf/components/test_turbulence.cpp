// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "mtf/components/fried.h"
#include "mtf/components/turbulence.h"
#include "tests/mtf/components/one_component.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

constexpr long double kUlp = std::numeric_limits<double>::epsilon();

Component<double> turbulence(double r0_mm, bool is_short = false, double alpha = 0.5, int constant = 0) {
  auto c = Component<double>::make("turbulence");
  set(c, "fried_parameter", r0_mm);
  choose(c, "exposure", is_short ? 1 : 0);
  if (is_short) set(c, "alpha", alpha);
  choose(c, "constant", constant);
  return c;
}

// 4 um, D 0.1 m (100 mm focal length, F/1), r0 0.05 m; u = 2000, 5000, 10000 cy/rad. The third short exposure is
// 0.22341141474886 in 30 digits.
TEST(Turbulence, ten_digits) {
  const std::array f{20.0, 50.0, 100.0};
  const std::array<std::array<double, 3>, 4> values{{{.8501804224, .4735827119, .0932064635},
                                                     {.8804353535, .5892650349, .2234114147},
                                                     {.8502581456, .4737821187, .0933311174},
                                                     {.8804985011, .5894405906, .2236000827}}};
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(otf_at(turbulence(50.0, row % 2 == 1, 0.5, row < 2 ? 0 : 1), f[i], 0.0).re, values[row][i],
                  kTenDigits)
          << row << i;
}

TEST(Turbulence, against_the_tables) {
  for (const auto& [name, rows] : {std::pair{"long exposure", 42}, {"short exposure", 783}}) {
    const auto check = reference_check("turbulence", name);
    EXPECT_TRUE(check.passed) << check.failure;
    EXPECT_EQ(check.count, 2 * rows);
  }
}

// 4 ulp, and the conditioning: the exponent E of the long exposure is rounded, which e^-E turns into a relative error.
TEST(Turbulence, against_the_table_at_exact_doubles) {
  for (const Row& row : reference_table("kolmogorov.csv")) {
    const double v = number(row, "v_hex"), w = number(row, "w_hex"), alpha = number(row, "alpha_hex");
    const KolmogorovExponent e = kolmogorov_exponent(v, w, alpha);
    const long double full = kolmogorov_exponent(v, 0.0, 0.0).value, otf = precise(row, "otf");
    EXPECT_LE(std::abs(e.value - precise(row, "exponent")), 6.0L * kUlp * full) << v << " " << w << " " << alpha;
    EXPECT_LE(std::abs(std::exp(-Turbulence<double>::kExact * e.value) - otf),
              kUlp * otf * (4.0L + 2.0L * Turbulence<double>::kExact * full) + 5e-324L)
        << v << " " << w << " " << alpha;
  }
}

TEST(Turbulence, short_exposure_without_alpha_is_the_long_one) {
  for (const double f : {1.0, 30.0, 249.0, 400.0})
    EXPECT_EQ(otf_at(turbulence(50.0, true, 0.0), f, f).re, otf_at(turbulence(50.0), f, f).re) << f;
}

// D/lambda is 250 cy/mm here. Near field: rises back to 1 there, and no further.
TEST(Turbulence, short_exposure_beyond_the_aperture) {
  for (const double f : {250.0001, 300.0, 1e4, 1e300})
    EXPECT_EQ(otf_at(turbulence(80.0, true, 1.0), f, 0.0).re, 1.0) << f;
  for (const double alpha : {0.3, 0.9, 1.0})
    EXPECT_NEAR(otf_at(turbulence(80.0, true, alpha), 250.0 * (1.0 - 1e-12), 0.0).re,
                otf_at(turbulence(80.0, true, alpha), 250.0 * (1.0 + 1e-12), 0.0).re, 1e-10);
}

TEST(Turbulence, fried_parameter_scales_with_the_wavelength) {
  auto c = turbulence(50.0);
  set(c, "wavelength_reference", 0.5);
  const double r0 = 50.0 * std::pow(8.0, 1.2);
  EXPECT_NEAR(otf_at(c, 90.0, 0.0).re, otf_at(turbulence(r0), 90.0, 0.0).re, 1e-14);
}

TEST(Turbulence, aperture_comes_from_the_optics_unless_given) {
  System<double> s = detector();
  s.optics.f_number.reset();
  EXPECT_TRUE(refused(turbulence(50.0, true), "aperture", s));
  EXPECT_FALSE(refused(turbulence(50.0), "aperture", s));
  s.optics.aperture_mm = 60.0;
  auto own = turbulence(50.0, true);
  set(own, "aperture", 60.0);
  EXPECT_EQ(otf_at(turbulence(50.0, true), 40.0, 0.0, s).re, otf_at(own, 40.0, 0.0).re);
  EXPECT_NE(otf_at(own, 40.0, 0.0).re, otf_at(turbulence(50.0, true), 40.0, 0.0).re);
}

// The published HV 5/7: integral 2.235e-12 m^(1/3), r0 = 4.96 cm at 0.5 um, plane wave to the zenith.
TEST(Fried, hufnagel_valley_5_7) {
  const HufnagelValley profile;
  EXPECT_NEAR(structure_parameter(profile, 0.0), 1.7e-14 + 2.7e-16, 1e-28);
  const double integral = 1e5 * path_mean(profile, 1e5, 0.0, Wave::plane).value;
  EXPECT_NEAR(integral, 2.235e-12, 1e-15);
  EXPECT_NEAR(1.0 / inverse_fried(integral, 0.5).value_1_mm, 49.6, 0.05);
  // The same to mpmath's digits, with spherical waves both ways.
  EXPECT_NEAR(integral / 2.23539488e-12, 1.0, 3e-9);
  for (const auto& [target, down, up] : {std::tuple{1000.0, 1.5214905894890048e-15, 1.1797626529636997e-16},
                                         {20000.0, 1.0400208040300093e-16, 2.8711664265195517e-18},
                                         {0.05, 6.475379854503227e-15, 6.4739298189631557e-15}}) {
    EXPECT_NEAR(path_mean(profile, target, 0.0, Wave::spherical).value / down, 1.0, 1e-13) << target;
    EXPECT_NEAR(path_mean(profile, 0.0, target, Wave::spherical).value / up, 1.0, 1e-13) << target;
  }
}

// To mpmath's digits: the atmosphere is the last or the first millionth of the path.
TEST(Fried, paths_to_and_from_a_satellite_keep_their_digits) {
  const HufnagelValley profile;
  for (const auto& [altitude, down, up] : {std::tuple{6e5, 3.7154672724500722892e-18, 3.397923513244668294e-22},
                                           {3.6e7, 6.2091458000113123534e-20, 6.1585281523927650006e-27},
                                           {1e9, 2.2353911936044603611e-21, 8.701957003269104568e-31}}) {
    EXPECT_NEAR(path_mean(profile, altitude, 0.0, Wave::spherical).value / down, 1.0, 1e-14) << altitude;
    EXPECT_NEAR(path_mean(profile, 0.0, altitude, Wave::spherical).value / up, 1.0, 1e-14) << altitude;
  }
}

// A constant profile: the weight s^(5/3) has the mean 3/8; the layers reach any altitude.
TEST(Fried, second_routes) {
  const HufnagelValley calm{0.0, 0.0};  // 2.7e-16 exp(-h/1500) alone: closed form
  const double low = 300.0, high = 9000.0;
  const double exact = 2.7e-16 * 1500.0 * (std::exp(-low / 1500.0) - std::exp(-high / 1500.0)) / (high - low);
  EXPECT_NEAR(path_mean(calm, low, high, Wave::plane).value / exact, 1.0, 1e-14);
  EXPECT_NEAR(path_mean(calm, high, low, Wave::plane).value / exact, 1.0, 1e-14);
  const HufnagelValley profile;
  const double horizontal = structure_parameter(profile, 50.0);
  EXPECT_NEAR(path_mean(profile, 50.0, 50.0, Wave::spherical).value / (0.375 * horizontal), 1.0, 1e-14);
  EXPECT_NEAR(path_mean(profile, 50.0, 50.0 + 1e-7, Wave::plane).value / horizontal, 1.0, 1e-8);
  EXPECT_EQ(path_mean(profile, 1e7, 1e6, Wave::plane).value, 0.0);
  EXPECT_EQ(inverse_fried(0.0, 1.0).value_1_mm, 0.0);
}

TEST(Fried, slopes_equal_differences) {
  const auto value = [](double wind, double ground, double target, double sensor) {
    return path_mean({wind, ground}, target, sensor, Wave::spherical).value;
  };
  for (const auto& [target, sensor] : {std::pair{2000.0, 20.0}, {5.0, 9000.0}, {100.0, 100.05}, {400.0, 3e4}}) {
    const PathMean m = path_mean({21.0, 1.7e-14}, target, sensor, Wave::spherical);
    const double scale = m.value;
    EXPECT_NEAR(m.by_wind, (value(21.01, 1.7e-14, target, sensor) - value(20.99, 1.7e-14, target, sensor)) / 0.02,
                1e-9 * scale);
    EXPECT_NEAR(m.by_ground, (value(21, 1.8e-14, target, sensor) - value(21, 1.6e-14, target, sensor)) / 2e-15,
                1e-9 * std::abs(m.by_ground));
    EXPECT_NEAR(m.by_target,
                (value(21, 1.7e-14, target + 1e-3, sensor) - value(21, 1.7e-14, target - 1e-3, sensor)) / 2e-3,
                1e-8 * scale);
    EXPECT_NEAR(m.by_sensor,
                (value(21, 1.7e-14, target, sensor + 1e-3) - value(21, 1.7e-14, target, sensor - 1e-3)) / 2e-3,
                1e-8 * scale);
  }
}

Component<double> path(int profile, int wave) {
  auto c = Component<double>::make("turbulence");
  choose(c, "profile", profile);
  choose(c, "wave", wave);
  return c;
}

TEST(Turbulence, by_a_path_is_that_by_its_fried_parameter) {
  // Spherical, 2 km of 1e-14: r0 = (0.423 k^2 3/8 Cn2 L)^(-3/5) at 4 um.
  auto constant = path(0, 0);
  set(constant, "cn2", 1e-14);
  set(constant, "path_length", 2000.0);
  const double k = 2.0 * kPi / 4e-6, r0_mm = 1e3 * std::pow(0.423 * k * k * 0.375 * 1e-14 * 2000.0, -0.6);
  EXPECT_NEAR(otf_at(constant, 30.0, 9.0).re, otf_at(turbulence(r0_mm), 30.0, 9.0).re, 1e-14);
  // HV 5/7 along 60 degrees: twice the path.
  auto slant = path(1, 1);
  set(slant, "target_altitude", 1e5);
  set(slant, "zenith_angle", 60.0);
  const double zenith_r0_mm = 49.6056782 * std::pow(8.0, 1.2);  // from 0.5 um to 4 um
  EXPECT_NEAR(otf_at(slant, 300.0, 0.0).re, otf_at(turbulence(zenith_r0_mm * std::pow(2.0, -0.6)), 300.0, 0.0).re,
              1e-9);
  auto length = path(1, 1);
  set(length, "target_altitude", 1e5);
  set(length, "path_length", 2e5);
  EXPECT_NEAR(otf_at(length, 300.0, 0.0).re, otf_at(slant, 300.0, 0.0).re, 1e-14);
}

TEST(Turbulence, one_way_to_the_fried_parameter) {
  EXPECT_TRUE(refused(Component<double>::make("turbulence"), "fried_parameter"));
  auto both = turbulence(50.0);
  set(both, "cn2", 1e-14);
  EXPECT_TRUE(refused(both, "cn2"));
  auto half = path(0, 0);
  set(half, "cn2", 1e-14);
  EXPECT_TRUE(refused(half, "path_length"));
  set(half, "path_length", 1000.0);
  EXPECT_FALSE(refused(half, "path_length"));
  set(half, "wind", 21.0);
  EXPECT_TRUE(refused(half, "wind"));
  auto layered = path(1, 0);
  EXPECT_TRUE(refused(layered, "target_altitude"));
  set(layered, "target_altitude", 2000.0);
  EXPECT_TRUE(refused(layered, "path_length"));
  set(layered, "path_length", 1000.0);  // shorter than the rise
  EXPECT_TRUE(refused(layered, "path_length"));
  set(layered, "path_length", 5000.0);
  EXPECT_FALSE(refused(layered, "path_length"));
  set(layered, "wavelength_reference", 0.5);
  EXPECT_TRUE(refused(layered, "wavelength_reference"));
}

}  // namespace
}  // namespace mtf::test
