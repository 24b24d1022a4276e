// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "radiometry/stages/noise/fixed_pattern.h"
#include "tests/expect_error.h"
#include "tests/radiometry/flat_scenes.h"
#include "tests/radiometry/statistics.h"

namespace radiometry {
namespace {

using test::flat;
using test::flat_scenes;
using test::kMostSigmas;
using test::make_chain;
using test::moments;
using test::mwir_sensor;
using test::mwir_system;
using test::noisy_sensor;
using test::samples;

mtf::Image factors(double rms, std::uint64_t seed, std::int64_t width = 512, std::int64_t height = 512,
                   Origin origin = {}) {
  mtf::Image map(width, height);
  dark_current_map(map.view(), rms, seed, origin, 2);
  return map;
}

/// Dark frames without noise but for the pattern, so many electrons of dark current in 1 ms on the mean.
mtf::Image dark_frame(double rms, double mean_e, double exposure_ms, bool shot = false, std::uint32_t frame = 0,
                      std::int64_t size = 128) {
  Sensor sensor = mwir_sensor();
  sensor.settings.detector->dark_e_s = 1e3 * mean_e;
  sensor.settings.nonuniformity = NonuniformitySettings{.dcnu = rms};
  if (shot) sensor.settings.noise = NoiseSettings{};
  mtf::System<double> system = mwir_system();
  system.frame.integration_time_s = 1e-3 * exposure_ms;
  return make_chain(system, sensor, size, size, 15.0).run(flat(size, size, 0.0F), frame, OutputStage::electrons).image;
}

// A log-normal factor of mean 1 and standard deviation r: its logarithm is normal, of variance s^2 = ln(1 + r^2) and
// mean -s^2 / 2; the excess of its fourth moment, e^4s2 + 2 e^3s2 + 3 e^2s2 - 6, gives the sampling error of r^2.
TEST(DarkNonuniformity, factors_are_log_normal_of_mean_1) {
  for (const double rms : {0.1, 0.3, 1.0}) {
    const mtf::Image map = factors(rms, 3);
    const auto n = static_cast<double>(map.size());
    const test::Moments f = moments(samples(map));
    const double w = 1.0 + rms * rms;
    const double excess = std::pow(w, 4) + 2.0 * std::pow(w, 3) + 3.0 * w * w - 6.0;
    EXPECT_LT(std::abs(f.mean - 1.0) / (rms / std::sqrt(n)), kMostSigmas) << rms;
    EXPECT_LT(std::abs(f.variance / (rms * rms) - 1.0) / std::sqrt((excess + 2.0) / n), kMostSigmas) << rms;
    std::vector<double> logs;
    for (const float v : samples(map)) logs.push_back(std::log(static_cast<double>(v)));
    const test::Moments l = moments(std::span<const double>(logs));
    const double s2 = std::log(w);
    EXPECT_LT(std::abs(l.mean + 0.5 * s2) / std::sqrt(s2 / n), kMostSigmas) << rms;
    EXPECT_LT(std::abs(l.variance / s2 - 1.0) / std::sqrt(2.0 / n), kMostSigmas) << rms;
  }
  const mtf::Image even = factors(0.0, 3, 8, 8);
  for (const float v : samples(even)) EXPECT_EQ(v, 1.0F);
}

TEST(DarkNonuniformity, belongs_to_the_pixel_and_the_seed) {
  const mtf::Image whole = factors(0.3, 7, 40, 30), part = factors(0.3, 7, 11, 9, {5, 13});
  for (std::int64_t y = 0; y < 9; ++y)
    for (std::int64_t x = 0; x < 11; ++x) EXPECT_EQ(part.at(x, y), whole.at(x + 5, y + 13));
  const mtf::Image a = factors(0.3, 1), b = factors(0.3, 2);
  EXPECT_LT(std::abs(test::correlation_sigmas(samples(a), samples(b))), kMostSigmas);
  mtf::Image gains(512, 512), offsets(512, 512);
  responsivity_map(gains.view(), {0.1}, 1);
  offset_map(offsets.view(), 1.0, 1);
  EXPECT_LT(std::abs(test::correlation_sigmas(samples(a), samples(gains))), kMostSigmas);
  EXPECT_LT(std::abs(test::correlation_sigmas(samples(a), samples(offsets))), kMostSigmas);
  expect_refused({"-0.1 rms", "from 0 to 10"}, [] { factors(-0.1, 1, 2, 2); });
}

// The charge of a pixel is dark current x time x its factor: thrice the exposure is thrice the pattern, pixel by pixel,
// within the rounding of floats about the mean.
TEST(DarkNonuniformity, grows_with_the_exposure) {
  const mtf::Image once = dark_frame(0.25, 4000.0, 1.0), thrice = dark_frame(0.25, 4000.0, 3.0);
  const mtf::Image map = factors(0.25, 0, 128, 128);
  for (std::int64_t i = 0; i < once.size(); ++i) {
    const double f = static_cast<double>(map.data()[i]);
    ASSERT_NEAR(static_cast<double>(once.data()[i]), 4000.0 * f, 2e-3);
    ASSERT_NEAR(static_cast<double>(thrice.data()[i]), 12000.0 * f, 6e-3);
  }
}

// Electrons of shot noise alone: the variance of a pixel over the frames is its own mean, in the darkest eighth of the
// pixels as in the warmest. 2048 pixels x 60 frames know a variance to sqrt(2 / (2048 x 59)) = 0.4 %.
TEST(DarkNonuniformity, shot_noise_is_that_of_the_pixel) {
  constexpr int kFrames = 60;
  std::vector<double> sum(128 * 128, 0.0), squares(128 * 128, 0.0);
  for (std::uint32_t n = 0; n < kFrames; ++n) {
    const mtf::Image frame = dark_frame(0.5, 2000.0, 1.0, true, n);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double e = static_cast<double>(frame.data()[i]);
      sum[i] += e;
      squares[i] += e * e;
    }
  }
  const mtf::Image map = factors(0.5, 0, 128, 128);
  std::vector<std::size_t> order(sum.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::size_t i) { return map.data()[i]; });
  const std::size_t eighth = order.size() / 8;
  std::vector<double> means;
  for (const std::size_t first : {std::size_t{0}, order.size() - eighth}) {
    double mean = 0.0, variance = 0.0;
    for (std::size_t k = first; k < first + eighth; ++k) {
      const std::size_t i = order[k];
      mean += sum[i] / kFrames;
      variance += (squares[i] - sum[i] * sum[i] / kFrames) / (kFrames - 1);
    }
    EXPECT_NEAR(variance / mean, 1.0, 0.018) << first;
    means.push_back(mean);
  }
  EXPECT_GT(means[1], 4.0 * means[0]);  // e^(2 x 1.65 s), s = 0.47, of the mean factors of the outer eighths
}

