// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "radiometry/chain/sensor_budget.h"
#include "radiometry/light/constants.h"
#include "radiometry/performance/thermal_detector.h"
#include "tests/expect_error.h"
#include "tests/radiometry/thermal_cases.h"

// The chain and the budget of [detector] kind = "thermal".

namespace radiometry {
namespace {

using test::by_netd;
using test::by_physics;
using test::lwir_system;
using test::make_chain;
using test::sensor_of;

double netd_k(const mtf::System<double>& system, const Sensor& sensor) {
  return budget_of(system, sensor, 300.0).netd_k;
}

std::map<std::string, double> rows_of(const mtf::System<double>& system, const Sensor& sensor) {
  std::map<std::string, double> values;
  for (const BudgetRow& row : budget_rows(system, sensor, budget_of(system, sensor, 300.0)))
    values[row.name] = row.value;
  return values;
}

TEST(ThermalChain, the_netd_that_is_given_is_that_of_the_budget) {
  mtf::System<double> system = lwir_system();
  EXPECT_NEAR(netd_k(system, sensor_of(by_netd())), 0.05, 1e-15);
  // At F/1.4 through optics of 0.8 the same detector has (1 + 4 1.4^2)/(1 + 4)/0.8 = 2.21 times that.
  system.optics.f_number = 1.4;
  Sensor slow = sensor_of(by_netd());
  slow.settings.optics = OpticsSettings{.transmission = {0.8}};
  EXPECT_NEAR(netd_k(system, slow), 0.05 * 2.21, 1e-14);
  // Four times the bandwidth of the specification: twice the white noise.
  slow.settings.thermal->netd_bandwidth_hz = 30.0;
  slow.settings.thermal->bandwidth_hz = 120.0;
  EXPECT_NEAR(netd_k(system, slow), 0.1 * 2.21, 1e-14);
  // The same camera by a sheet that states 8 to 12 um: 0.6297043467221892 of 0.83782128952792565 W m^-2 sr^-1 K^-1.
  Sensor narrow = sensor_of(by_netd());
  narrow.settings.thermal->netd_shortest_um = 8.0;
  narrow.settings.thermal->netd_longest_um = 12.0;
  EXPECT_NEAR(netd_k(lwir_system(), narrow), 0.05 * 0.6297043467221892 / 0.83782128952792565, 1e-14);
  // Both sides take the cone that [optics] names: nothing changes at the f-number of the specification.
  Sensor sine = sensor_of(by_netd());
  sine.settings.optics = OpticsSettings{.cone = Cone::sine};
  EXPECT_NEAR(netd_k(lwir_system(), sine), 0.05, 1e-15);
  // Readout noise adds to an NETD of the focal plane.
  Sensor noisy = sensor_of(by_netd());
  const Budget<double> quiet = budget_of(lwir_system(), noisy, 300.0);
  noisy.settings.thermal->readout_v = quiet.temporal_e;
  EXPECT_NEAR(netd_k(lwir_system(), noisy), 0.05 * std::sqrt(2.0), 1e-14);
}

TEST(ThermalChain, an_netd_of_the_camera_has_its_rounding_already) {
  Sensor sensor = sensor_of(by_netd());
  const double volts = budget_of(lwir_system(), sensor, 300.0).temporal_e;
  sensor.settings.adc = AdcSettings{.bits = 16, .electrons_per_count = 2.0 * volts, .offset_counts = 1000.0};
  const double half_a_step = 1.0 / 12.0 - std::exp(-mtf::kPi * mtf::kPi) / (2.0 * mtf::kPi * mtf::kPi);
  EXPECT_NEAR(netd_k(lwir_system(), sensor), 0.05 * std::sqrt(1.0 + 4.0 * half_a_step), 1e-12);  // next term: e^-39
  sensor.settings.thermal->netd_of = NetdOf::camera;
  EXPECT_NEAR(netd_k(lwir_system(), sensor), 0.05, 1e-14);
  sensor.settings.adc->electrons_per_count =
      4.0 * volts;  // rounding alone would be 4/sqrt(12) > 1 if noise dithered it
  EXPECT_NEAR(netd_k(lwir_system(), sensor), 0.05, 1e-14);
  EXPECT_FALSE(budget_of(lwir_system(), sensor, 300.0).dither.dithered());
}

/// The noise of the pixels and their readout is white and follows the root of the bandwidth, rounding does not.
TEST(ThermalChain, an_netd_of_the_camera_in_another_bandwidth) {
  Sensor sensor = sensor_of(by_netd());
  const double volts = budget_of(lwir_system(), sensor, 300.0).temporal_e;  // of 50 mK
  sensor.settings.adc = AdcSettings{.bits = 16, .electrons_per_count = 1.5 * volts, .offset_counts = 1000.0};
  sensor.settings.thermal->netd_of = NetdOf::camera;
  sensor.settings.thermal->netd_bandwidth_hz = 30.0;
  for (const double bandwidth_hz : {7.5, 30.0, 120.0}) {
    sensor.settings.thermal->bandwidth_hz = bandwidth_hz;
    const double steps = noise_before_rounding(1.0 / (1.5 * 1.5)).value * std::sqrt(bandwidth_hz / 30.0);
    EXPECT_NEAR(netd_k(lwir_system(), sensor),
                0.05 * 1.5 * std::sqrt(steps * steps + rounding_noise(steps).temporal.value), 1e-14);
  }
}

TEST(ThermalChain, a_fill_factor_is_that_part_of_the_pitch) {
  mtf::System<double> system = lwir_system();
  system.frame.pitch_y_um = 20.0;
  ThermalSettings thermal = by_netd();
  thermal.fill_factor = 0.81;
  const Pixel<double> pixel = pixel_of(system, sensor_of(thermal));
  EXPECT_NEAR(pixel.width_um, 0.9 * 17.0, 1e-13);
  EXPECT_NEAR(pixel.height_um, 0.9 * 20.0, 1e-13);
  EXPECT_NEAR(netd_k(system, sensor_of(thermal)), 0.05, 1e-15);  // an NETD is that of the pixel as it is
  thermal = ThermalSettings{.fill_factor = 0.81, .responsivity_v_w = 1e5, .bandwidth_hz = 30.0, .dstar_jones = 1e9};
  const double part = netd_k(system, sensor_of(thermal));
  thermal.fill_factor = 1.0;
  EXPECT_NEAR(part / netd_k(system, sensor_of(thermal)), 1.0 / 0.9, 1e-13);  // sqrt(A)/A
}

TEST(ThermalChain, counts_for_a_kelvin_are_those_of_frames) {
  ThermalSettings thermal = by_netd();
  thermal.responsivity_v_w.reset();
  thermal.counts_per_k = 30.0;
  Sensor sensor = sensor_of(thermal);
  sensor.settings.adc = AdcSettings{.bits = 16, .electrons_per_count = 1e-6};
  EXPECT_NEAR(budget_of(lwir_system(), sensor, 300.0).signal_per_k, 30e-6, 1e-19);
  EXPECT_NEAR(netd_k(lwir_system(), sensor), std::hypot(0.05, 1.0 / std::sqrt(12.0) / 30.0), 1e-14);
  // At F/1.4 through optics of 0.8 it has 1/2.21 of the light.
  mtf::System<double> slow = lwir_system();
  slow.optics.f_number = 1.4;
  sensor.settings.optics = OpticsSettings{.transmission = {0.8}};
  EXPECT_NEAR(budget_of(slow, sensor, 300.0).signal_per_k, 30e-6 / 2.21, 1e-19);
}

TEST(ThermalChain, figures_of_data_sheets_come_back) {
  const Spectrum curve = make_spectrum("curve", {8.0, 10.0, 14.0}, {0.5, 0.9, 0.7});  // 0.85 at 11 um, the middle
  for (const bool with_curve : {false, true}) {
    const auto rows = [&](auto set) {
      ThermalSettings thermal;
      thermal.absorptance = {0.8};
      thermal.responsivity_v_w = 1e5;
      thermal.bandwidth_hz = 120.0;
      set(thermal);
      Sensor sensor = sensor_of(thermal);
      if (with_curve) {
        sensor.settings.thermal->absorptance = sensor.settings.detector->quantum_efficiency = {.file = "curve"};
        sensor.curves.quantum_efficiency = {curve};
      }
      return rows_of(lwir_system(), sensor);
    };
    const auto nep = rows([](ThermalSettings& t) { t.nep_w = 8e-12, t.nep_bandwidth_hz = 30.0; });
    EXPECT_NEAR(nep.at("nep"), 16e-12, 1e-25);
    EXPECT_NEAR(nep.at("temporal"), 16e-12 * 1e5, 1e-19);  // responsivity is that of incident power too
    EXPECT_NEAR(nep.at("responsivity"), 1e5, 1e-8);
    const auto density = rows([](ThermalSettings& t) { t.nep_density = 1e-12; });
    EXPECT_NEAR(density.at("nep"), 1e-12 * std::sqrt(120.0), 1e-25);
    const auto dstar = rows([](ThermalSettings& t) { t.dstar_jones = 7e8; });
    EXPECT_NEAR(dstar.at("dstar"), 7e8, 1e-5);
    EXPECT_NEAR(dstar.at("nep"), 1e2 * 17e-6 * std::sqrt(120.0) / 7e8, 1e-24);
    EXPECT_NEAR(dstar.at("netd") / nep.at("netd"), dstar.at("nep") / nep.at("nep"), 1e-13);
  }
}

TEST(ThermalChain, the_budget_of_the_physics_has_its_terms) {
  const auto rows = rows_of(lwir_system(), sensor_of(by_physics()));
  // In watts as in test_thermal_detector.cpp, times 2 V x 0.02/K / 3e-8 W/K.
  const double volts = 4e6 / 3.0;
  EXPECT_NEAR(rows.at("thermal_fluctuation"), volts * 1.9287297034143677e-12, 1e-18);
  EXPECT_NEAR(rows.at("johnson"), volts * 2.7304769912965756e-12, 1e-18);
  EXPECT_NEAR(rows.at("readout"), 10e-6, 1e-18);
  const double sum = std::hypot(rows.at("thermal_fluctuation"), rows.at("johnson"), rows.at("readout"));
  EXPECT_NEAR(rows.at("temporal"), sum, 1e-18);
  EXPECT_NEAR(rows.at("largest"), 1e-10 / (sum * sum), 1e-12);
  EXPECT_NEAR(rows.at("nep"), sum / volts / 0.8, 1e-24);
  EXPECT_NEAR(rows.at("time_constant"), 10e-3, 1e-17);
  // NETD = NEP / (pi/5 x 0.83782128952792565 W m^-2 sr^-1 K^-1 x (17 um)^2), of incident power both.
  EXPECT_NEAR(rows.at("netd"), 1e3 * rows.at("nep") / 1.52134987434e-10, 1e-8);
}

TEST(ThermalChain, one_over_f_noise_goes_on_from_frame_to_frame) {
  ThermalSettings thermal = by_physics();
  thermal.readout_v = 0.0;
  thermal.corner_hz = 1e3;
  thermal.lowest_hz = 0.01;
  Sensor sensor = sensor_of(thermal);
  sensor.settings.noise = NoiseSettings{.seed = 5};
  expect_refused({"frame.frame_time", "1/f"}, [&] { require_consistent(lwir_system(), sensor); });
  sensor.settings.frame = FrameSettings{.frame_time_s = 20e-3};
  const auto rows = rows_of(lwir_system(), sensor);
  const double volts = 4e6 / 3.0, flicker = volts * 3.5591072395856483e-12;
  EXPECT_NEAR(rows.at("flicker"), flicker, 1e-18);
  EXPECT_NEAR(rows.at("temporal"), std::hypot(flicker, rows.at("johnson"), rows.at("thermal_fluctuation")), 1e-18);
  const Chain chain = make_chain(lwir_system(), sensor, 256, 256, 17.0);
  const auto noise = [&](std::uint32_t number) {
    return chain.run(test::flat(256, 256, 0.0F), number, OutputStage::volts).image;
  };
  const mtf::Image first = noise(70), next = noise(71), later = noise(70 + 100000);
  const double n = static_cast<double>(first.size());
  double square = 0.0, near = 0.0, far = 0.0;
  for (std::int64_t i = 0; i < first.size(); ++i) {
    const auto value = static_cast<double>(first.data()[i]);
    square += value * value / n;
    near += value * static_cast<double>(next.data()[i]) / n;
    far += value * static_cast<double>(later.data()[i]) / n;
  }
  const double variance = rows.at("temporal") * rows.at("temporal");
  EXPECT_NEAR(square / variance, 1.0, 4.5 * std::sqrt(2.0 / n));
  // What lies below a cycle in some frames, 0.01 Hz to some Hz of the 0.01 Hz to 8 kHz, is the same in the next frame.
  EXPECT_GT(near / (flicker * flicker), 0.3);
  EXPECT_LT(near / (flicker * flicker), 0.6);
  EXPECT_NEAR(far / variance, 0.0, 4.5 / std::sqrt(n));
}

/// Watts of a thermal pixel are electrons times h c/lambda: test_watts.cpp says for which absorptance at all
/// wavelengths.
TEST(ThermalChain, signal_through_watts_is_that_through_photons) {
  mtf::System<double> system = lwir_system();
  ThermalSettings thermal = by_netd();
  thermal.absorptance = {.file = "curve"};
  Sensor watts = sensor_of(thermal), photons;
  watts.curves.quantum_efficiency = {make_spectrum("curve", {8.0, 14.0}, {8.0 / 14.0, 1.0})};
  watts.settings.optics =
      OpticsSettings{.transmission = {0.85}, .emissivity = 0.1, .temperature_k = 295.0, .stop_temperature_k = 290.0};
  const Budget<double> v = budget_of(system, watts, 305.0);
  system.frame.integration_time_s = 1.0;
  photons.curves.band = {8.0, 14.0};
  photons.settings.optics = watts.settings.optics;
  photons.settings.detector = DetectorSettings{};
  const Budget<double> e = budget_of(system, photons, 305.0);
  const double volts_per_electron = 1e5 / (11.0 / 14.0) * kPhotonEnergy_j_um / 14.0;
  for (const auto& [volts, electrons] :
       {std::pair{v.signal.scene_e, e.signal.scene_e}, std::pair{v.signal.optics_e, e.signal.optics_e},
        std::pair{v.signal.stop_e, e.signal.stop_e}, std::pair{v.signal_per_k, e.signal_per_k}})
    EXPECT_NEAR(volts / (electrons * volts_per_electron), 1.0, 1e-12);
  EXPECT_EQ(v.scene_shot_e, 0.0);
  // The same in images, to the digits of floats.
  const auto image = [&](const Sensor& sensor, OutputStage stage) {
    mtf::Image scene = test::flat(16, 16, 305.0F);
    radiance_of_temperature(scene.view(), scene_band(sensor.curves));
    return static_cast<double>(make_chain(system, sensor, 16, 16, 17.0).run(std::move(scene), 0, stage).image.at(8, 8));
  };
  const double electrons = image(photons, OutputStage::electrons);
  EXPECT_NEAR(image(watts, OutputStage::watts) / (electrons * kPhotonEnergy_j_um / 14.0), 1.0, 1e-6);
  EXPECT_NEAR(image(watts, OutputStage::volts) / (electrons * volts_per_electron), 1.0, 1e-6);
}

TEST(ThermalChain, a_camera_as_warm_as_its_shutter_gives_nothing) {
  ThermalSettings thermal = by_netd();
  thermal.shutter_k = 295.0;
  Sensor sensor = sensor_of(thermal);
  sensor.settings.optics =
      OpticsSettings{.transmission = {0.9}, .emissivity = 0.1, .temperature_k = 295.0, .stop_temperature_k = 295.0};
  const Budget<double> same = budget_of(lwir_system(), sensor, 295.0);
  EXPECT_LT(same.signal.shutter_e, 0.0);
  EXPECT_NEAR(same.signal.total_e(), 0.0, 1e-13 * same.signal.scene_e);
  const Budget<double> warmer = budget_of(lwir_system(), sensor, 296.0);
  EXPECT_NEAR(warmer.signal.total_e(), warmer.signal.scene_e - same.signal.scene_e, 1e-13 * same.signal.scene_e);
  // In frames too; a lens between cold and warm counts as its own temperature.
  mtf::Image scene = test::flat(16, 16, 295.0F);
  radiance_of_temperature(scene.view(), scene_band(sensor.curves));
  const mtf::Image volts =
      make_chain(lwir_system(), sensor, 16, 16, 17.0).run(std::move(scene), 0, OutputStage::volts).image;
  EXPECT_NEAR(static_cast<double>(volts.at(5, 5)), 0.0, 2e-7 * same.signal.scene_e);
}

// Between the pixels lies the light that falls on them: the volts' finer sampling is the watts', too.
TEST(ThermalChain, microscan_samples_watts_as_it_samples_volts) {
  ThermalSettings thermal = by_netd();
  thermal.shutter_k = 295.0;
  Sensor sensor = sensor_of(thermal);
  sensor.settings.optics =
      OpticsSettings{.transmission = {0.9}, .emissivity = 0.1, .temperature_k = 300.0, .stop_temperature_k = 290.0};
  sensor.settings.vignetting = Vignetting{.a2 = -0.5};
  sensor.settings.microscan = Microscan{.steps = 2};
  const Chain chain = make_chain(lwir_system(), sensor, 32, 32, 17.0 / 2.0);
  const auto image = [&](OutputStage stage) {
    mtf::Image scene = test::flat(32, 32, 310.0F);
    radiance_of_temperature(scene.view(), scene_band(sensor.curves));
    return chain.run(std::move(scene), 0, stage).image;
  };
  const mtf::Image watts = image(OutputStage::watts), volts = image(OutputStage::volts);
  ASSERT_EQ(watts.width(), 32);
  EXPECT_GT(std::abs(watts.at(0, 0) / watts.at(16, 16) - 1.0F), 0.1F);
  const float volts_per_watt = volts.at(16, 16) / watts.at(16, 16);
  for (std::int64_t y = 0; y < 32; ++y)
    for (std::int64_t x = 0; x < 32; ++x)
      ASSERT_NEAR(volts.at(x, y), volts_per_watt * watts.at(x, y), 1e-5F * std::abs(volts.at(16, 16)))
          << x << ", " << y;
}

/// Two blackbodies in front of the camera: rms of one pixel over frames, over counts per kelvin.
TEST(ThermalChain, netd_of_frames_of_two_blackbodies_is_the_specified_one) {
  for (const NetdOf of : {NetdOf::focal_plane, NetdOf::camera}) {
    ThermalSettings thermal = by_netd();
    thermal.netd_of = of;
    thermal.shutter_k = 290.0;
    Sensor sensor = sensor_of(thermal);
    sensor.settings.optics = OpticsSettings{.stop_temperature_k = 290.0};
    sensor.settings.noise = NoiseSettings{.seed = 5};
    const double volts = budget_of(lwir_system(), sensor, 300.0).temporal_e;
    const double step = of == NetdOf::camera ? 1.5 * volts : 0.05 * volts;
    sensor.settings.adc = AdcSettings{.bits = 16, .electrons_per_count = step, .offset_counts = 8000.0};
    const Chain chain = make_chain(lwir_system(), sensor, 384, 384, 17.0);
    const auto frame = [&](float temperature_k, std::uint32_t number) {
      mtf::Image scene = test::flat(384, 384, temperature_k);
      radiance_of_temperature(scene.view(), scene_band(sensor.curves));
      return chain.run(std::move(scene), number, OutputStage::dn).image;
    };
    const auto mean = [](const mtf::Image& image) {
      double sum = 0.0;
      for (const float value : test::samples(image)) sum += static_cast<double>(value);
      return sum / static_cast<double>(image.size());
    };
    const mtf::Image warm = frame(301.0F, 0), cold = frame(299.0F, 1);
    const double counts_per_k = 0.5 * (mean(warm) - mean(cold));
    double squares = 0.0;
    std::int64_t count = 0;
    for (std::uint32_t pair = 2; pair < 6; pair += 2) {
      const mtf::Image a = frame(300.0F, pair), b = frame(300.0F, pair + 1);
      for (std::int64_t i = 0; i < a.size(); ++i, ++count) {
        const auto difference = static_cast<double>(a.data()[i] - b.data()[i]);
        squares += difference * difference;
      }
    }
    const double rms = std::sqrt(0.5 * squares / static_cast<double>(count));
    EXPECT_NEAR(rms / counts_per_k, 0.05, 0.01 * 0.05);
  }
}

TEST(ThermalChain, lag_conserves_energy) {
  Sensor sensor = sensor_of(by_physics());
  sensor.settings.frame = FrameSettings{.frame_time_s = 5e-3};
  sensor.settings.lag = Lag{.time_constant_s = 10e-3};
  const Chain chain = make_chain(lwir_system(), sensor, 16, 16, 17.0);
  ChainState state;
  const auto volts = [&](float temperature_k, std::uint32_t number) {
    mtf::Image scene = test::flat(16, 16, temperature_k);
    radiance_of_temperature(scene.view(), scene_band(sensor.curves));
    return static_cast<double>(chain.run(std::move(scene), number, OutputStage::volts, 0.0, 1, &state).image.at(4, 4));
  };
  const double still = volts(300.0F, 0), flash = budget_of(lwir_system(), sensor, 400.0).signal.scene_e - still;
  double energy = volts(400.0F, 1) - still, last = energy;
  EXPECT_NEAR(energy, flash * -std::expm1(-0.5), 1e-6 * flash);
  for (std::uint32_t n = 2; n < 40; ++n) {
    const double more = volts(300.0F, n) - still;
    if (n < 12) {
      EXPECT_NEAR(more / last, std::exp(-0.5), 1e-4);  // the tail of the time constant
    }
    last = more;
    energy += more;
  }
  EXPECT_NEAR(energy, flash, 1e-5 * flash);
}

}  // namespace
}  // namespace radiometry
