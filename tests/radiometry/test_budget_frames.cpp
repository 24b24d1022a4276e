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

// Electrons of a flat frame and of one pixel that is a little brighter, through the chain's own stray light. The mean
// follows the pixel by 1/4096.
TEST(BudgetOfFrames, stray_light_adds_electrons_and_takes_contrast) {
  Sensor sensor = quiet(noisy_sensor());
  sensor.settings.glare = VeilingGlare{.fraction = 0.1, .offset = 0.3};
  sensor.settings.ghost = Ghost{.fraction = 0.05};
  mtf::System<double> system = mwir_system();
  system.stages[0].clear();  // a pixel stays a pixel
  const Budget<double> budget = budget_of(system, sensor, 300.0);
  const float light = weighted_light(sensor, 300.0);
  mtf::Image scene = test::flat(64, 64, light);
  const double flat_e = static_cast<double>(electrons_of(sensor, system, scene).at(9, 20));
  EXPECT_NEAR(flat_e / budget.signal.total_e(), 1.0, 1e-6);
  const SpectralNumbers<double> spectral = spectral_numbers(sensor, sensor.path, 300.0);
  const double step_k = 0.1 * spectral.radiances.scene / spectral.per_k;
  scene.at(9, 20) = static_cast<float>(static_cast<double>(light) + step_k * spectral.per_k);
  const double seen_per_k = (static_cast<double>(electrons_of(sensor, system, scene).at(9, 20)) - flat_e) / step_k;
  EXPECT_NEAR(seen_per_k / budget.signal_per_k, 1.0, 3e-4);
  EXPECT_NEAR(budget.contrast_share, 0.9 * 0.95 / 1.3, 1e-15);
  EXPECT_TRUE(says(budget_notes(sensor, budget), "[veiling_glare] and [ghost]"));
}

// Each pixel of a frame against the budget of its place: numbers, a map, and a thermal camera whose shutter stands
// behind the cone that vignetting narrows.
TEST(BudgetOfFrames, a_place_has_the_light_that_vignetting_leaves_there) {
  const auto expect_places = [](const mtf::System<double>& system, const Sensor& sensor) {
    const mtf::Image frame = electrons_of(sensor, system, test::flat(64, 48, weighted_light(sensor, 305.0)));
    for (const auto& [x, y] : {std::pair{0, 0}, {63, 47}, {40, 3}, {32, 24}}) {
      const mtf::System<double> here = system.at(system.field_point(x + 0.5, y + 0.5));
      const Budget<double> budget = budget_of(here, sensor, 305.0), axis = budget_of(system, sensor, 305.0);
      EXPECT_NEAR(static_cast<double>(frame.at(x, y)) / budget.signal.total_e(), 1.0, 2e-6) << x << ", " << y;
      EXPECT_NEAR(budget.signal_per_k / axis.signal_per_k, budget.light_share, 1e-14);
      EXPECT_EQ(axis.light_share, 1.0);
      EXPECT_EQ(says(budget_notes(sensor, budget), "[vignetting]"), budget.light_share != 1.0) << x << ", " << y;
      EXPECT_FALSE(says(budget_notes(sensor, axis), "[vignetting]"));
    }
  };
  mtf::System<double> mwir = mwir_system();
  mwir.frame.columns = 64, mwir.frame.rows = 48;
  mwir.frame.focal_length_mm = 1.0;
  Sensor sensor = quiet(noisy_sensor());
  sensor.settings.vignetting = Vignetting{.a2 = -0.2, .a4 = 0.05, .a6 = -0.02};
  expect_places(mwir, sensor);
  const double tangent2 = (std::pow(31.5 * 15.0, 2) + std::pow(23.5 * 15.0, 2)) * 1e-6;
  const double r2 = (31.5 * 31.5 + 23.5 * 23.5) / (32.0 * 32.0 + 24.0 * 24.0);
  EXPECT_NEAR(budget_of(mwir.at(mwir.field_point(0.5, 0.5)), sensor, 305.0).light_share,
              (1.0 - 0.2 * r2 + 0.05 * r2 * r2 - 0.02 * r2 * r2 * r2) / std::pow(1.0 + tangent2, 2), 1e-12);
  sensor.settings.vignetting = Vignetting{.map = "flat.exr"};
  mtf::Image map(64, 48);
  for (std::int64_t y = 0; y < 48; ++y)
    for (std::int64_t x = 0; x < 64; ++x)
      map.at(x, y) = 0.5F + 0.005F * static_cast<float>(x) + 0.002F * static_cast<float>(y);
  sensor.vignetting = std::make_shared<const mtf::Image>(std::move(map));
  expect_places(mwir, sensor);
  mwir.frame.columns = mwir.frame.rows = 0;
  Sensor sizeless = quiet(noisy_sensor());
  sizeless.settings.vignetting = Vignetting{};
  expect_says(message_of<mtf::UsageError>([&] {
                budget_of(mwir.at({0.5, 0.0}), sizeless, 305.0);
              }),
              {"[vignetting]", "frame.format"});

  mtf::System<double> lwir = test::lwir_system();
  lwir.frame.columns = 64, lwir.frame.rows = 48;
  lwir.frame.focal_length_mm = 1.0;
  for (const ShutterPlace place : {ShutterPlace::detector, ShutterPlace::optics}) {
    ThermalSettings thermal = test::by_netd();
    thermal.shutter_k = 291.0;
    thermal.shutter_place = place;
    Sensor bolometer = test::sensor_of(thermal);
    bolometer.settings.optics =
        OpticsSettings{.transmission = {0.9}, .emissivity = 0.1, .temperature_k = 296.0, .stop_temperature_k = 299.0};
    bolometer.settings.vignetting = Vignetting{.a2 = -0.3};
    expect_places(lwir, bolometer);
  }
}

