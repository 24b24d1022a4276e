// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/motion_means.h"
#include "mtf/math/fresnel.h"
#include "tests/mtf/components/one_component.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

Component<double> accelerated(double velocity_um_s, double acceleration_um_s2, double direction_deg = 0.0) {
  auto c = Component<double>::make("accelerated_motion");
  set(c, "velocity", velocity_um_s);
  set(c, "acceleration", acceleration_um_s2);
  set(c, "direction", direction_deg);
  return c;
}

double distance(const Complex<double>& a, const Complex<double>& b) { return std::hypot(a.re - b.re, a.im - b.im); }

TEST(Fresnel, against_the_table) {
  const auto check = reference_check("accelerated_motion", "Fresnel integrals");
  EXPECT_TRUE(check.passed) << check.failure;
  EXPECT_EQ(check.count, 120);
  EXPECT_EQ(fresnel(1e300).c.value, 0.5);
  EXPECT_EQ(fresnel(-1e300).s.value, -0.5);
}

TEST(Fresnel, slopes_equal_differences) {
  const double h = 1e-5;
  for (const double u : {0.0, 0.4, 1.4999, 1.5, 1.5001, 3.3, -7.0}) {
    EXPECT_NEAR(fresnel(u).c.slope, (fresnel(u + h).c.value - fresnel(u - h).c.value) / (2.0 * h), 1e-8) << u;
    EXPECT_NEAR(fresnel(u).s.slope, (fresnel(u + h).s.value - fresnel(u - h).s.value) / (2.0 * h), 1e-8) << u;
  }
  for (const double y : {1e-9, 0.01, 0.2}) {
    const double step = 1e-5 * y;
    const FresnelTail low = fresnel_tail(y - step), high = fresnel_tail(y + step), at = fresnel_tail(y);
    EXPECT_NEAR(at.f.slope, (high.f.value - low.f.value) / (2.0 * step), 1e-8) << y;
    EXPECT_NEAR(at.g.slope, (high.g.value - low.g.value) / (2.0 * step), 1e-8) << y;
  }
}

TEST(ChirpMean, value_and_slopes_against_the_table) {
  const auto check = reference_check("accelerated_motion", "mean phase and slopes");
  EXPECT_TRUE(check.passed) << check.failure;
  EXPECT_EQ(check.count, 3 * 62);
}

// Both sides of every switch: quadrature to ends at 4, stationary point inside or outside at d = b, tail at u = 1.5.
TEST(ChirpMean, no_step_where_the_method_changes) {
  const auto close = [](double d, double b, double e, double c) {
    const ChirpMean p = chirp_mean(d, b), q = chirp_mean(e, c);
    const double moved = std::abs(d - e) + std::abs(b - c);  // every further slope is below pi^2
    EXPECT_LE(distance(p.value, q.value), 4e-15 + kPi * moved) << d << " " << b;
    EXPECT_LE(distance(p.by_d, q.by_d), 1e-14 + kPi * kPi * moved) << d << " " << b;
    EXPECT_LE(distance(p.by_b, q.by_b), 1e-14 + kPi * kPi * moved) << d << " " << b;
  };
  for (const double x : {0.0, 1e-9, 0.3, 2.0, 3.9999, 4.0}) {
    close(4.0, x, std::nextafter(4.0, 5.0), x);
    close(x, 4.0, x, std::nextafter(4.0, 5.0));
  }
  for (const double b : {4.5, 17.0, 300.0}) {
    close(b, b, std::nextafter(b, 0.0), b);
    const double edge = b + 1.5 * std::sqrt(b);
    close(edge, b, edge * (1.0 + 1e-15), b);
    close(b - 1.5 * std::sqrt(b), b, (b - 1.5 * std::sqrt(b)) * (1.0 + 1e-15), b);
  }
}

