// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "radiometry/chain/sensor_budget.h"
#include "tests/expect_error.h"
#include "tests/radiometry/statistics.h"
#include "tests/radiometry/thermal_cases.h"

// The two-point correction of a thermal detector, from flat frames of two blackbodies, and what a user measures from
// frames of blackbodies (radiometry/from_nvtherm.md).

namespace radiometry {
namespace {

using test::by_netd;
using test::by_physics;
using test::lwir_system;
using test::make_chain;
using test::sensor_of;

constexpr double kCold_k = 283.15, kHot_k = 313.15;

Sensor corrected(const ThermalSettings& thermal, int frames) {
  Sensor sensor = sensor_of(thermal);
  sensor.settings.thermal->shutter_k = 293.0;
  sensor.settings.optics = OpticsSettings{.stop_temperature_k = 293.0};
  sensor.settings.adc = AdcSettings{.bits = 16, .electrons_per_count = 20e-9, .offset_counts = 30000.0};
  sensor.settings.correction = CorrectionSettings{.frames = frames, .cold_k = kCold_k, .hot_k = kHot_k};
  return sensor;
}

class Blackbody {
 public:
  Blackbody(const Sensor& sensor, std::int64_t size)
      : sensor_(sensor), size_(size), chain_(make_chain(lwir_system(), sensor, size, size, 17.0)) {}

  mtf::Image frame(double temperature_k, std::uint32_t number, OutputStage stage) const {
    mtf::Image scene = test::flat(size_, size_, static_cast<float>(temperature_k));
    radiance_of_temperature(scene.view(), scene_band(sensor_.curves));
    return chain_.run(std::move(scene), number, stage).image;
  }

 private:
  Sensor sensor_;
  std::int64_t size_;
  Chain chain_;
};

std::map<std::string, double> rows_of(const Sensor& sensor, double temperature_k) {
  std::map<std::string, double> values;
  for (const BudgetRow& row : budget_rows(lwir_system(), sensor, budget_of(lwir_system(), sensor, temperature_k)))
    values[row.name] = row.value;
  return values;
}

TEST(ThermalCorrection, takes_away_what_differs_from_pixel_to_pixel) {
  Sensor sensor = corrected(by_netd(), 1);
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 0.05, .dsnu_e = 2e-6};
  sensor.settings.vignetting = Vignetting{.cos4 = false, .a2 = -0.2};
  const Blackbody camera(sensor, 32);
  for (const double temperature_k : {270.0, 283.15, 300.0, 320.0}) {
    const auto spread = [&](OutputStage stage) {
      const mtf::Image image = camera.frame(temperature_k, 0, stage);
      return std::sqrt(test::moments(test::samples(image)).variance);
    };
    EXPECT_GT(spread(OutputStage::dn), 50.0);
    EXPECT_LT(spread(OutputStage::display), 1.0);  // the rounding of flat frames and of this one
  }
  EXPECT_EQ(budget_of(lwir_system(), sensor, 300.0).prnu_e, 0.0);
  EXPECT_EQ(budget_of(lwir_system(), sensor, 300.0).dsnu_e, 0.0);
}

/// The means of n flat frames leave temporal x sqrt(((1 - w)^2 + w^2)/n), w the place between the two blackbodies.
TEST(ThermalCorrection, leaves_the_noise_of_its_flat_frames) {
  Sensor sensor = corrected(by_netd(), 2);
  sensor.settings.noise = NoiseSettings{.seed = 8};
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 0.02, .dsnu_e = 1e-6};
  const auto watts = [](double temperature_k) { return band_radiance(Flux::watts, 8.0, 14.0, temperature_k); };
  const auto rows = rows_of(sensor, 300.0);
  const double w = (watts(300.0) - watts(kCold_k)) / (watts(kHot_k) - watts(kCold_k));
  const double expected = rows.at("temporal") * std::sqrt(((1.0 - w) * (1.0 - w) + w * w) / 2.0);
  EXPECT_NEAR(rows.at("correction") / expected, 1.0, 1e-12);
  EXPECT_NEAR(rows.at("spatial") / expected, 1.0, 1e-12);
  EXPECT_EQ(rows.at("prnu"), 0.0);
  // What two frames share: a standard error of 1 % of the rms with 65536 pixels.
  const Blackbody camera(sensor, 256);
  const mtf::Image a = camera.frame(300.0, 4, OutputStage::display), b = camera.frame(300.0, 5, OutputStage::display);
  const auto shared = [](const mtf::Image& one, const mtf::Image& other) {
    const double n = static_cast<double>(one.size());
    double product = 0.0, sum_a = 0.0, sum_b = 0.0;
    for (std::int64_t i = 0; i < one.size(); ++i) {
      const auto x = static_cast<double>(one.data()[i]), y = static_cast<double>(other.data()[i]);
      product += x * y, sum_a += x, sum_b += y;
    }
    return product / n - sum_a / n * (sum_b / n);
  };
  EXPECT_NEAR(20e-9 * std::sqrt(shared(a, b)) / rows.at("correction"), 1.0, 0.04);
  // With 1/f noise the mean of the flat frames keeps more of it than one over their number.
  ThermalSettings slow = by_physics();
  slow.corner_hz = 20e3;
  slow.lowest_hz = 0.01;
  Sensor pink = corrected(slow, 8);
  pink.settings.adc->electrons_per_count = 0.2e-6;
  pink.settings.frame = FrameSettings{.frame_time_s = 20e-3};
  pink.settings.noise = NoiseSettings{.seed = 8};
  const auto terms = rows_of(pink, 300.0);
  EXPECT_GT(terms.at("correction"), 1.2 * terms.at("temporal") * std::sqrt(((1.0 - w) * (1.0 - w) + w * w) / 8.0));
  const Blackbody flickering(pink, 256);
  const mtf::Image c = flickering.frame(300.0, 1000000, OutputStage::display),
                   d = flickering.frame(300.0, 2000000, OutputStage::display);
  EXPECT_NEAR(0.2e-6 * std::sqrt(shared(c, d)) / terms.at("correction"), 1.0, 0.06);
}

