// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "mtf/components/motion_means.h"
#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"
#include "tests/mtf/reference_table.h"

namespace mtf::test {
namespace {

constexpr double kUlp = std::numeric_limits<double>::epsilon();

Component<double> vibration(double amplitude_um, double direction_deg = 0.0) {
  auto c = Component<double>::make("vibration");
  set(c, "amplitude", amplitude_um, "um");
  set(c, "direction", direction_deg);
  return c;
}

TEST(Bessel, against_the_table) {
  for (const auto& [component, name] : {std::pair{"vibration", "J0"}, {"circular_footprint", "2 J1(x)/x"}}) {
    const auto check = reference_check(component, name);
    EXPECT_TRUE(check.passed) << check.failure;
    EXPECT_EQ(check.count, 54);
  }
}

TEST(Bessel, slopes_equal_differences_across_the_switch_to_the_series) {
  for (const double x : {0.0, 1e-6, 0.03, 0.0999, std::nextafter(0.1, 0.0), 0.1, 0.1001, 0.7, 3.0, 5.136, 40.0}) {
    const double h = 1e-5;
    EXPECT_NEAR(bessel_j0(x).slope, (bessel_j0(x + h).value - bessel_j0(x - h).value) / (2.0 * h), 1e-10) << x;
    EXPECT_NEAR(jinc(x).slope, (jinc(x + h).value - jinc(x - h).value) / (2.0 * h), 1e-10) << x;
  }
  const double left = std::nextafter(0.1, 0.0);
  EXPECT_NEAR(jinc(left).value, jinc(0.1).value, 2.0 * kUlp);
  EXPECT_NEAR(jinc(left).slope, jinc(0.1).slope, 1e-14);
}

TEST(Vibration, ten_digits) {
  const std::array values{.9938410033, .9754777741, .9037126421, .7976799381};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(otf_at(vibration(5.0), kGoldenFrequencies[i], 0.0).re, values[i], kTenDigits) << i;
}

// Its definition, the mean phase over one cycle; the negative lobe included.
TEST(Vibration, is_the_mean_over_a_cycle) {
  for (const double f : {3.0, 60.0, 122.0, 190.0}) {
    double mean = 0.0;
    for (int k = 0; k < 256; ++k) mean += cos_pi(2.0 * f * 0.005 * sin_pi((k + 0.5) / 128.0)) / 256.0;
    EXPECT_NEAR(otf_at(vibration(5.0), f, 9.0).re, mean, 1e-14) << f;
    EXPECT_NEAR(otf_at(vibration(5.0, 90.0), 9.0, f).re, mean, 1e-14) << f;
    EXPECT_NEAR(otf_at(vibration(5.0, 30.0), f * std::cos(kPi / 6.0), f * std::sin(kPi / 6.0)).re, mean, 1e-14) << f;
  }
  EXPECT_LT(otf_at(vibration(5.0), 122.0, 0.0).re, -0.4);
}

TEST(Vibration, two_amplitudes_are_refused) {
  auto c = vibration(1.0);
  set_xy(c, "amplitude", 1.0, 2.0, "um");
  EXPECT_TRUE(refused(c, "amplitude"));
}

Component<double> exposure(double amplitude_um, double cycles, double phase_deg) {
  auto c = vibration(amplitude_um);
  choose(c, "average", 1);
  set(c, "cycles", cycles);
  set(c, "phase", phase_deg);
  return c;
}

Component<double> rms_over_phases(double amplitude_um, double cycles) {
  auto c = vibration(amplitude_um);
  choose(c, "average", 2);
  set(c, "cycles", cycles);
  return c;
}

// Amplitude x frequency = 0.5, a quarter of a cycle: 5 um at 100 cy/mm.
TEST(Vibration, published_quarter_cycle) {
  EXPECT_NEAR(otf_at(rms_over_phases(5.0, 0.25), 100.0, 0.0).re, .6596, 5.01e-5);
  EXPECT_NEAR(otf_at(rms_over_phases(5.0, 0.1), 100.0, 0.0).re, .9242, 5.01e-5);
  EXPECT_NEAR(otf_at(vibration(5.0), 100.0, 0.0).re, -.304, 5.01e-4);
  double mean = 0.0, least = 1.0, most = 0.0;
  for (int k = 0; k < 720; ++k) {
    const double h = modulus(otf_at(exposure(5.0, 0.25, 0.5 * k), 100.0, 0.0));
    mean += h / 720.0;
    least = std::min(least, h);
    most = std::max(most, h);
  }
  EXPECT_NEAR(mean, .6179, 5.01e-5);
  EXPECT_NEAR(least, .3077, 5.01e-5);
  EXPECT_NEAR(most, .9623, 5.01e-5);
}

/// The definition, over the exposure in panels of less than half a radian of phase.
Complex<double> over_the_exposure(double x, double cycles, double turns) {
  const int panels = 8 + static_cast<int>(2.0 * x * std::min(1.0, cycles) * (1.0 + cycles));
  const WavelengthNodes rule = wavelength_nodes({0.0, 1.0}, 8);
  Complex<double> mean{};
  for (int k = 0; k < panels; ++k)
    for (std::size_t i = 0; i < rule.weight.size(); ++i) {
      const double s = (k + rule.wavelength_um[i]) / panels - 0.5, phase = x * sin_pi(2.0 * (turns + cycles * s));
      const double w = rule.weight[i] / panels;
      mean = mean + Complex<double>{w * std::cos(phase), -w * std::sin(phase)};
    }
  return mean;
}

TEST(SineMotion, is_the_mean_over_the_exposure) {
  for (const double x : {0.2, 3.0, 49.9, 50.1, 90.0, 700.0, 2500.0, 4e4})
    for (const double cycles : {1e-4, 0.003, 0.04, 0.26, 0.5, 0.77, 2.3})
      for (const double turns : {0.0, 0.13, 0.2499, 0.25, 0.27, 0.5, 0.74, -0.3}) {
        const Complex<double> exact = over_the_exposure(x, cycles, turns), h = sine_mean(x, cycles, turns).value;
        EXPECT_LE(std::hypot(h.re - exact.re, h.im - exact.im), 2e-14 + x * kUlp) << x << " " << cycles << " " << turns;
      }
}

// x c stays, x grows: a straight motion of that length about the crossing of the middle, sin(pi x c)/(pi x c), whatever
// whole and half turns the phase holds.
TEST(SineMotion, short_windows_keep_their_digits_at_whole_and_half_turns) {
  for (const double turns : {0.0, 0.5, 1.0, -0.5, -1.0})
    for (const double xc : {0.7, 2.4, 2.7, 31.3})
      for (const double x : {1e8, 1e10, 1e12}) {
        const SineMean h = sine_mean(x, xc / x, turns);
        EXPECT_NEAR(h.value.re, sinc(xc).value, 1e-13) << x << " " << xc << " " << turns;
        EXPECT_NEAR(h.value.im, 0.0, 1e-13) << x << " " << xc << " " << turns;
      }
}

TEST(SineMotion, slopes_equal_differences) {
  for (const double x : {0.2, 3.0, 47.0, 61.0, 700.0})
    for (const double cycles : {0.003, 0.04, 0.26, 0.77, 2.3})
      for (const double turns : {0.02, 0.13, 0.251, 0.74}) {
        const SineMean h = sine_mean(x, cycles, turns);
        const auto compare = [&](const Complex<double>& slope, const SineMean& high, const SineMean& low, double step) {
          const double re = (high.value.re - low.value.re) / (2.0 * step),
                       im = (high.value.im - low.value.im) / (2.0 * step);
          EXPECT_LE(std::hypot(slope.re - re, slope.im - im), 2e-7 * (1.0 + x)) << x << " " << cycles << " " << turns;
        };
        compare(h.by_x, sine_mean(x + 1e-5, cycles, turns), sine_mean(x - 1e-5, cycles, turns), 1e-5);
        compare(h.by_cycles, sine_mean(x, cycles + 1e-7, turns), sine_mean(x, cycles - 1e-7, turns), 1e-7);
        compare(h.by_turns, sine_mean(x, cycles, turns + 1e-7), sine_mean(x, cycles, turns - 1e-7), 1e-7);
        const SineRms r = sine_rms(x, cycles);
        EXPECT_NEAR(r.by_x, (sine_rms(x + 1e-5, cycles).value - sine_rms(x - 1e-5, cycles).value) / 2e-5, 1e-7);
        EXPECT_NEAR(r.by_cycles, (sine_rms(x, cycles + 1e-6).value - sine_rms(x, cycles - 1e-6).value) / 2e-6,
                    1e-6 * (1.0 + x));
      }
}

// Both sides of every switch of method.
TEST(SineMotion, no_step_where_the_method_changes) {
  for (const double cycles : {1e-3, 0.04, 0.26, 0.77, 2.3})
    for (const double turns : {0.0, 0.1, 0.25}) {
      const SineMean below = sine_mean(50.0, cycles, turns),
                     above = sine_mean(std::nextafter(50.0, 51.0), cycles, turns);
      EXPECT_NEAR(below.value.re, above.value.re, 3e-14) << cycles << " " << turns;
      EXPECT_NEAR(below.value.im, above.value.im, 3e-14) << cycles << " " << turns;
      EXPECT_NEAR(below.by_x.re, above.by_x.re, 3e-14) << cycles << " " << turns;
    }
  for (double x = 100.0; x < 4000.0; x *= 1.37)  // quadrature to ends, somewhere in each sweep
    for (const double turns : {0.05, 0.24}) {
      double cycles = 1e-4;
      for (; cycles < 0.5; cycles *= 1.003) {
        const Complex<double> a = sine_mean(x, cycles, turns).value,
                              b = sine_mean(x, cycles * (1 + 1e-13), turns).value;
        EXPECT_LE(std::hypot(a.re - b.re, a.im - b.im), 1e-13 + x * 1e-15) << x << " " << cycles;
      }
    }
}

TEST(SineMotion, rms_is_the_mean_square_over_phases) {
  for (const double x : {0.3, 4.0, 45.0, 300.0, 1999.0})
    for (const double cycles : {0.02, 0.3, 0.5, 1.7}) {
      double square = 0.0;
      const int n = 16 + static_cast<int>(4.0 * x);
      for (int k = 0; k < n; ++k) {
        const Complex<double> h = sine_mean(x, cycles, (k + 0.5) / n).value;
        square += (h.re * h.re + h.im * h.im) / n;
      }
      EXPECT_NEAR(sine_rms(x, cycles).value, std::sqrt(square), 1e-12) << x << " " << cycles;
    }
}

// From x = 2000 on towards its leading term, or quadrature for a small part of a cycle.
TEST(SineMotion, rms_at_large_arguments) {
  for (const double x : {2000.7, 2300.3, 2500.0, 9000.0})
    for (const double cycles : {1e-3, 4e-3, 6e-3, 0.02, 0.1, 0.3, 0.49, 0.51, 0.8, 1.3, 2.6, 17.2}) {
      double square = 0.0;
      const int n = static_cast<int>(4.0 * x);
      for (int k = 0; k < n; ++k) {
        const Complex<double> h = sine_mean(x, cycles, (k + 0.5) / n).value;
        square += (h.re * h.re + h.im * h.im) / n;
      }
      EXPECT_NEAR(sine_rms(x, cycles).value, std::sqrt(square), 2e-4) << x << " " << cycles;
    }
}

TEST(Vibration, whole_cycles_are_j0_exactly) {
  for (const double f : {0.0, 1.0, 80.0, 122.0, 1e4, 1e7, 1e12})
    for (const double cycles : {1.0, 2.0, 7.0, 1000.0}) {
      const double j0 = otf_at(vibration(5.0), f, 3.0).re;
      EXPECT_EQ(otf_at(exposure(5.0, cycles, 77.0), f, 3.0).re, j0) << f;
      EXPECT_EQ(otf_at(exposure(5.0, cycles, 77.0), f, 3.0).im, 0.0) << f;
      const double rms = otf_at(rms_over_phases(5.0, cycles), f, 3.0).re;
      if (f <= 1e4)
        EXPECT_EQ(rms, std::abs(j0)) << f;
      else
        EXPECT_NEAR(rms, std::abs(j0), 2e-4) << f;
    }
}

// Where one way of evaluation goes over into another, value and slopes change no faster than the slopes tell.
TEST(Vibration, rms_has_no_step) {
  const auto expect_smooth = [](double x, double cycles, double dx, double dc) {
    const SineRms a = sine_rms(x - dx, cycles - dc), b = sine_rms(x + dx, cycles + dc), m = sine_rms(x, cycles);
    const double predicted = 2.0 * (m.by_x * dx + m.by_cycles * dc);
    EXPECT_NEAR(b.value - a.value, predicted, 1e-9 + 1e-3 * std::abs(predicted)) << x << " " << cycles;
  };
  for (const double cycles : {0.00559, 0.3, 1.7}) {
    expect_smooth(2500.0, cycles, 1e-6, 0.0);
    expect_smooth(2000.0, cycles, 1e-6, 0.0);
  }
  for (const double x : {2300.0, 2600.0, 1e5})
    for (const double turn : {48.0, 64.0}) expect_smooth(x, std::asin(0.5 * turn / x) / kPi, 0.0, 1e-11);
  expect_smooth(3000.7, 2.0 - 1e-6, 0.0, 1e-9);
  EXPECT_NEAR(sine_rms(3000.7, 2.0 - 1e-13).value, sine_rms(3000.7, 2.0).value, 1e-12);
}

TEST(Vibration, many_part_cycles_approach_j0) {
  for (const double f : {30.0, 90.0, 200.0})
    EXPECT_NEAR(otf_at(exposure(5.0, 987.654, 40.0), f, 0.0).re, otf_at(vibration(5.0), f, 0.0).re, 1e-3) << f;
}

// A short exposure while passing the middle: linear motion of 2 pi A c; at a crest: a shift of A.
TEST(Vibration, short_exposures) {
  const double cycles = 1e-3, travel_um = 2.0 * kPi * 100.0 * cycles;
  for (const double f : {50.0, 700.0, 2000.0}) {
    EXPECT_NEAR(otf_at(exposure(100.0, cycles, 0.0), f, 0.0).re, otf_at(motion(travel_um, 0.0), f, 0.0).re, 2e-5) << f;
    const Complex<double> shift = phase_of(2.0 * f * 0.1), h = otf_at(exposure(100.0, 1e-6, 90.0), f, 0.0);
    EXPECT_NEAR(h.re, shift.re, 1e-6) << f;
    EXPECT_NEAR(h.im, shift.im, 1e-6) << f;
  }
}

TEST(Vibration, period_is_cycles_in_the_exposure) {
  auto c = vibration(5.0);
  choose(c, "average", 1);
  set(c, "period", 0.04);  // 10 ms exposure
  const Complex<double> a = otf_at(c, 70.0, 0.0), b = otf_at(exposure(5.0, 0.25, 0.0), 70.0, 0.0);
  EXPECT_NEAR(a.re, b.re, 1e-15);
  EXPECT_NEAR(a.im, b.im, 1e-15);
}

TEST(Vibration, finite_for_any_argument) {
  for (const double x : {0.0, 5e-324, 1e-9, 50.0, 2000.0, 1e8, 1e17, 1e200, 1e299, 1e308})
    for (const double cycles : {0.0, 5e-324, 1e-9, 0.3, 0.5, 1.0, 33.3, 1e9, 1e18})
      for (const double turns : {0.0, 0.25, -0.8}) {
        const SineMean h = sine_mean(x, cycles, turns);
        const SineRms r = sine_rms(x, cycles);
        EXPECT_TRUE(std::isfinite(h.by_x.re + h.by_x.im + h.by_cycles.re + h.by_cycles.im + h.by_turns.re)) << x;
        EXPECT_LE(modulus(h.value), 1.0 + 1e-15) << x << " " << cycles;
        EXPECT_TRUE(std::isfinite(r.by_x + r.by_cycles) && r.value >= 0.0 && r.value <= 1.0 + kUlp)
            << x << " " << cycles;
      }
}

TEST(Vibration, averages_need_their_values) {
  auto c = vibration(1.0);
  set(c, "cycles", 0.5);
  EXPECT_TRUE(refused(c, "cycles"));
  choose(c, "average", 2);
  EXPECT_FALSE(refused(c, "cycles"));
  set(c, "period", 0.1);
  EXPECT_TRUE(refused(c, "cycles"));
  c = vibration(1.0);
  choose(c, "average", 1);
  EXPECT_TRUE(refused(c, "cycles"));
  c = rms_over_phases(1.0, 0.4);
  set(c, "phase", 10.0);
  EXPECT_TRUE(refused(c, "phase"));
}

}  // namespace
}  // namespace mtf::test