// 16384 pixels know the rms of the log-normal to sqrt((excess + 2) / (4 x 16384)) = 0.9 % at 0.3, of the noise to
// better.
TEST(DarkNonuniformity, the_budget_counts_what_frames_have) {
  Sensor sensor = noisy_sensor();
  sensor.settings.noise = NoiseSettings{.seed = 3};
  for (const double exposure_s : {1e-3, 4e-3}) {
    sensor.settings.nonuniformity = NonuniformitySettings{.dsnu_e = 900.0, .dcnu = 0.3};
    mtf::System<double> system = mwir_system();
    system.frame.integration_time_s = exposure_s;
    const Budget<double> budget = budget_of(system, sensor, 290.0);
    EXPECT_NEAR(budget.dsnu_e, std::hypot(900.0, 0.3 * 5e6 * exposure_s), 1e-9 * budget.dsnu_e);
    EXPECT_NEAR(budget.spatial_e, budget.dsnu_e, 1e-9 * budget.dsnu_e);
    const test::FlatScenes seen = flat_scenes(sensor, 290.0, system);
    EXPECT_NEAR(seen.pattern_e / budget.spatial_e, 1.0, 0.03) << exposure_s;
    EXPECT_NEAR(seen.temporal_e / budget.temporal_e, 1.0, 0.01) << exposure_s;
    sensor.settings.nonuniformity->dcnu = 0.0;
    EXPECT_EQ(budget_of(system, sensor, 290.0).temporal_e, budget.temporal_e);
    EXPECT_EQ(budget_of(system, sensor, 290.0).dsnu_e, 900.0);
  }
}

// Before the well, unlike an offset: 5e5 e- of a well of 7e6 e-, 1.5e5 e- of spread.
TEST(DarkNonuniformity, fills_the_well) {
  Sensor sensor = noisy_sensor();
  sensor.settings.detector->dark_e_s = 2.5e8;
  sensor.settings.detector->full_well_e = budget_of(mwir_system(), sensor, 300.0).signal.total_e() + 4e5;
  sensor.settings.adc->electrons_per_count.reset();
  sensor.settings.nonuniformity = NonuniformitySettings{.dsnu_e = 1.5e5};
  EXPECT_LT(budget_of(mwir_system(), sensor, 300.0).saturation.held, 0.01);
  const double spread_e = 0.3 * 5e5;
  sensor.settings.nonuniformity = NonuniformitySettings{.dcnu = 0.3};
  const Saturation saturation = budget_of(mwir_system(), sensor, 300.0).saturation;
  EXPECT_EQ(saturation.end, RangeEnd::full_well);
  EXPECT_NEAR(saturation.sigmas, 4e5 / spread_e, 0.01 * saturation.sigmas);  // shot noise adds 0.01 %
}