TEST(ThermalCorrection, what_cannot_be_is_refused) {
  Sensor sensor = corrected(by_netd(), 2);
  sensor.settings.correction->cold_k = kHot_k;
  expect_refused({"[correction]", "two blackbodies", "cold = "}, [&] { require_consistent(lwir_system(), sensor); });
  sensor.settings.correction->cold_k = kCold_k;
  sensor.settings.adc->bits = 8;
  sensor.settings.adc->offset_counts = 0.0;
  expect_refused({"[correction]", "cold = 283.15 K", "saturated", "raise adc.offset or correction.cold"},
                 [&] { Blackbody(sensor, 16).frame(300.0, 0, OutputStage::display); });
  sensor.settings.correction->cold_k = kHot_k - 0.1;
  sensor.settings.adc->offset_counts = 255.0;
  expect_refused({"is saturated", "or lower detector.counts_per_kelvin, adc.offset or correction.hot"},
                 [&] { Blackbody(sensor, 16).frame(300.0, 0, OutputStage::display); });
}

TEST(ThermalRange, the_scenes_that_the_converter_takes) {
  Sensor sensor = corrected(by_netd(), 1);
  sensor.settings.correction.reset();
  sensor.settings.adc = AdcSettings{.bits = 8, .electrons_per_count = 1e-6, .offset_counts = 100.0};
  const auto rows = rows_of(sensor, 293.0);
  const auto volts = [&](double temperature_k) {
    return static_cast<double>(Blackbody(sensor, 16).frame(temperature_k, 0, OutputStage::volts).at(3, 3));
  };
  EXPECT_NEAR(volts(rows.at("hottest_scene")), (255.5 - 100.0) * 1e-6, 1e-9);
  EXPECT_NEAR(volts(rows.at("coldest_scene")), (-0.5 - 100.0) * 1e-6, 1e-9);
  sensor.settings.adc->offset_counts = 2000.0;
  EXPECT_TRUE(std::isnan(rows_of(sensor, 293.0).at("coldest_scene")));
  sensor.settings.adc->offset_counts = 100.0, sensor.settings.adc->electrons_per_count = 1e9;
  for (const BudgetRow& row : budget_rows(lwir_system(), sensor, budget_of(lwir_system(), sensor, 293.0))) {
    if (row.name != "hottest_scene") continue;
    EXPECT_TRUE(std::isnan(row.value));
    expect_says(row.refused, {"no scene"});
  }
}

