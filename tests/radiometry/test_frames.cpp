// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/light/blackbody.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/noise_3d.h"
#include "tests/radiometry/frames.h"
#include "tests/radiometry/statistics.h"

// Frames made step by step against the budget in closed form: two routes to the same numbers.

namespace radiometry {
namespace {

using test::flat;
using test::kMostSigmas;
using test::samples;

struct Sensor {
  Camera<double> camera{.f_number = 2.5, .transmission = 0.85};
  Pixel<double> pixel{.width_um = 14.6,
                      .height_um = 14.6,
                      .quantum_efficiency = 0.75,
                      .integration_s = 2e-3,
                      .dark_e_s = 5e6,
                      .full_well_e = 7e6};
  NoiseTerms<double> noise{.read_e = 600.0, .step_e = 900.0, .prnu = 2e-3, .dsnu_e = 1500.0};
  Adc adc{.electrons_per_count = 900.0, .offset_counts = 100.0, .bits = 14};

  Budget<double> budget(double temperature_k) const {
    const Signal<double> s = signal(camera, pixel, {.scene = band_radiance(Flux::photons, 3.0, 5.0, temperature_k)});
    const double slope = band_derivative(Flux::photons, 3.0, 5.0, temperature_k);
    return make_budget(pixel, s, noise, electrons_per_radiance(camera, pixel) * slope);
  }

  /// Counts of a flat scene, in electrons again.
  mtf::Image frame(double temperature_k, std::uint32_t number, bool spatial) const {
    const Signal<double> s = budget(temperature_k).signal;
    mtf::Image image = flat(320, 256, static_cast<float>(s.total_e() - s.dark_e));
    if (spatial) {
      mtf::Image map(320, 256);
      responsivity_map(map.view(), {noise.prnu}, 4);
      multiply_by(image.view(), map.view());
    }
    for (float& v : std::span(image.data(), samples(image).size())) v += static_cast<float>(s.dark_e);
    shot_noise(image.view(), {4, number});
    if (spatial) {
      mtf::Image map(320, 256);
      offset_map(map.view(), noise.dsnu_e, 4);
      add_map(image.view(), map.view());
    }
    fill_well(image.view(), pixel.full_well_e);
    add_gaussian(image.view(), noise.read_e, {4, number}, Stream::read);
    digitise(image.view(), adc);
    for (float& v : std::span(image.data(), samples(image).size()))
      v = (v - static_cast<float>(adc.offset_counts)) * static_cast<float>(adc.electrons_per_count);
    return image;
  }
};

TEST(Frames, mean_and_variance_are_those_of_the_budget) {
  const Sensor sensor;
  for (const double t : {250.0, 300.0, 330.0}) {
    const Budget<double> b = sensor.budget(t);
    const mtf::Image image = sensor.frame(t, 0, false);
    const auto m = test::moments(samples(image));
    const double n = static_cast<double>(image.size());
    EXPECT_LT(std::abs(m.mean - b.signal.total_e()) / b.temporal_e * std::sqrt(n), kMostSigmas) << t;
    EXPECT_LT(std::abs(m.variance / (b.temporal_e * b.temporal_e) - 1.0) * std::sqrt(n / 2.0), kMostSigmas) << t;
  }
}

TEST(Frames, netd_measured_on_frames_is_that_of_the_budget) {
  const Sensor sensor;
  const double step_k = 1.0;
  const mtf::Image cold = sensor.frame(299.5, 0, false), warm = sensor.frame(300.5, 1, false);
  const auto a = test::moments(samples(cold)), b = test::moments(samples(warm));
  const double netd_k = std::sqrt(0.5 * (a.variance + b.variance)) / ((b.mean - a.mean) / step_k);
  // Noise to 1/sqrt(4 n), the difference of the means to sqrt(2/n) NETD; the curvature of the signal is below both.
  const double n = static_cast<double>(cold.size()), expected = sensor.budget(300.0).netd_k;
  const double relative = std::sqrt(0.25 / n + 2.0 / n * expected * expected) + 1e-4;
  EXPECT_NEAR(netd_k, expected, kMostSigmas * relative * expected);
}

TEST(Frames, spatial_and_temporal_noise_come_apart_in_three_dimensions) {
  const Sensor sensor;
  Noise3dEstimator estimator(320, 256);
  for (std::uint32_t number = 0; number < 12; ++number) estimator.add(sensor.frame(300.0, number, true).view());
  const Noise3d got = estimator.estimate();
  const Budget<double> b = sensor.budget(300.0);
  EXPECT_NEAR(got.tvh, b.temporal_e, 0.005 * b.temporal_e);
  EXPECT_NEAR(got.vh, b.spatial_e, 0.015 * b.spatial_e);
  // Of 256 rows and more: 4.5 sqrt(2 / 255) / 256 of the variance may be taken for a component that is not there.
  for (const double other : {got.t, got.tv, got.th, got.v, got.h})
    EXPECT_LT(other, 0.04 * std::hypot(b.temporal_e, b.spatial_e));
}

// One scene of 1 K to 6000 K, exposures of 1 ns to 1000 s, wells of 1 to 1e12 electrons, 1 to 32 bits: with the same
// random numbers a hotter pixel never has the smaller count, and everything is finite and within the range.
TEST(Frames, extremes_are_finite_monotone_and_saturate) {
  constexpr int kTemperatures = 60;
  for (const double time : {1e-9, 1e-3, 1e3})
    for (const double well : {1.0, 7e6, 1e12})
      for (const int bits : {1, 8, 14, 32}) {
        Sensor sensor;
        sensor.pixel.integration_s = time;
        sensor.pixel.full_well_e = well;
        sensor.pixel.dark_e_s = 0.0;
        const Adc adc = adc_for_well(well, bits);
        mtf::Image last = flat(64, 1, 0.0F);
        for (int i = 0; i < kTemperatures; ++i) {
          const double t = std::pow(6000.0, i / (kTemperatures - 1.0));
          mtf::Image image = flat(64, 1, static_cast<float>(sensor.budget(t).signal.total_e()));
          shot_noise(image.view(), {8, 0});
          fill_well(image.view(), well);
          add_gaussian(image.view(), 0.1 * well, {8, 0}, Stream::read);
          digitise(image.view(), adc);
          for (std::int64_t x = 0; x < 64; ++x) {
            ASSERT_TRUE(image.at(x, 0) >= last.at(x, 0) || i == 0) << t << " " << time << " " << well << " " << bits;
            ASSERT_LE(image.at(x, 0), static_cast<float>(adc.most_counts()));
          }
          last = std::move(image);
        }
      }
}

TEST(Frames, radiance_from_1e_12_to_1e12) {
  const Sensor sensor;
  for (double watts = 1e-12; watts < 2e12; watts *= 10.0) {
    const double electrons = electrons_per_radiance(sensor.camera, sensor.pixel) * watts * 4.0 / kPhotonEnergy_j_um;
    mtf::Image image = flat(256, 16, static_cast<float>(electrons));
    shot_noise(image.view(), {2, 0});
    const auto m = test::moments(samples(image));
    const auto mean = static_cast<double>(static_cast<float>(electrons));
    EXPECT_LE(std::abs(m.mean - mean), kMostSigmas * std::sqrt(mean / 4096.0) + 6e-8 * mean) << watts;
  }
}

}  // namespace
}  // namespace radiometry
