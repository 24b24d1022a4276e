// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/ttp.h"

#include <gtest/gtest.h>

#include "mtf/components/sample_and_hold.h"
#include "radiometry/performance/acquisition.h"
#include "radiometry/performance/target_at_range.h"
#include "tests/expect_error.h"
#include "tests/radiometry/performance_cases.h"

namespace radiometry {
namespace {

using test::gaussian_mtf;
using test::performance_cases;
using test::sensitivity_of;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(ContrastThreshold, values_in_print) {
  const std::array u{1.0, 4.0, 16.0}, long_form{403.03, 536.22, 122.31}, squared{231.62, 453.97, 110.03};
  Observer<double> o;  // 34.26 cd/m^2, 10 degrees
  for (std::size_t i = 0; i < u.size(); ++i) {
    o.model = ContrastModel::barten_2003;
    EXPECT_NEAR(1.0 / eye_contrast_threshold(o, u[i]), long_form[i], 5e-3);
    o.model = ContrastModel::barten_short_squared;
    EXPECT_NEAR(1.0 / eye_contrast_threshold(o, u[i]), squared[i], 5e-3);
    o.eyes = 1;
    EXPECT_NEAR(1.0 / eye_contrast_threshold(o, u[i]), squared[i] / std::sqrt(2.0), 5e-3);
    o.eyes = 2;
  }
}

TEST(ContrastThreshold, ends_and_bad_input) {
  const Observer<double> o;
  EXPECT_EQ(eye_contrast_threshold(o, 0.0), kInfinite);
  EXPECT_EQ(eye_contrast_threshold(o, 1e6), kInfinite);
  EXPECT_GT(eye_contrast_threshold(o, 1e-9), 1e6);
  EXPECT_EQ(system_sensitivity(o, 1.0, 0.0, 1.0), 0.0);
  EXPECT_EQ(system_sensitivity(o, 1.0, -0.2, 1.0), 0.0);
  EXPECT_EQ(minimum_resolvable_k(5.0, 0.0), kInfinite);
  EXPECT_EQ(minimum_resolvable_k(5.0, 100.0), 0.1);
  expect_refused({"observer.luminance", "observer.eyes"},
                 [] { eye_contrast_threshold(Observer<double>{.luminance_cd_m2 = 0.0, .eyes = 3}, 1.0); });
  expect_refused({"cycles/degree"}, [&] { eye_contrast_threshold(o, -1.0); });
}

// A cycle/mrad is 17.453 cycles/degree; with a magnification of 10 the eye sees a tenth of the frequency.
TEST(ContrastThreshold, units_of_the_system) {
  const Observer<double> o{.magnification = 10.0, .display_contrast = 0.8};
  EXPECT_NEAR(system_sensitivity(o, 2.0, 0.5, 4.0), 0.8 * 0.5 / 4.0 * eye_sensitivity(o, 0.2 * 17.453292519943295),
              1e-12);
  const double pupil = mtf::pupil_diameter_mm(34.26, 2).value;
  EXPECT_EQ(eye_mtf_at(o, 2.0), mtf::eye_mtf(0.2, pupil).value);
}

// The logarithm is the natural one: the channel is half at exp(-+sqrt(ln 2 / 2.2)), 1.62 octaves apart; log10 would
// make it 3.73.
TEST(EyeChannel, is_one_and_six_tenths_of_an_octave_wide) {
  const double half = std::exp(std::sqrt(std::log(2.0) / 2.2));
  EXPECT_NEAR(eye_channel(half), 0.5, 1e-15);
  EXPECT_NEAR(eye_channel(1.0 / half), 0.5, 1e-15);
  EXPECT_NEAR(2.0 * std::log2(half), 1.62, 5e-3);
  EXPECT_EQ(eye_channel(1.0), 1.0);
  EXPECT_EQ(eye_channel(0.0), 0.0);
  EXPECT_NEAR(eye_channel(10.0), std::exp(-2.2 * std::log(10.0) * std::log(10.0)), 1e-15);  // 8.6e-6, not 0.11
}

TEST(EyeChannel, bandwidths) {
  for (const auto& c : performance_cases("channel"))
    EXPECT_NEAR(channel_bandwidth<double>(c.x[0], [&](double f) { return gaussian_mtf(f, c.x[1]); }), c.value,
                1e-11 * c.value)
        << c.where;
  // White noise: 2 f sqrt(pi/4.4) exp(1/17.6), in proportion to f.
  EXPECT_NEAR(channel_bandwidth<double>(3.0, [](double) { return 1.0; }),
              6.0 * std::sqrt(mtf::kPi / 4.4) * std::exp(1.0 / 17.6), 1e-11);
  EXPECT_EQ(channel_bandwidth<double>(0.0, [](double) { return 1.0; }), 0.0);
  for (const double bad : {-1.0, std::nan(""), kInfinite})
    expect_refused({"cycles/mrad"}, [bad] { channel_bandwidth<double>(bad, [](double) { return 1.0; }); });
  // Without a channel: of a Gaussian exp(-(f/a)^2), a sqrt(pi/2).
  EXPECT_NEAR(bandwidth<double>(20.0, [](double f) { return gaussian_mtf(f, 2.0); }), 2.0 * std::sqrt(mtf::kPi / 2.0),
              1e-11);
}

TEST(NoiseFactor, limits_and_units) {
  EXPECT_EQ(noise_factor(862.0, 0.0, 1.0, 1.0, 5.0), 1.0);
  EXPECT_NEAR(noise_factor(862.0, 1.0, 0.5, 0.5, 1e-6), 862.0 * 0.5e6, 1e-3);
  // 0.1 mrad samples at 25 Hz: the density over Nyquist's band and 25 Hz gives the variance back.
  const double density = noise_density(0.05, 0.1, 0.2, 25.0);
  EXPECT_NEAR(density * density * 10.0 * 5.0 * 25.0, 0.05 * 0.05, 1e-17);
  // 34.26 cd/m^2 = 10 fL, two eyes: pupil 3.106 mm.
  const double pupil = 13.23 * std::exp(-1.0 / 21.082) - 9.511, trolands = 34.26 * mtf::kPi / 4.0 * pupil * pupil;
  EXPECT_NEAR(observer_alpha(Observer<double>{}), 240.0 * std::sqrt(2.0 * 3.538 / (1.0 + 24.01 * 4.75 / trolands)),
              0.05);
}

// 1/CTF = s exp(-f/a): the band ends at a ln(C s), the integral is 2 a (sqrt(C s) - 1), its slope by C a sqrt(s/C).
TEST(Ttp, of_an_exponential) {
  const auto s = [](double f) { return 200.0 * std::exp(-f / 0.7); };
  const SensitivityCourse course = sensitivity_course(s, 50.0);
  for (const double contrast : {0.0051, 0.02, 0.3, 40.0}) {
    const AxisTtp<double> ttp = axis_ttp(course, s, contrast);
    EXPECT_EQ(ttp.lo, 0.0);
    EXPECT_NEAR(ttp.hi, 0.7 * std::log(200.0 * contrast), 1e-14);
    EXPECT_NEAR(ttp.value, 1.4 * (std::sqrt(200.0 * contrast) - 1.0), 1e-10 * ttp.value + 1e-12);
    EXPECT_NEAR(ttp.by_contrast, 0.7 * std::sqrt(200.0 / contrast), 1e-9 * ttp.by_contrast);
    EXPECT_LE(ttp.error, 1e-9 * ttp.value);
  }
}

TEST(Ttp, against_40_digits) {
  for (const auto& c : performance_cases("ttp_axis")) {
    const auto s = sensitivity_of<double>(c.x);
    const AxisTtp<double> ttp = axis_ttp(sensitivity_course(s, 100.0), s, c.x.back());
    EXPECT_NEAR(ttp.value, c.value, 1e-10 * c.value) << c.where;
    EXPECT_NEAR(ttp.by_contrast, c.slope, 1e-9 * c.slope) << c.where;
  }
}

TEST(Ttp, limits) {
  const std::vector<double> x{2.0, 34.26, 10.0, 10.0, 1.0, 1.0, 4.0};
  const auto s = sensitivity_of<double>(x);
  const SensitivityCourse course = sensitivity_course(s, 100.0);
  EXPECT_EQ(axis_ttp(course, s, 0.0).value, 0.0);
  const double least = 1.0 / course.value[course.peak];
  EXPECT_EQ(axis_ttp(course, s, least * (1.0 - 1e-9)).value, 0.0);
  // Just above the least threshold the band is narrow and there: width goes with the root of the excess.
  const AxisTtp<double> narrow = axis_ttp(course, s, least * (1.0 + 1e-6));
  const AxisTtp<double> wider = axis_ttp(course, s, least * (1.0 + 4e-6));
  EXPECT_GT(narrow.value, 0.0);
  EXPECT_NEAR(wider.value / narrow.value, 2.0, 1e-3);
  EXPECT_NEAR(narrow.value, narrow.hi - narrow.lo, 1e-5 * narrow.value);
  // Contrast that returns beyond a zero is not counted.
  const auto ringing = [](double f) { return 100.0 * mtf::sinc(f).value; };
  EXPECT_LT(axis_ttp(sensitivity_course(ringing, 10.0), ringing, 1.0).hi, 1.0);
  // Where the MTF ends, the band ends before it.
  const auto ends = [](double f) { return f < 1.0 ? 100.0 * (1.0 - f) : 0.0; };
  EXPECT_NEAR(axis_ttp(sensitivity_course(ends, 1.0), ends, 1.0).hi, 0.99, 1e-14);
  EXPECT_NEAR(axis_ttp(sensitivity_course(ends, 8.0), ends, 1.0).value, 2.0 / 30.0 * (1000.0 - 1.0) / 10.0, 1e-9);
  // An MTF of nothing but zeros.
  const auto blind = [](double) { return 0.0; };
  EXPECT_EQ(axis_ttp(sensitivity_course(blind, 8.0), blind, 1.0).value, 0.0);
  expect_refused({"end of the sensitivity"}, [&] { sensitivity_course(blind, 0.0); });
  expect_refused({"contrast"}, [&] { axis_ttp(course, s, -0.1); });
  expect_refused({"contrast"}, [&] { axis_ttp(course, s, kInfinite); });
}

TEST(Ttp, two_axes_and_cycles_on_target) {
  const AxisTtp<double> x{.value = 4.0}, y{.value = 9.0}, blind{};
  EXPECT_EQ(ttp_of(x, y), 6.0);
  EXPECT_EQ(ttp_of(x, blind), 0.0);
  EXPECT_NEAR(cycles_on_target(6.0, 3.0, 2000.0), 9.0, 1e-14);  // 3 m at 2 km: 1.5 mrad
}

// Noise passes the filters of both axes, whichever way the bars run: along them by the eye's channel, across them by
// those of the other axis. Computed elsewhere from the formulas of contrast_threshold.h and eye_fits.h, by sums over
// 6401 frequencies of the channel, good to 1e-7. With the filters of one axis both along and across it was 25.0292.
TEST(DisplayObserver, noise_across_the_bars_is_filtered_by_the_other_axis) {
  mtf::System<double> system;
  system.frame.focal_length_mm = 100.0;
  system.frame.pitch_x_um = system.frame.pitch_y_um = 10.0;
  Conditions conditions;
  conditions.magnification = 5.0;
  conditions.frame_rate_hz = 30.0;
  SensorAtRange<double> sensor{.netd_k = 0.5, .spatial_netd_k = 0.1};
  sensor.otf.mtf = [](mtf::Axis, double f) { return std::exp(-f * f / 16.0); };
  const auto ttp = [&] { return DisplayObserver<double>(system, conditions, 1.0, 19.0).ttp_cy_mrad(sensor, 2.0); };
  EXPECT_NEAR(ttp(), 21.663298, 1e-5);
  system.add(mtf::Stage::postsample, mtf::SampleAndHold<double>{.width = mtf::micrometres(60.0)});
  EXPECT_NEAR(ttp(), 26.216683, 1e-5);
}

TEST(TaskProbability, values_in_print) {
  const std::array x{0.5, 1.0, 1.5, 2.0}, with{.24419, .5, .68097, .79889}, without{.26120, .5, .64753, .73880};
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(task_probability(Psychometric::ttp_nvthermip, x[i]), with[i], 5e-6);
    EXPECT_NEAR(task_probability(Psychometric::ttp_nvipm, x[i]), without[i], 5e-6);
  }
  // Johnson: 2^4.1/(1 + 2^4.1).
  EXPECT_NEAR(task_probability(Psychometric::johnson, 2.0), std::exp2(4.1) / (1.0 + std::exp2(4.1)), 1e-15);
}

TEST(TaskProbability, ends_and_inverse) {
  for (const Psychometric model : {Psychometric::ttp_nvthermip, Psychometric::ttp_nvipm, Psychometric::johnson}) {
    EXPECT_EQ(task_probability(model, 0.0), 0.0);
    EXPECT_EQ(task_probability(model, kInfinite), 1.0);
    EXPECT_EQ(task_probability(model, 1e200), 1.0);
    EXPECT_GE(task_probability(model, 1e-300), 0.0);
    EXPECT_EQ(ratio_for_probability(model, 0.0), 0.0);
    EXPECT_EQ(ratio_for_probability(model, 1.0), kInfinite);
    double before = -1.0;
    for (double x = 1e-4; x < 20.0; x *= 1.4) {
      const double p = task_probability(model, x);
      EXPECT_GE(p, before);
      before = p;
      // 1 - P has the digits of P near 1.
      if (p < 1.0) {
        EXPECT_NEAR(ratio_for_probability(model, p), x, 1e-13 * x / (1.0 - p));
      }
    }
    expect_refused({"0 to 1"}, [&] { ratio_for_probability(model, 1.5); });
    expect_refused({"cycles"}, [&] { task_probability(model, -1.0); });
  }
  for (const auto& c : performance_cases("ratio"))
    EXPECT_NEAR(ratio_for_probability(static_cast<Psychometric>(static_cast<int>(c.x[0])), c.x[1]), c.value,
                1e-14 * c.value)
        << c.where;
}

/// Behind air of that extinction: the margin that studies have, put together from the pieces of ttp.h.
AcquisitionRange range_of(const std::vector<double>& x, double most_m = 1e8) {
  const auto s = sensitivity_of<double>(x);
  const SensitivityCourse course = sensitivity_course(s, 100.0);
  const double needed = x[10] * ratio_for_probability(static_cast<Psychometric>(static_cast<int>(x[12])), x[11]);
  const auto margin = [&](double range_m) {
    const AxisTtp<double> ttp = axis_ttp(course, s, x[8] * std::exp(-1e-3 * x[9] * range_m));
    return std::log(cycles_on_target(ttp_of(ttp, ttp), x[7], range_m) / needed);
  };
  return longest_range(margin, 1e-6 * x[7], most_m, 1e3);
}

const std::vector<double> kTask{2.0, 34.26, 15.0, 10.0, 1.0, 1.0, 4.0, 3.1, 0.2, 0.2, 13.0, 0.7, 0.0};
std::vector<double> with(std::size_t which, double value) {
  std::vector<double> x = kTask;
  x[which] = value;
  return x;
}

TEST(TtpRange, against_40_digits) {
  for (const auto& c : performance_cases("ttp_range")) {
    const AcquisitionRange r = range_of(c.x);
    EXPECT_EQ(r.reached, Reached::at_range);
    EXPECT_NEAR(r.range_m, c.value, 1e-9 * c.value) << c.where;
  }
}

TEST(TtpRange, goes_the_right_way) {
  const auto range = [&](std::size_t which, double factor) {
    return range_of(with(which, factor * kTask[which])).range_m;
  };
  const double here = range(6, 1.0);
  EXPECT_GT(range(6, 1.2), here);   // a sharper system
  EXPECT_GT(range(7, 1.2), here);   // a larger target
  EXPECT_GT(range(8, 1.2), here);   // of more contrast
  EXPECT_LT(range(5, 1.2), here);   // more noise
  EXPECT_LT(range(9, 1.2), here);   // more haze
  EXPECT_LT(range(10, 1.2), here);  // a harder task
  EXPECT_LT(range(11, 1.2), here);  // done more surely
  EXPECT_LT(range(9, 50.0), here);
  EXPECT_GT(range(9, 50.0), 0.0);
}

TEST(TtpRange, outcomes) {
  for (const AcquisitionRange& none : {range_of(with(8, 0.0)), range_of(with(11, 1.0))}) {
    EXPECT_EQ(none.reached, Reached::never);
    EXPECT_EQ(none.range_m, 0.0);
  }
  const double here = range_of(kTask).range_m;
  EXPECT_EQ(range_of(kTask, 0.9 * here).reached, Reached::beyond);
  EXPECT_EQ(range_of(kTask, 0.9 * here).range_m, 0.9 * here);
  EXPECT_EQ(range_of(kTask, 1.1 * here).reached, Reached::at_range);
}

// Fog in which everything ends within a centimetre: still a root, no loop without end.
TEST(TtpRange, stiff_extinction) {
  std::vector<double> x = with(9, 1e6);
  x[11] = 0.5;
  const AcquisitionRange r = range_of(x);
  EXPECT_EQ(r.reached, Reached::at_range);
  EXPECT_GT(r.range_m, 0.0);
  EXPECT_LT(r.range_m, 0.01);
}

}  // namespace
}  // namespace radiometry
