// SPDX-License-Identifier: Apache-2.0

// The budget against frames of the chain where the signal is not a plain sum of electrons: a response that bends, stray
// light, vignetting, a converter that ends before the well, a readout that filters.

#include <gtest/gtest.h>

#include <cmath>

#include "radiometry/chain/sensor_budget.h"
#include "radiometry/performance/target_at_range.h"
#include "radiometry/stages/optics/vignetting.h"
#include "tests/expect_error.h"
#include "tests/radiometry/flat_scenes.h"
#include "tests/radiometry/thermal_cases.h"

namespace radiometry {
namespace {

using test::flat_scenes;
using test::make_chain;
using test::mwir_system;
using test::noisy_sensor;

/// Without noise, patterns and rounding.
Sensor quiet(Sensor sensor) {
  sensor.settings.noise.reset();
  sensor.settings.nonuniformity.reset();
  sensor.settings.adc.reset();
  return sensor;
}

float weighted_light(const Sensor& sensor, double temperature_k) {
  const SpectralNumbers<double> spectral = spectral_numbers(sensor, sensor.path, temperature_k);
  return static_cast<float>(spectral.radiances.scene + spectral.radiances.path);
}

mtf::Image electrons_of(const Sensor& sensor, const mtf::System<double>& system, const mtf::Image& scene) {
  return make_chain(system, sensor, scene.width(), scene.height(), system.frame.pitch_x_um)
      .run(scene.clone(), 0, last_output_stage(system, sensor))
      .image;
}

bool says(const std::vector<std::string>& notes, const std::string& part) {
  return std::ranges::any_of(notes, [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

// The NETD of frames: their noise over what a kelvin of the scene changes in them. 16384 pixels in 40 frames know the
// noise to 0.1 %; the bow of the response over the shot noise, and over the kelvin, is of the same size.
TEST(BudgetOfFrames, noise_behind_a_bent_response_counts_by_its_slope) {
  for (const double fill : {0.3, 0.85}) {
    Sensor sensor = noisy_sensor();
    sensor.settings.detector->read_e = 3000.0;
    sensor.settings.detector->dark_e_s = 2e8;
    sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 5e-4, .dsnu_e = 3000.0};
    sensor.settings.noise = NoiseSettings{.seed = 5};
    const double all_e = budget_of(mwir_system(), sensor, 300.0).signal.total_e(), well_e = all_e / fill;
    sensor.settings.detector->full_well_e = well_e;
    sensor.settings.nonlinearity = Nonlinearity{.a2 = -0.45};
    const Budget<double> budget = budget_of(mwir_system(), sensor, 300.0);
    const double slope = 1.0 - 0.9 * fill;
    EXPECT_NEAR(budget.slope, slope, 1e-12);
    EXPECT_NEAR(budget.read_e, 3000.0 / slope, 1e-9);
    const Sensor still = quiet(sensor);
    const auto mean = [&](double temperature_k) {
      return static_cast<double>(
          electrons_of(still, mwir_system(), test::flat(4, 4, weighted_light(still, temperature_k))).at(1, 1));
    };
    const double per_k = 2.0 * (mean(300.25) - mean(299.75));
    EXPECT_NEAR(per_k / (slope * budget.signal_per_k), 1.0, 2e-3);
    const test::FlatScenes frames = flat_scenes(sensor, 300.0);
    EXPECT_NEAR(frames.temporal_e / per_k / budget.netd_k, 1.0, 0.01) << fill;
    EXPECT_NEAR(frames.pattern_e / per_k / budget.spatial_netd_k, 1.0, 0.03) << fill;
    EXPECT_TRUE(says(budget_notes(sensor, budget), "[nonlinearity]"));
    // Without light the slope is that of the dark charge.
    const double dark_slope = 1.0 - 0.9 * 4e5 / well_e;
    EXPECT_NEAR(flat_scenes(sensor, 20.0).temporal_e / (dark_slope * budget.floor_e), 1.0, 0.01) << fill;
    // A target that is no small difference: (R(e + c) - R(e)) / R'(e), with R by its polynomial.
    const auto response = [&](double e) { return e * (1.0 - 0.45 * e / well_e); };
    const double more_e = 0.1 * well_e;
    EXPECT_NEAR(seen_difference(budget, more_e), (response(all_e + more_e) - response(all_e)) / slope, 1e-9 * more_e);
  }
}

// 12 bits of 60 e- end at 4095.5 counts, of which noise without light has 8.
TEST(BudgetOfFrames, the_end_of_the_converter_ends_the_dynamic_range_and_holds_targets) {
  Sensor sensor = test::mwir_sensor();
  sensor.settings.detector->full_well_e = 2e6;
  sensor.settings.detector->read_e = 500.0;
  sensor.settings.adc = AdcSettings{.bits = 12, .electrons_per_count = 60.0};
  mtf::System<double> system = mwir_system();
  system.frame.integration_time_s = 2e-4;
  Budget<double> budget = budget_of(system, sensor, 300.0);
  const double floor_e = std::hypot(500.0, 60.0 / std::sqrt(12.0)), end_e = 4095.5 * 60.0;
  EXPECT_NEAR(budget.dynamic_range, end_e / floor_e, 1e-9);
  const double room_e = end_e - budget.signal.total_e();
  EXPECT_FALSE(target_saturation(budget, 0.98 * room_e).saturated());
  EXPECT_TRUE(target_saturation(budget, 1.02 * room_e).saturated());
  EXPECT_EQ(target_saturation(budget, 1.02 * room_e).end, RangeEnd::most_count);
  sensor.settings.adc->electrons_per_count = 600.0;  // beyond the well
  budget = budget_of(system, sensor, 300.0);
  EXPECT_NEAR(budget.dynamic_range, 2e6 / std::hypot(500.0, 600.0 / std::sqrt(12.0)), 1e-6);
  EXPECT_EQ(target_saturation(budget, 2e6).end, RangeEnd::full_well);
  // With a bent response the end is the charge whose response it is.
  sensor.settings.adc->electrons_per_count = 60.0;
  sensor.settings.nonlinearity = Nonlinearity{.a2 = -0.2};
  budget = budget_of(system, sensor, 300.0);
  const double v = end_e / 2e6, charge_e = 2e6 * 2.0 * v / (1.0 + std::sqrt(1.0 - 0.8 * v));
  EXPECT_NEAR(budget.dynamic_range * budget.floor_e / charge_e, 1.0, 1e-12);
}

}  // namespace
}  // namespace radiometry