// A log-normal has more warm pixels than a Gaussian of its rms. 5e5 e- on the mean and room for 2e6 e-, four times
// that: s = sqrt(ln 1.49) = 0.6315, Q((ln 4 + s^2 / 2) / s) = Q(2.511) = 6.0 permille.
TEST(DarkNonuniformity, the_budget_says_how_many_pixels_it_fills) {
  Sensor sensor = noisy_sensor();
  sensor.settings.detector->dark_e_s = 2.5e8;
  sensor.settings.detector->full_well_e = budget_of(mwir_system(), sensor, 300.0).signal.total_e() + 1.5e6;
  sensor.settings.adc->electrons_per_count.reset();
  const auto notes = [&](double dcnu) {
    sensor.settings.nonuniformity = NonuniformitySettings{.dcnu = dcnu};
    return budget_notes(sensor, budget_of(mwir_system(), sensor, 300.0));
  };
  EXPECT_TRUE(notes(0.3).empty());  // Q(4.87)
  ASSERT_EQ(notes(0.7).size(), 1U);
  EXPECT_NE(notes(0.7)[0].find("gives 0.602 % of the pixels"), std::string::npos) << notes(0.7)[0];
}

TEST(DarkNonuniformity, a_two_point_correction_removes_it) {
  Sensor sensor = noisy_sensor();
  sensor.settings.noise = NoiseSettings{.seed = 3};
  sensor.settings.nonuniformity = NonuniformitySettings{.dcnu = 0.3};
  sensor.settings.correction = CorrectionSettings{.low = 0.2, .high = 0.6, .frames = 16, .replace_bad = false};
  sensor.settings.detector->dark_e_s = 5e7;
  const Budget<double> budget = budget_of(mwir_system(), sensor, 300.0);
  EXPECT_EQ(budget.dsnu_e, 0.0);
  EXPECT_EQ(budget.spatial_e, budget.correction_e);
  EXPECT_NEAR(flat_scenes(sensor, 300.0).pattern_e / budget.spatial_e, 1.0, 0.03);
}

// The bow of the response turns the charge into a pattern again: R(e) = e (1 + a u), R' = 1 + 2 a u, u = e / well, so
// that q leaves q (R'(e) - (1 - w) R'(c) - w R'(h)), w = (R(e) - R(c)) / (R(h) - R(c)). To first order in q / well,
// here 0.4 % rms.
TEST(DarkNonuniformity, what_the_bow_of_the_response_leaves_of_it) {
  Sensor sensor = noisy_sensor();
  sensor.settings.noise = NoiseSettings{.seed = 3};
  sensor.settings.nonuniformity = NonuniformitySettings{.dcnu = 0.3};
  sensor.settings.correction = CorrectionSettings{.low = 0.1, .high = 0.8, .frames = 64, .replace_bad = false};
  sensor.settings.nonlinearity = Nonlinearity{.a2 = -0.15};
  sensor.settings.detector->dark_e_s = 5e7;
  sensor.settings.adc->bits = 16;
  sensor.settings.adc->electrons_per_count = 100.0;
  const double temperature_k = 302.0;
  const Budget<double> budget = budget_of(mwir_system(), sensor, temperature_k);
  const double u = budget.signal.total_e() / 7e6, c = 0.1, h = 0.8, a = -0.15;
  const auto response = [&](double x) { return x * (1.0 + a * x); };
  const double w = (response(u) - response(c)) / (response(h) - response(c));
  const double left = 2.0 * a * (u - (1.0 - w) * c - w * h);
  const double pattern_e = std::abs(0.3 * 1e5 * left);
  const double slope = 1.0 + 2.0 * a * u;
  EXPECT_NEAR(budget.dsnu_e * slope / pattern_e, 1.0, 1e-9);
  EXPECT_GT(budget.dsnu_e, budget.correction_e);
  EXPECT_NEAR(flat_scenes(sensor, temperature_k).pattern_e / (slope * budget.spatial_e), 1.0, 0.03);
}

TEST(DarkNonuniformity, words) {
  const auto words = [](const Sensor& sensor) {
    for (const ChainStage& stage : chain_stages(mwir_system(), sensor))
      if (stage.name == "dark nonuniformity") return stage.what;
    return std::string("no such stage");
  };
  Sensor sensor = noisy_sensor();
  EXPECT_EQ(words(sensor), "no dcnu in [nonuniformity]");
  sensor.settings.nonuniformity->dcnu = 0.3;
  EXPECT_EQ(words(sensor), "spread 3000 e- rms");
  sensor.settings.detector->dark_e_s = 0.0;
  EXPECT_EQ(words(sensor), "no dark_current in [detector]");
}

TEST(DarkNonuniformity, thermal_detectors_have_none) {
  const auto has = [](const auto& rows) {
    return std::ranges::find(rows, "dcnu", [](const auto& row) { return row.name; }) != rows.end();
  };
  for (const mtf::TableInfo& table : sensor_tables())
    if (table.name == "nonuniformity") {
      EXPECT_EQ(has(table.settings), !table.where);
      EXPECT_EQ(has(table.absent), table.where.has_value());
    }
}

}  // namespace
}  // namespace radiometry