TEST(ThermalNotes, say_what_of_a_budget_does_not_hold) {
  ThermalSettings thermal = by_physics();
  EXPECT_FALSE(says(budget_notes(corrected(thermal, 2), {}), "detector.corner"));
  thermal.corner_hz = 1e3;
  thermal.lowest_hz = 0.01;
  EXPECT_FALSE(says(budget_notes(sensor_of(thermal), {}), "detector.corner"));
  EXPECT_TRUE(says(budget_notes(corrected(thermal, 2), {}), "detector.corner: the spatial"));
  thermal = by_netd();
  EXPECT_FALSE(says(budget_notes(corrected(thermal, 2), {}), "volts"));
  thermal.responsivity_v_w.reset();
  thermal.counts_per_k = 30.0;
  EXPECT_TRUE(says(budget_notes(corrected(thermal, 2), {}), "volts and V/W"));
}

/// What a user does with 20 frames each of a blackbody at 10, 20 and 30 degC: the steps of from_nvtherm.md.
TEST(ThermalRecipe, responsivity_and_netd_from_frames_of_a_blackbody) {
  constexpr int kFrames = 20, kSize = 96;
  constexpr std::array kTemperatures_k{283.15, 293.15, 303.15};
  ThermalSettings thermal = by_netd();
  thermal.netd_of = NetdOf::camera;
  thermal.netd_temperature_k = 293.15;
  Sensor sensor = sensor_of(thermal);
  sensor.settings.noise = NoiseSettings{.seed = 3};
  sensor.settings.optics = OpticsSettings{.transmission = {0.9}};
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 0.03, .dsnu_e = 3e-6};
  constexpr double kVoltsOfACount = 0.2e-6;
  sensor.settings.adc = AdcSettings{.bits = 16, .electrons_per_count = kVoltsOfACount};
  const Blackbody camera(sensor, kSize);

  std::vector<std::vector<double>> mean(3, std::vector<double>(kSize * kSize, 0.0));
  double squares = 0.0;  // of the counts of each pixel about their mean over the frames
  std::uint32_t number = 0;
  for (std::size_t t = 0; t < 3; ++t) {
    std::vector<mtf::Image> frames;
    for (int n = 0; n < kFrames; ++n) frames.push_back(camera.frame(kTemperatures_k[t], number++, OutputStage::dn));
    for (std::size_t i = 0; i < mean[t].size(); ++i) {
      for (const mtf::Image& frame : frames) mean[t][i] += static_cast<double>(frame.data()[i]) / kFrames;
      if (t != 1) continue;  // the noise at 20 degC
      for (const mtf::Image& frame : frames) {
        const double deviation = static_cast<double>(frame.data()[i]) - mean[t][i];
        squares += deviation * deviation / (kFrames - 1);
      }
    }
  }
  // Least squares over equal steps: the slope is that between the outer two.
  std::vector<double> slopes;
  for (std::size_t i = 0; i < mean[0].size(); ++i) slopes.push_back((mean[2][i] - mean[0][i]) / 20.0);
  std::nth_element(slopes.begin(), slopes.begin() + kSize * kSize / 2, slopes.end());
  const double s = slopes[kSize * kSize / 2], n = std::sqrt(squares / (kSize * kSize));

  // NETD at the camera's own f-number and transmission: 50 mK/0.9, within 1 %.
  EXPECT_NEAR(n / s, 0.05 / 0.9, 0.01 * 0.05 / 0.9);
  // The same camera by what was measured, with a responsivity of 1 at first.
  thermal.netd_k = n / s;
  thermal.netd_transmission = 0.9;
  thermal.responsivity_v_w = 1.0;
  Sensor measured = sensor_of(thermal);
  measured.settings.optics = sensor.settings.optics;
  const double volts_per_k = budget_of(lwir_system(), measured, 293.15).signal_per_k;
  EXPECT_NEAR(kVoltsOfACount * s / volts_per_k, 1e5, 0.005 * 1e5);
  // In counts, where nobody knows the volts of a count.
  thermal.responsivity_v_w.reset();
  thermal.counts_per_k = s;
  measured = sensor_of(thermal);
  measured.settings.optics = sensor.settings.optics;
  measured.settings.adc = AdcSettings{.bits = 16, .electrons_per_count = 1e-6};
  measured.settings.noise = NoiseSettings{.seed = 4};
  const Blackbody again(measured, kSize);
  const auto average = [&](double temperature_k) {
    return test::moments(test::samples(again.frame(temperature_k, 0, OutputStage::dn))).mean;
  };
  EXPECT_NEAR((average(303.15) - average(283.15)) / 20.0 / s, 1.0, 0.005);
  EXPECT_NEAR(budget_of(lwir_system(), measured, 293.15).netd_k, n / s, 1e-12);
}

