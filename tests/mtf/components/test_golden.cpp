// SPDX-License-Identifier: Apache-2.0
// Published and hand-computed values, and a second route to each formula where there is one.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mtf/math/special.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/conformance.h"

namespace mtf::test {
namespace {

constexpr std::array<double, 4> kFrequencies{5.0, 10.0, 20.0, 29.41176470588235};  // the last: 0.5 / 17 um

System<double> bare(double wavelength_um = 10.0, double f_number = 2.0) {
  System<double> s;
  s.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  s.optics.f_number = f_number;
  s.optics.wavelength_um = wavelength_um;
  return s;
}

Complex<double> otf(const Component<double>& component, double fx, double fy, const System<double>& s = bare()) {
  return component.otf({fx, fy}, s.context());
}

Component<double> butterworth(int poles, double cutoff_cy_mm, int axis = 0) {
  auto c = Component<double>::make("butterworth");
  set(c, "cutoff", cutoff_cy_mm, "cy/mm");
  set(c, "poles", poles);
  choose(c, "axis", axis);
  return c;
}

Component<double> rms_wavefront(double waves) {
  auto c = Component<double>::make("rms_wavefront");
  set(c, "rms", waves);
  return c;
}

void expect_values(const Component<double>& component, const std::array<double, 4>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(otf(component, kFrequencies[i], 0.0).re, values[i], 5.01e-11) << component.kind() << i;
}

TEST(Golden, ten_digits) {
  expect_values(Component<double>::make("diffraction"), {.8728885716, .7470600781, .5046315755, .2968058266});
  expect_values(footprint(15.0), {.9907728960, .9633977620, .8583936913, .7092174591});
  expect_values(jitter(4.0), {.9921354055, .9689107912, .8813231367, .7609352256});
  expect_values(motion(10.0, 0.0), {.9958927352, .9836316431, .9354892838, .8636570275});
  expect_values(butterworth(3, 25.0), {.9999680015, .9979582701, .8901138251, .5233186716});
}

// MWIR 4 um, F/2, 15 um pitch and footprint, jitter 2 um rms.
TEST(Golden, sensor_by_hand) {
  const System<double> s = mwir();
  const auto& list = s.list(Stage::presample);
  EXPECT_NEAR(list[0].component.cutoff_cy_mm(s.context()), 125.0, 1e-12);
  const double nyquist = s.frame.nyquist_cy_mm(Axis::x);
  EXPECT_NEAR(nyquist, 33.33, 5e-3);
  EXPECT_NEAR(4.0 * 2.0 / 15.0, 0.5333, 5e-5);
  const Freq<double> f{nyquist, 0.0};
  EXPECT_NEAR(s.otf(list[0], f).re, 0.6645, 5e-5);
  EXPECT_NEAR(s.otf(list[1], f).re, 0.6366, 5e-5);
  EXPECT_NEAR(s.otf(list[1], f).re, 2.0 / kPi, 1e-15);
  EXPECT_NEAR(s.otf(list[2], f).re, 0.9160, 5e-5);
  EXPECT_NEAR(s.otf(f).re, 0.3875, 5e-5);
  EXPECT_EQ(s.otf(f).im, 0.0);
}

TEST(SecondRoute, one_pole_butterworth_is_the_modulus_of_rc) {
  for (double f = -90.0; f < 90.0; f += 3.7)
    for (const int axis : {0, 1}) {
      const Complex<double> h = otf(rc(25.0, axis), f, 0.5 * f);
      EXPECT_NEAR(otf(butterworth(1, 25.0, axis), f, 0.5 * f).re, std::hypot(h.re, h.im), 5e-16);
    }
  // An n-pole filter is the product of its poles on the unit circle.
  for (const int n : {2, 3, 4, 7})
    for (const double u : {0.1, 0.9, 1.0, 1.3, 5.0}) {
      double modulus = 1.0;
      for (int k = 0; k < n; ++k) {
        const double angle = kPi * (2.0 * k + n + 1.0) / (2.0 * n);
        modulus /= std::hypot(-std::cos(angle), u - std::sin(angle));
      }
      EXPECT_NEAR(otf(butterworth(n, 25.0), 25.0 * u, 3.0).re, modulus, 1e-14) << n << " " << u;
    }
}

TEST(SecondRoute, rms_wavefront_nodes) {
  const double cutoff = 50.0;  // 10 um, F/2
  const double w = 0.07;
  // 1 at both ends, deepest at half the cutoff: 1 - (W / 0.18)^2.
  EXPECT_EQ(otf(rms_wavefront(w), 0.0, 0.0).re, 1.0);
  EXPECT_NEAR(otf(rms_wavefront(w), 0.5 * cutoff, 0.0).re, 1.0 - w * w / 0.0324, 1e-15);
  EXPECT_NEAR(otf(rms_wavefront(w), cutoff * (1.0 - 1e-12), 0.0).re, 1.0, 1e-11);
  EXPECT_EQ(otf(rms_wavefront(w), 1.5 * cutoff, 0.0).re, 1.0);
  EXPECT_NEAR(otf(rms_wavefront(w), 0.25 * cutoff, 0.0).re, 1.0 - 0.75 * w * w / 0.0324, 1e-15);
  EXPECT_EQ(otf(rms_wavefront(0.0), 12.0, 5.0).re, 1.0);
  EXPECT_EQ(otf(rms_wavefront(0.25), 0.5 * cutoff, 0.0).re, 0.0);  // clipped, not negative
  // Stated at another wavelength, the error in waves scales with reference / wavelength.
  auto scaled = rms_wavefront(0.7);
  set(scaled, "wavelength_reference", 1.0);
  EXPECT_NEAR(otf(scaled, 0.5 * cutoff, 0.0).re, otf(rms_wavefront(0.07), 0.5 * cutoff, 0.0).re, 1e-15);
}

TEST(SecondRoute, motion_along_the_axes_and_the_diagonal) {
  for (double f = 0.0; f < 300.0; f += 11.3) {
    const double along = sinc(0.01 * f).value;  // 10 um
    EXPECT_EQ(otf(motion(10.0, 0.0), f, 77.0).re, along);
    EXPECT_EQ(otf(motion(10.0, 90.0), -41.0, f).re, along);
    EXPECT_EQ(otf(motion(10.0, 180.0), f, 77.0).re, along);
    EXPECT_NEAR(otf(motion(10.0, 45.0), f, f).re, sinc(0.01 * f * std::sqrt(2.0)).value, 2e-15);
    EXPECT_EQ(otf(motion(10.0, 45.0), f, -f).re, 1.0);  // across the motion nothing is lost
  }
}

TEST(SecondRoute, motion_by_velocity_and_by_rate_is_the_travel_in_one_integration) {
  auto velocity = Component<double>::make("linear_motion");
  set(velocity, "velocity", 1200.0);  // um/s x 10 ms = 12 um
  set(velocity, "direction", 30.0);
  auto rate = Component<double>::make("linear_motion");
  set(rate, "rate", 12000.0);  // urad/s x 100 mm = 1200 um/s
  set(rate, "direction", 30.0);
  for (const double f : {3.0, 40.0, 71.0}) {
    EXPECT_NEAR(otf(velocity, f, -9.0).re, otf(motion(12.0, 30.0), f, -9.0).re, 1e-15);
    EXPECT_NEAR(otf(rate, f, -9.0).re, otf(motion(12.0, 30.0), f, -9.0).re, 1e-15);
  }
}

// Integral of psf(x) exp(-2 pi i f x) for a uniform line of length `width`, by Gauss-Legendre.
Complex<double> transform_of_box(double width_mm, double f) {
  const WavelengthNodes rule = wavelength_nodes({1.0, 2.0}, 40);
  Complex<double> sum;
  for (std::size_t k = 0; k < rule.weight.size(); ++k) {
    const double x = width_mm * (rule.wavelength_um[k] - 1.5);
    sum = sum +
          Complex<double>{rule.weight[k] * std::cos(2.0 * kPi * f * x), -rule.weight[k] * std::sin(2.0 * kPi * f * x)};
  }
  return sum;
}

TEST(SecondRoute, footprint_by_quadrature_of_the_box) {
  auto c = Component<double>::make("footprint");
  set_xy(c, "width", 15.0, 11.0, "um");
  for (const double fx : {0.0, 20.0, 66.6667, 90.0, -140.0})
    for (const double fy : {0.0, 13.0, 100.0}) {
      const Complex<double> box = transform_of_box(0.015, fx) * transform_of_box(0.011, fy);
      EXPECT_NEAR(otf(c, fx, fy).re, box.re, 1e-14);
      EXPECT_NEAR(otf(c, fx, fy).im, box.im, 1e-14);
    }
  auto filled = Component<double>::make("footprint");
  set(filled, "fill_factor", 0.81);  // 0.9 x 15 um a side
  EXPECT_NEAR(otf(filled, 31.0, 8.0).re, otf(footprint(13.5), 31.0, 8.0).re, 1e-15);
}

// Integral of a normal density; trapezoids of an analytic function that dies out converge at once.
TEST(SecondRoute, gaussian_by_quadrature) {
  for (const double f : {0.0, 7.0, 40.0, 120.0}) {
    const double sigma = 0.004, step = 0.25 * sigma;
    double sum = 0.0;
    for (int i = -60; i <= 60; ++i)
      sum += std::exp(-0.5 * std::pow(i * step / sigma, 2)) * std::cos(2.0 * kPi * f * i * step);
    EXPECT_NEAR(otf(gaussian(4.0), f, 0.0).re, sum * step / (sigma * std::sqrt(2.0 * kPi)), 1e-14) << f;
    EXPECT_EQ(otf(jitter(4.0), f, 0.0).re, otf(gaussian(4.0), f, 0.0).re);
  }
}

// Two equal blurs are one of sqrt(2) times the size, whatever direction is looked at.
TEST(SecondRoute, gaussians_add_in_quadrature) {
  const double twice = otf(gaussian(3.0), 20.0, 15.0).re * otf(gaussian(3.0), 20.0, 15.0).re;
  EXPECT_NEAR(otf(gaussian(3.0 * std::sqrt(2.0)), 25.0, 0.0).re, twice, 1e-15);
}

}  // namespace
}  // namespace mtf::test