// Noise behind the readout is that of an observer whose system has no readout, noise before it that of one who has it;
// both add by their squares. The sensor's own OTF is the same in all cases.
TEST(BudgetOfFrames, a_readout_filters_what_comes_before_it_alone) {
  mtf::System<double> bare = mwir_system(), filtered = bare;
  mtf::Component<double> crosstalk = mtf::Component<double>::make("crosstalk");
  mtf::test::set(crosstalk, "side", 0.08);
  filtered.add(mtf::Stage::readout, crosstalk);
  Sensor sensor = noisy_sensor();
  sensor.settings.nonuniformity = NonuniformitySettings{.prnu = 1e-3, .dsnu_e = 500.0, .dcnu = 0.1};
  const Budget<double> budget = budget_of(filtered, sensor, 300.0);
  mtf::ResolutionNeeds needs;
  needs.curves = true;
  needs.tolerance = 1e-8;
  const auto curves =
      std::make_shared<const mtf::Resolution<double>>(mtf::ResolutionMeter<double>(needs).measure(filtered));
  SensorAtRange<double> all = sensor_at_range(budget, 1.0, seen_otf(curves, filtered.frame));
  EXPECT_NEAR(all.late + std::pow(std::hypot(budget.scene_shot_e, budget.background_shot_e, budget.dark_shot_e) /
                                      budget.temporal_e,
                                  2),
              1.0, 1e-12);
  EXPECT_NEAR(
      all.late_spatial + (std::pow(budget.prnu_e, 2) + std::pow(budget.dcnu_e, 2)) / std::pow(budget.spatial_e, 2), 1.0,
      1e-12);
  SensorAtRange<double> early = all, late = all;
  early.late = early.late_spatial = 0.0;
  late.late = late.late_spatial = 1.0;
  Conditions conditions;
  conditions.magnification = 4.0;
  const BarObserver<double> with(filtered, conditions, 2e-3), without(bare, conditions, 2e-3);
  const double f = 0.5 * with.nyquist_cy_mrad();
  for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y}) {
    EXPECT_NEAR(with.mrtd_k(late, axis, f) / without.mrtd_k(all, axis, f), 1.0, 1e-8);
    EXPECT_LT(with.mrtd_k(early, axis, f), 0.96 * with.mrtd_k(late, axis, f));
    EXPECT_NEAR(with.mdtd_k(late, 0.2, 40.0) / without.mdtd_k(all, 0.2, 40.0), 1.0, 1e-8);
    // By the variance of the parts; each in numbers of its own.
    SensorAtRange<double> first = early, second = late;
    first.netd_k *= std::sqrt(1.0 - all.late), first.spatial_netd_k *= std::sqrt(1.0 - all.late_spatial);
    second.netd_k *= std::sqrt(all.late), second.spatial_netd_k *= std::sqrt(all.late_spatial);
    EXPECT_NEAR(std::hypot(with.mrtd_k(first, axis, f), with.mrtd_k(second, axis, f)) / with.mrtd_k(all, axis, f), 1.0,
                1e-12);
  }
  const double cutoff = counted_cy_mrad(filtered, curves->cutoff_cy_mm);
  const DisplayObserver<double> seen(filtered, conditions, 2e-3, cutoff), plain(bare, conditions, 2e-3, cutoff);
  EXPECT_NEAR(seen.ttp_cy_mrad(late, 2.0) / plain.ttp_cy_mrad(all, 2.0), 1.0, 1e-9);
  EXPECT_LT(seen.ttp_cy_mrad(all, 2.0), seen.ttp_cy_mrad(early, 2.0));
  EXPECT_GT(seen.ttp_cy_mrad(all, 2.0), seen.ttp_cy_mrad(late, 2.0));
}

TEST(BudgetOfFrames, a_note_says_that_bad_pixels_are_not_in_it) {
  Sensor sensor = noisy_sensor();
  EXPECT_TRUE(budget_notes(sensor, budget_of(mwir_system(), sensor, 300.0)).empty());
  sensor.settings.defects = Defects{.hot_fraction = 0.01};
  EXPECT_TRUE(says(budget_notes(sensor, budget_of(mwir_system(), sensor, 300.0)), "[defects]: "));
  sensor.settings.blinking = Blinking{};
  EXPECT_TRUE(says(budget_notes(sensor, budget_of(mwir_system(), sensor, 300.0)), "[defects] and [blinking]: "));
}

}  // namespace
}  // namespace radiometry