TEST(ChirpMean, bounded_and_finite_for_any_argument) {
  for (const double d : {0.0, 5e-324, 1e-12, 3.0, 1e5, 1e20, 1e160, 1e299, 1e308})
    for (const double b : {0.0, 5e-324, 1e-12, 3.0, 1e5, 1e20, 1e160, 1e299, 1e308})
      for (const double sign : {1.0, -1.0}) {
        const ChirpMean h = chirp_mean(d, sign * b);
        EXPECT_LE(modulus(h.value), 1.0 + 4e-16) << d << " " << b;
        EXPECT_TRUE(std::isfinite(h.by_d.re + h.by_d.im + h.by_b.re + h.by_b.im)) << d << " " << b;
      }
}

TEST(AcceleratedMotion, without_acceleration_is_linear_motion) {
  // 1200 um/s for 10 ms = 12 um.
  for (const double f : {0.0, 1.0, 83.0, 333.4, 1e7}) {
    EXPECT_NEAR(otf_at(accelerated(1200.0, 0.0, 30.0), f, 5.0).re, otf_at(motion(12.0, 30.0), f, 5.0).re, 2e-15) << f;
    EXPECT_EQ(otf_at(accelerated(1200.0, 0.0, 30.0), f, 5.0).im, 0.0);
    const auto nearly = otf_at(accelerated(1200.0, 1e-9, 30.0), f, 5.0);
    EXPECT_NEAR(nearly.re, otf_at(motion(12.0, 30.0), f, 5.0).re, 2e-15) << f;
  }
}

// The definition, summed over the exposure: 10 ms, x = v s + a s^2/2, towards lower right.
TEST(AcceleratedMotion, is_the_mean_over_the_exposure) {
  const double v = 3000.0, a = -2.4e6, angle = 0.7;
  const auto c = accelerated(v, a, angle * 180.0 / kPi);
  const WavelengthNodes rule = wavelength_nodes({-0.005, 0.005}, 200);
  for (const auto& [fx, fy] : {std::pair{10.0, 4.0}, {120.0, -30.0}, {-80.0, 200.0}}) {
    Complex<double> mean{};
    for (std::size_t i = 0; i < rule.weight.size(); ++i) {
      const double s = rule.wavelength_um[i], x = (v * s + 0.5 * a * s * s) * 1e-3;
      const double phase = -2.0 * kPi * (fx * std::cos(angle) + fy * std::sin(angle)) * x;
      mean = mean + Complex<double>{rule.weight[i] * std::cos(phase), rule.weight[i] * std::sin(phase)};
    }
    EXPECT_LE(distance(otf_at(c, fx, fy), mean), 1e-13) << fx << " " << fy;
  }
  // a t^2/24 towards +x for a > 0: the phase of a shift.
  const double shift_mm = 6e4 * 1e-4 / 24.0 * 1e-3;
  EXPECT_NEAR(otf_at(accelerated(500.0, 6e4), 1.0, 0.0).im, -2.0 * kPi * shift_mm, 1e-6);
}

TEST(AcceleratedMotion, object_angles_are_focal_plane_lengths) {
  auto angles = Component<double>::make("accelerated_motion");  // 100 mm: 1 urad = 0.1 um
  set(angles, "rate", 5000.0);
  set(angles, "angular_acceleration", 6e5);
  EXPECT_LE(distance(otf_at(angles, 70.0, 8.0), otf_at(accelerated(500.0, 6e4), 70.0, 8.0)), 1e-15);
}

TEST(AcceleratedMotion, refusals) {
  EXPECT_TRUE(refused(Component<double>::make("accelerated_motion"), "velocity"));
  auto mixed = accelerated(1.0, 1.0);
  set(mixed, "angular_acceleration", 1.0);
  EXPECT_TRUE(refused(mixed, "angular_acceleration"));
  System<double> still = detector();
  still.frame.integration_time_s = 0.0;
  EXPECT_TRUE(refused(accelerated(1.0, 1.0), "velocity", still));
}

}  // namespace
}  // namespace mtf::test
