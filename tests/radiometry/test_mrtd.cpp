// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/mrtd.h"

#include <gtest/gtest.h>

#include "radiometry/performance/acquisition.h"
#include "tests/expect_error.h"
#include "tests/radiometry/performance_cases.h"

namespace radiometry {
namespace {

using test::gaussian_mtf;
using test::performance_cases;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
const auto kFlat = [](double) { return 1.0; };

MrtdInput<double> plain() {
  return {.tvh_k = 0.05, .spacing_x_mrad = 0.1, .spacing_y_mrad = 0.1, .frame_rate_hz = 30.0};
}

TEST(AveragedBandwidth, against_40_digits) {
  for (const auto& c : performance_cases("averaged")) {
    const double value = averaged_bandwidth(c.x[0], c.x[1], [&](double f) { return gaussian_mtf(f, c.x[2]); });
    EXPECT_NEAR(value, c.value, 1e-9 * c.value) << c.where;
  }
}

// Narrow windows leave 2 x band; wide ones 1/w, less the tail 1/(pi^2 w^2 band).
TEST(AveragedBandwidth, both_ends) {
  EXPECT_NEAR(averaged_bandwidth(1e-9, 5.0, kFlat), 10.0, 1e-14);
  for (const double w : {1e3, 1e6, 1e9})
    EXPECT_NEAR(averaged_bandwidth(w, 5.0, kFlat) * w, 1.0 - 1.0 / (mtf::kPi * mtf::kPi * w * 5.0), 1e-9);
}

// On both sides of 64 lobes, where the method changes, and through whole and half lobes.
TEST(AveragedBandwidth, is_one_curve) {
  const auto at = [](double lobes) { return averaged_bandwidth(lobes / 5.0, 5.0, kFlat) * lobes; };
  const double step = at(64.0 + 1e-9) - at(64.0 - 1e-9);
  EXPECT_NEAR(step, 0.0, 1e-9 * at(64.0));
}

TEST(Mrtd, against_40_digits) {
  for (const auto& c : performance_cases("mrtd")) {
    const std::vector<double>& x = c.x;
    const MrtdInput<double> in{.tvh_k = x[2],
                               .vh_k = x[3],
                               .th_k = x[4],
                               .tv_k = x[5],
                               .h_k = x[6],
                               .v_k = x[7],
                               .spacing_x_mrad = x[8],
                               .spacing_y_mrad = x[9],
                               .snr_threshold = x[10],
                               .eye_time_s = x[11],
                               .frame_rate_hz = x[12],
                               .bar_aspect = x[13]};
    const auto noise = [&](double f) { return gaussian_mtf(f, x[15]); };
    const double value = mrtd_k(
        in, x[0] == 0.0 ? mtf::Axis::x : mtf::Axis::y, x[1], [&](double f) { return gaussian_mtf(f, x[14]); }, noise,
        noise);
    EXPECT_NEAR(value, c.value, 1e-9 * c.value) << c.where;
  }
}

// Low frequencies: the eye averages over 1/(2 f s) x 7/(2 f s) samples and t_eye x rate frames, all of it white.
TEST(Mrtd, few_cycles_average_many_samples) {
  const double f = 1e-5, samples = 7.0 / (4.0 * f * f * 0.01);
  const double expected = mtf::kPi * mtf::kPi / 8.0 * 2.5 * 0.05 / std::sqrt(3.0 * samples);
  EXPECT_NEAR(mrtd_k(plain(), mtf::Axis::x, f, kFlat, kFlat, kFlat), expected, 2e-6 * expected);
}

TEST(Mrtd, limits) {
  EXPECT_EQ(mrtd_k(plain(), mtf::Axis::x, 0.0, kFlat, kFlat, kFlat), 0.0);
  EXPECT_EQ(mrtd_k(
                plain(), mtf::Axis::x, 1.0, [](double) { return 0.0; }, kFlat, kFlat),
            kInfinite);
  EXPECT_EQ(mrtd_k(
                plain(), mtf::Axis::x, 1.0, [](double) { return -0.1; }, kFlat, kFlat),
            kInfinite);
  MrtdInput<double> silent = plain();
  silent.tvh_k = 0.0;
  EXPECT_EQ(mrtd_k(silent, mtf::Axis::y, 1.0, kFlat, kFlat, kFlat), 0.0);
  // The eye cannot average over less than one frame.
  MrtdInput<double> slow = plain(), slower = plain();
  slow.frame_rate_hz = 5.0;
  slower.frame_rate_hz = 0.1;
  EXPECT_EQ(mrtd_k(slow, mtf::Axis::x, 1.0, kFlat, kFlat, kFlat),
            mrtd_k(slower, mtf::Axis::x, 1.0, kFlat, kFlat, kFlat));
}

// Noise of columns hides bars that alternate along x and no others; fixed noise is not averaged over frames.
TEST(Mrtd, components_hide_what_they_look_like) {
  const auto at = [](MrtdInput<double> in, mtf::Axis axis) { return mrtd_k(in, axis, 1.0, kFlat, kFlat, kFlat); };
  const double x = at(plain(), mtf::Axis::x), y = at(plain(), mtf::Axis::y);
  EXPECT_NEAR(x, y, 1e-15);
  MrtdInput<double> columns = plain(), rows = plain(), fixed = plain();
  columns.h_k = columns.th_k = 0.05;
  rows.v_k = rows.tv_k = 0.05;
  fixed.tvh_k = 0.0;
  fixed.vh_k = 0.05;
  EXPECT_GT(at(columns, mtf::Axis::x), 1.2 * x);
  EXPECT_EQ(at(columns, mtf::Axis::y), y);
  EXPECT_GT(at(rows, mtf::Axis::y), 1.2 * y);
  EXPECT_EQ(at(rows, mtf::Axis::x), x);
  EXPECT_NEAR(at(fixed, mtf::Axis::x), x * std::sqrt(3.0), 1e-14);  // 30 Hz x 0.1 s = 3 frames
}

TEST(Mrtd, rises_with_frequency) {
  double before = 0.0;
  for (double f = 0.01; f < 5.0; f *= 1.3) {
    const double now = mrtd_k(
        plain(), mtf::Axis::x, f, [](double g) { return gaussian_mtf(g, 2.0); }, kFlat, kFlat);
    EXPECT_GT(now, before);
    before = now;
  }
}

TEST(Mrtd, refuses_by_name) {
  expect_refused({"mrtd.tvh", "mrtd.spacing_x", "mrtd.frame_rate"}, [] {
    mrtd_k(MrtdInput<double>{.tvh_k = -1.0, .spacing_y_mrad = 0.1}, mtf::Axis::x, 1.0, kFlat, kFlat, kFlat);
  });
  expect_refused({"cycles/mrad"}, [] { mrtd_k(plain(), mtf::Axis::x, -1.0, kFlat, kFlat, kFlat); });
  expect_refused({"cycles/mrad"}, [] { mrtd_2d_k<double>(0.0, kFlat, kFlat); });
}

// Powers meet in closed form: A f_x^p = B f_y^q = M with f_x f_y = f^2.
TEST(Mrtd2d, of_two_powers) {
  for (const auto& [a, p, b, q] : {std::array{0.1, 1.0, 0.1, 1.0}, {0.1, 1.5, 3.0, 0.7}, {2.0, 4.0, 1e-3, 2.0}}) {
    const double f = 0.8, both = 1.0 / p + 1.0 / q;
    const double expected = std::pow(f * f * std::pow(a, 1.0 / p) * std::pow(b, 1.0 / q), 1.0 / both);
    const double value = mrtd_2d_k<double>(
        f, [&, a = a, p = p](double x) { return a * std::pow(x, p); },
        [&, b = b, q = q](double y) { return b * std::pow(y, q); });
    EXPECT_NEAR(value, expected, 1e-13 * expected);
  }
}

TEST(Mrtd2d, cutoffs_and_silence) {
  const auto cut_at = [](double end) { return [end](double f) { return f < end ? f / (1.0 - f / end) : kInfinite; }; };
  EXPECT_EQ(mrtd_2d_k<double>(3.0, cut_at(2.0), cut_at(4.0)), kInfinite);  // sqrt(2 x 4) = 2.83
  EXPECT_LT(mrtd_2d_k<double>(2.8, cut_at(2.0), cut_at(4.0)), kInfinite);
  EXPECT_NEAR(mrtd_2d_k<double>(1.0, cut_at(2.0), cut_at(2.0)), 2.0, 1e-13);
  const auto silent = [](double) { return 0.0; };
  EXPECT_EQ(mrtd_2d_k<double>(1.0, silent, silent), 0.0);
  // One axis sees nothing at all.
  EXPECT_EQ(mrtd_2d_k<double>(1.0, cut_at(2.0), [](double) { return kInfinite; }), kInfinite);
}

/// Bars of N cycles on a target of the size h behind air of that extinction.
template <class Mrtd>
AcquisitionRange range_of_bars(const Mrtd& mrtd, double size_m, double contrast_k, double extinction_per_km, double n) {
  const auto margin = [&](double range_m) {
    return std::log(contrast_k) - 1e-3 * extinction_per_km * range_m - std::log(mrtd(1e-3 * n * range_m / size_m));
  };
  return longest_range(margin, 1e-6 * size_m, 1e8, 1e3);
}

// MRTD = m exp(f/g): ln(dT/m) = (N/(1e3 h g) + beta/1e3) R.
TEST(RangeOfBars, exponential_mrtd) {
  for (const double beta : {0.0, 0.1, 3.0})
    for (const double n : {1.0, 3.0, 8.0}) {
      const AcquisitionRange r = range_of_bars([](double f) { return 0.02 * std::exp(f / 0.7); }, 2.3, 1.25, beta, n);
      const double expected = std::log(1.25 / 0.02) / (n / (1e3 * 2.3 * 0.7) + beta * 1e-3);
      EXPECT_EQ(r.reached, Reached::at_range);
      EXPECT_NEAR(r.range_m, expected, 1e-12 * expected);
    }
}

TEST(RangeOfBars, outcomes) {
  const auto mrtd = [](double f) { return 0.02 * std::exp(f / 0.7); };
  for (const double contrast : {0.0, 0.02 * (1.0 - 1e-3)}) {
    EXPECT_EQ(range_of_bars(mrtd, 2.3, contrast, 0.0, 3.0).reached, Reached::never);
    EXPECT_EQ(range_of_bars(mrtd, 2.3, contrast, 0.0, 3.0).range_m, 0.0);
  }
}

TEST(RangeOfBars, range_of_a_camera_rises_with_contrast_and_falls_with_the_task) {
  const auto h = [](double f) { return gaussian_mtf(f, 3.0); };
  const auto x = [&](double f) { return mrtd_k(plain(), mtf::Axis::x, f, h, kFlat, kFlat); };
  const auto y = [&](double f) { return mrtd_k(plain(), mtf::Axis::y, f, h, kFlat, kFlat); };
  const auto range = [&](double contrast, double n) {
    return range_of_bars([&](double f) { return mrtd_2d_k<double>(f, x, y); }, 2.3, contrast, 0.2, n).range_m;
  };
  EXPECT_GT(range(2.0, 3.0), range(1.0, 3.0));
  EXPECT_GT(range(2.0, 0.75), range(2.0, 3.0));
  EXPECT_GT(range(2.0, 3.0), range(2.0, 6.0));
}

}  // namespace
}  // namespace radiometry