// A live view keeps the correction of a lens without vignetting when the lens gets one. The image is then uniform, as
// behind a grey filter of the mean of the vignetting, and the pixels see so much more of the housing around the lens.
TEST(ThermalCorrection, a_kept_shading_that_is_none_is_a_uniform_one) {
  constexpr std::int64_t kSize = 24;
  const mtf::System<double> system = lwir_system();
  mtf::PlanOptions options;
  options.separate_readout = true;
  const mtf::SensorPlan plan = mtf::compile_sensor(system, {kSize, kSize, 17.0, 17.0}, options);
  Sensor plain = corrected(by_netd(), 1);
  plain.settings.optics->stop_temperature_k = 310.0;  // apart from the shutter's 293 K
  Sensor vignetted = plain;
  vignetted.settings.vignetting = Vignetting{.cos4 = false, .a2 = -0.4};
  mtf::Image factors(kSize, kSize);
  vignetting_map(factors.view(), *vignetted.settings.vignetting,
                 {.columns = kSize, .rows = kSize, .step_x_um = 17.0, .step_y_um = 17.0}, 18.0);
  const double mean = test::moments(test::samples(factors)).mean;
  Sensor uniform = plain;
  uniform.settings.vignetting = Vignetting{.cos4 = false};
  uniform.vignetting = std::make_shared<const mtf::Image>(test::flat(kSize, kSize, static_cast<float>(mean)));

  const Chain before(plan, system, plain, {}, 1);
  const auto volts = [&](const Chain& chain) {
    mtf::Image scene = test::flat(kSize, kSize, 280.0F);
    radiance_of_temperature(scene.view(), scene_band(plain.curves));
    return test::moments(test::samples(chain.run(std::move(scene), 0, OutputStage::volts).image));
  };
  const auto kept = volts(Chain(plan, system, vignetted, {}, 1, &before, true)),
             expected = volts(Chain(plan, system, uniform, {}, 1)), without = volts(before);
  // The signal is a small difference of light and glow in floats, a few per cent of each.
  EXPECT_NEAR(kept.mean, expected.mean, 1e-5 * std::abs(expected.mean));
  EXPECT_LE(std::sqrt(kept.variance), 1e-5 * std::abs(expected.mean));
  EXPECT_GT(std::abs(kept.mean - without.mean), 0.02 * std::abs(expected.mean));
}

}  // namespace
}  // namespace radiometry
