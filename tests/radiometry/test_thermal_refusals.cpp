// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/bolometer.h"
#include "mtf/literals.h"
#include "tests/expect_error.h"
#include "tests/radiometry/thermal_cases.h"

// What a thermal detector does not have, and noise that is given in no form, in two, or without its reference.

namespace radiometry {
namespace {

using test::by_netd;
using test::by_physics;
using test::lwir_system;
using test::make_chain;
using test::sensor_of;

TEST(ThermalRefusals, what_a_thermal_detector_does_not_have_is_refused) {
  const mtf::System<double> system = lwir_system();
  const auto refused = [&](std::initializer_list<std::string_view> parts, const auto& change) {
    Sensor sensor = sensor_of(by_netd());
    change(sensor.settings);
    expect_refused(parts, [&] { require_consistent(system, sensor); });
  };
  refused({"[blooming]", "remove it"}, [](SensorSettings& s) { s.blooming.emplace(); });
  refused({"[nonlinearity]", "full well"}, [](SensorSettings& s) { s.nonlinearity.emplace(); });
  refused({"[correction]", "[nonuniformity]"}, [](SensorSettings& s) { s.correction.emplace(); });
  refused({"[narcissus]"}, [](SensorSettings& s) { s.narcissus.emplace(); });
  refused({"detector.shutter_temperature", "give optics.stop_temperature"},
          [](SensorSettings& s) { s.thermal->shutter_k = 300.0; });
  refused({"frame.frame_time: missing", "rolling"},
          [](SensorSettings& s) { s.shutter = Shutter{.kind = ShutterKind::rolling, .line_time_s = 30e-6}; });
  refused({"adc.volts_per_count: missing"}, [](SensorSettings& s) { s.adc.emplace(); });
  refused({"frame.frame_time: missing", "20 ms"}, [](SensorSettings& s) { s.lag.emplace(); });
  const Sensor sensor = sensor_of(by_netd());
  expect_refused({"stage electrons", "watts or volts"}, [&] {
    make_chain(system, sensor, 16, 16, 17.0).run(test::flat(16, 16, 1.0F), 0, OutputStage::electrons);
  });
  expect_refused({"stage volts", "kind = \"thermal\""}, [&] {
    make_chain(test::mwir_system(), test::mwir_sensor(), 16, 16, 15.0)
        .run(test::flat(16, 16, 1.0F), 0, OutputStage::volts);
  });
  // The converter's range is that of the microbridges.
  Sensor small = sensor_of(by_netd());
  small.settings.adc = AdcSettings{.bits = 8, .electrons_per_count = 1e-6};
  const Budget<double> budget = budget_of(system, small, 300.0);
  ASSERT_TRUE(budget.saturation.saturated());
  const std::string said = words(budget.saturation);
  expect_says(said, {" V", "raise adc.volts_per_count or adc.bits"});
  EXPECT_FALSE(says(said, "e-")) << said;
  EXPECT_FALSE(says(said, "integration")) << said;
}

TEST(ThermalRefusals, a_figure_taken_far_beyond_the_bandwidth_of_the_pixel_is_warned_about) {
  ThermalSettings thermal;
  thermal.dstar_jones = 1e9;
  thermal.bandwidth_hz = 8e3;
  // 1/(4 x 10 ms) = 25 Hz
  expect_says(bandwidth_warning(thermal, 10e-3), {"from 1 Hz", "8e+03 Hz", "1/(4 tau) = 25 Hz", "too large"});
  EXPECT_EQ(bandwidth_warning(thermal, 0.0), "");  // no time constant is known
  thermal.bandwidth_hz = 240.0;
  EXPECT_EQ(bandwidth_warning(thermal, 10e-3), "");
  thermal = by_netd();
  thermal.bandwidth_hz = 8e3;
  EXPECT_EQ(bandwidth_warning(thermal, 10e-3), "");  // the NETD is that of the camera's own bandwidth
  thermal.netd_bandwidth_hz = 8e3;
  EXPECT_EQ(bandwidth_warning(thermal, 10e-3), "");
  thermal.bandwidth_hz = 30.0;
  expect_says(bandwidth_warning(thermal, 10e-3), {"netd", "8e+03 Hz", "30 Hz", "too small"});
}

TEST(ThermalRefusals, one_time_constant_is_counted_once) {
  mtf::System<double> moving = lwir_system();
  using namespace mtf::literals;
  const mtf::Bolometer<double> tail{.time_constant_s = 10_ms, .velocity_um_s = 0.5_mm / 1_s};
  moving.add(mtf::Stage::presample, tail);
  Sensor sensor = sensor_of(by_physics());
  require_consistent(moving, sensor);  // the component alone, with the time constant of the pixel
  sensor.settings.frame = FrameSettings{.frame_time_s = 20e-3};
  sensor.settings.lag = Lag{.time_constant_s = 10e-3};
  expect_refused({"[lag]", "bolometer", "keep [lag] for sequences"}, [&] { require_consistent(moving, sensor); });
  require_consistent(lwir_system(), sensor);
  sensor.settings.lag.reset();
  sensor.settings.thermal->heat_capacity_j_k = 4e-10;
  expect_refused({"heat_capacity / conductance", "0.01 s", "one time constant"},
                 [&] { require_consistent(moving, sensor); });
}

TEST(ThermalRefusals, noise_is_given_once_and_whole) {
  const auto refused = [&](std::initializer_list<std::string_view> parts, ThermalSettings thermal) {
    expect_refused(parts, [&] { budget_of(lwir_system(), sensor_of(thermal), 300.0); });
  };
  ThermalSettings thermal;
  thermal.responsivity_v_w = 1e5;
  refused({"[detector]", "without its noise", "netd, nep, nep_density, dstar"}, thermal);
  thermal = by_netd();
  thermal.dstar_jones = 1e9;
  refused({"netd and dstar", "keep one"}, thermal);
  thermal = by_netd();
  thermal.conductance_w_k = 1e-8;
  refused({"netd and the physics"}, thermal);
  thermal = by_netd();
  thermal.netd_f_number.reset();
  thermal.netd_temperature_k.reset();
  refused({"detector.netd: given without netd_f_number, netd_temperature; write netd_f_number = 1.0"}, thermal);
  thermal = by_netd();
  thermal.netd_shortest_um = 14.0;
  refused({"detector.netd:", "two ends"}, thermal);
  thermal.netd_longest_um = 8.0;
  refused({"detector.netd:", "two ends"}, thermal);
  thermal = by_netd();
  thermal.netd_bandwidth_hz = 30.0;
  refused({"detector.netd_bandwidth: given without noise_bandwidth"}, thermal);
  thermal = by_netd();
  thermal.netd_of = NetdOf::camera;
  thermal.readout_v = 1e-6;
  refused({"detector.readout_noise", "NETD of the camera"}, thermal);
  thermal = by_netd();
  thermal.responsivity_v_w.reset();
  refused({"detector.responsivity: missing"}, thermal);
  thermal.counts_per_k = 30.0;
  thermal.responsivity_v_w = 1e5;
  refused({"detector.counts_per_kelvin: given beside responsivity"}, thermal);
  thermal = by_netd();
  thermal.fill_factor = 0.9;
  thermal.height_um = 15.0;
  refused({"detector.fill_factor: given beside height"}, thermal);
  thermal = by_physics();
  thermal.counts_per_k = 30.0;
  refused({"detector.counts_per_kelvin: belongs to netd"}, thermal);
  thermal = by_netd();
  thermal.nep_bandwidth_hz = 30.0;
  refused({"detector.nep_bandwidth: belongs to nep"}, thermal);
  thermal = ThermalSettings{.responsivity_v_w = 1e5, .nep_w = 1e-11};
  thermal.netd_frame_rate_hz = 60.0;
  thermal.netd_bandwidth_hz = 30.0, thermal.bandwidth_hz = 25.0;  // what a frame rate of the file stands for
  refused({"detector.netd_frame_rate: belongs to netd", "remove"}, thermal);
  thermal = by_physics();
  thermal.responsivity_v_w = 1e5;
  refused({"detector.responsivity: given beside bias"}, thermal);
  thermal = by_physics();
  thermal.corner_hz = 1e3;
  refused({"detector.lowest_frequency: 0 Hz; 1/f noise"}, thermal);
  thermal = by_physics();
  thermal.lowest_hz = 1e-2;
  refused({"detector.lowest_frequency: belongs to corner"}, thermal);
  thermal = by_physics();
  thermal.tcr_per_k.reset();
  refused({"detector.conductance: given without tcr"}, thermal);
  thermal = by_physics();
  thermal.conductance_w_k = 0.0;
  refused({"detector.conductance: 0 W/K"}, thermal);
  thermal = by_physics();
  thermal.conductance_w_k = 1e-9;
  refused({"detector.conductance", "4 emissivity sigma A T^3"}, thermal);
}

}  // namespace
}  // namespace radiometry
