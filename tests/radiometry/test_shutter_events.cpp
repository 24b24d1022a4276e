// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/expect_error.h"
#include "tests/radiometry/thermal_cases.h"

// The shutter of a thermal camera: where it stands, what filters and vignetting do to its light, and the false offset
// of a camera that gets warmer between two closings. References are written by hand from band integrals.

namespace radiometry {
namespace {

using test::by_netd;
using test::lwir_system;
using test::make_chain;
using test::sensor_of;

constexpr double kWarm_k = 295.0, kFrameTime_s = 20e-3;
/// Volts of one W m^-2 sr^-1 from one steradian: responsivity of incident power x area of the pixel.
constexpr double kVolts = 1e5 * 17e-6 * 17e-6;
constexpr double kCone = mtf::kPi / 5.0;  // F/1

double watts_of(double temperature_k) { return band_radiance(Flux::watts, 8.0, 14.0, temperature_k); }

/// A camera whose lens, housing and shutter have one temperature; what the lens does not let through it emits.
Sensor shuttered(ShutterPlace place) {
  ThermalSettings thermal = by_netd();
  thermal.shutter_k = kWarm_k;
  thermal.shutter_place = place;
  Sensor sensor = sensor_of(thermal);
  sensor.settings.optics =
      OpticsSettings{.transmission = {0.9}, .emissivity = 0.1, .temperature_k = kWarm_k, .stop_temperature_k = kWarm_k};
  return sensor;
}

Sensor with_curve(Sensor sensor) {
  sensor.settings.detector->quantum_efficiency = sensor.settings.thermal->absorptance = {.file = "curve"};
  sensor.curves.quantum_efficiency = {make_spectrum("curve", {6.0, 8.0, 11.0, 14.0, 18.0}, {0.3, 0.6, 0.8, 0.6, 0.2})};
  return sensor;
}

/// Volts of a uniform scene, one for each frame number.
class ShutteredCamera {
 public:
  explicit ShutteredCamera(const Sensor& sensor, std::int64_t size = 16)
      : sensor_(sensor), size_(size), chain_(make_chain(lwir_system(), sensor, size, size, 17.0)) {}

  mtf::Image image(double temperature_k, std::uint32_t number, ChainState* state = nullptr,
                   OutputStage stage = OutputStage::volts) const {
    mtf::Image scene = test::flat(size_, size_, static_cast<float>(temperature_k));
    radiance_of_temperature(scene.view(), scene_band(sensor_.curves));
    return chain_.run(std::move(scene), number, stage, 0.0, 1, state).image;
  }
  double volts(double temperature_k, std::uint32_t number, ChainState* state = nullptr) const {
    return static_cast<double>(image(temperature_k, number, state).at(5, 5));
  }

 private:
  Sensor sensor_;
  std::int64_t size_;
  Chain chain_;
};

TEST(ShutterPlace, what_the_pixel_receives_from_it) {
  // Between detector and optics: (0.9 L(T) + 0.1 L(295 K)) in the cone and the housing around it, less a hemisphere.
  Sensor inside = shuttered(ShutterPlace::detector);
  inside.settings.thermal->shutter_k = 290.0;
  const double lens = 0.9 * watts_of(305.0) + 0.1 * watts_of(kWarm_k);
  const double hemisphere = kCone * lens + (mtf::kPi - kCone) * watts_of(kWarm_k) - mtf::kPi * watts_of(290.0);
  EXPECT_NEAR(budget_of(lwir_system(), inside, 305.0).signal.total_e() / (kVolts * hemisphere), 1.0, 1e-12);
  // Before the optics: lens and housing cancel, the scene is compared with the shutter.
  Sensor outside = shuttered(ShutterPlace::optics);
  outside.settings.thermal->shutter_k = 290.0;
  outside.settings.optics->stop_temperature_k = 340.0;
  const double scene = kVolts * kCone * 0.9 * (watts_of(305.0) - watts_of(290.0));
  EXPECT_NEAR(budget_of(lwir_system(), outside, 305.0).signal.total_e() / scene, 1.0, 1e-11);
  EXPECT_NEAR(ShutteredCamera(outside).volts(305.0, 0) / scene, 1.0, 1e-5);
}

TEST(ShutterPlace, a_window_weakens_scene_and_shutter_alike) {
  // tau_c cone (0.9 L(T) + 0.1 L(295 K) - L(290 K)) + (pi - cone)(L(295 K) - L(290 K))
  Sensor sensor = shuttered(ShutterPlace::detector);
  sensor.settings.thermal->shutter_k = 290.0;
  sensor.settings.optics->cold_transmission = {0.7};
  const double lens = 0.9 * watts_of(305.0) + 0.1 * watts_of(kWarm_k) - watts_of(290.0);
  const double expected = 0.7 * kCone * lens + (mtf::kPi - kCone) * (watts_of(kWarm_k) - watts_of(290.0));
  EXPECT_NEAR(budget_of(lwir_system(), sensor, 305.0).signal.total_e() / (kVolts * expected), 1.0, 1e-12);
}

/// Lens, housing and shutter of one temperature: a scene of that temperature gives nothing, whatever the filters are.
TEST(ShutterPlace, one_temperature_gives_no_signal) {
  for (const ShutterPlace place : {ShutterPlace::detector, ShutterPlace::optics})
    for (const StopBand band : {StopBand::band, StopBand::response})
      for (const bool vignetted : {false, true}) {
        Sensor sensor = with_curve(shuttered(place));
        sensor.settings.optics->stop_band = band;
        sensor.settings.optics->cold_transmission = {0.8};
        if (vignetted) sensor.settings.vignetting = Vignetting{.cos4 = false, .a2 = -0.4};
        const double all = budget_of(lwir_system(), sensor, kWarm_k).signal.scene_e;
        EXPECT_NEAR(budget_of(lwir_system(), sensor, kWarm_k).signal.total_e(), 0.0, 1e-12 * all);
        for (const OutputStage stage : {OutputStage::watts, OutputStage::volts}) {
          const mtf::Image image = ShutteredCamera(sensor).image(kWarm_k, 0, nullptr, stage);
          const double scale = stage == OutputStage::volts ? all : all / pixel_of(lwir_system(), sensor).volts_per_watt;
          for (const float value : test::samples(image)) EXPECT_NEAR(static_cast<double>(value), 0.0, 1e-6 * scale);
        }
      }
}

/// A pixel whose cone is narrowed to v sees v of the scene, and the housing in the place of the rest.
TEST(ShutterPlace, the_housing_is_seen_where_the_lens_is_cut) {
  for (const ShutterPlace place : {ShutterPlace::detector, ShutterPlace::optics}) {
    Sensor sensor = shuttered(place);
    sensor.settings.vignetting = Vignetting{.cos4 = false, .a2 = -0.4};
    sensor.settings.optics->stop_temperature_k = 300.0;
    const mtf::Image image = ShutteredCamera(sensor).image(310.0, 0);
    // The corner pixel of 16 x 16: r^2 = (7.5^2 + 7.5^2)/(8^2 + 8^2)
    const double v = 1.0 - 0.4 * 7.5 * 7.5 / 64.0;
    const double lens = 0.9 * (watts_of(310.0) - watts_of(kWarm_k));
    const double housing = place == ShutterPlace::optics ? 0.0 : watts_of(300.0) - watts_of(kWarm_k);
    const double expected = kVolts * (v * kCone * lens + (mtf::kPi - v * kCone) * housing);
    EXPECT_NEAR(static_cast<double>(image.at(0, 0)) / expected, 1.0, 3e-6);
  }
}

TEST(ShutterEvents, a_camera_that_warms_has_a_false_offset_between_two_closings) {
  for (const ShutterPlace place : {ShutterPlace::detector, ShutterPlace::optics}) {
    Sensor sensor = shuttered(place);
    sensor.settings.frame = FrameSettings{.frame_time_s = kFrameTime_s};
    sensor.settings.thermal->drift_k_s = 0.5;
    sensor.settings.thermal->shutter_interval_s = 50 * kFrameTime_s;
    const ShutteredCamera camera(sensor);
    ChainState state;
    for (const std::uint32_t n : {0U, 1U, 49U, 50U, 74U, 100U, 137U}) {
      const double now_k = kWarm_k + 0.5 * kFrameTime_s * n, closed_k = kWarm_k + 0.5 * kFrameTime_s * (n / 50 * 50);
      const double open =
          kCone * (0.9 * watts_of(310.0) + 0.1 * watts_of(now_k)) + (mtf::kPi - kCone) * watts_of(now_k);
      const double closed = mtf::kPi * watts_of(closed_k);  // before the optics: 0.9 + 0.1 in the cone, the same
      const double expected = kVolts * (open - closed), scale = kVolts * watts_of(310.0);
      EXPECT_NEAR(camera.volts(310.0, n), expected, 1e-6 * scale) << n;
      EXPECT_NEAR(camera.volts(310.0, n, &state), expected, 1e-6 * scale) << n;  // frames in order or alone
    }
  }
}

/// The budget says how large it gets: 0.5 K/s for 49 frames of 20 ms, as the shutter closes again at the 50th.
TEST(ShutterEvents, the_budget_has_the_false_offset) {
  Sensor sensor = shuttered(ShutterPlace::detector);
  sensor.settings.frame = FrameSettings{.frame_time_s = kFrameTime_s};
  sensor.settings.thermal->drift_k_s = 0.5;
  sensor.settings.thermal->shutter_frames = 50;
  const double light = watts_of(kWarm_k + 0.49) - watts_of(kWarm_k);
  const double volts = kVolts * (kCone * 0.1 + mtf::kPi - kCone) * light;
  const Budget<double> budget = budget_of(lwir_system(), sensor, 300.0);
  const std::vector<BudgetRow> rows = budget_rows(lwir_system(), sensor, budget);
  const auto row = std::find_if(rows.begin(), rows.end(), [](const auto& r) { return r.name == "false_offset"; });
  ASSERT_NE(row, rows.end());
  EXPECT_NEAR(row->value / (1e3 * volts / budget.signal_per_k), 1.0, 1e-9);
}

/// The offset is taken off after the pixels have answered: a closing is a step, however slow they are.
TEST(ShutterEvents, a_slow_pixel_does_not_smear_a_closing) {
  Sensor sensor = shuttered(ShutterPlace::detector);
  sensor.settings.frame = FrameSettings{.frame_time_s = kFrameTime_s};
  sensor.settings.thermal->drift_k_s = 0.2;
  sensor.settings.thermal->shutter_frames = 30;
  const ShutteredCamera fast(sensor);
  sensor.settings.lag = Lag{.time_constant_s = 60e-3};
  const ShutteredCamera slow(sensor);
  ChainState fast_state, slow_state;
  double before_fast = 0.0, before_slow = 0.0;
  for (std::uint32_t n = 0; n <= 30; ++n) {
    const double now_fast = fast.volts(300.0, n, &fast_state), now_slow = slow.volts(300.0, n, &slow_state);
    if (n == 30) {
      EXPECT_LT(now_fast, before_fast);
      EXPECT_NEAR((now_slow - before_slow) / (now_fast - before_fast), 1.0, 2e-3);
    }
    before_fast = now_fast, before_slow = now_slow;
  }
}

TEST(ShutterEvents, the_pixels_share_the_false_offset_by_their_responsivity) {
  Sensor sensor = shuttered(ShutterPlace::detector);
  sensor.settings.frame = FrameSettings{.frame_time_s = kFrameTime_s};
  sensor.settings.thermal->drift_k_s = 1.0;
  sensor.settings.thermal->shutter_frames = 1000;
  const double false_offset = ShutteredCamera(sensor).volts(kWarm_k, 500) - ShutteredCamera(sensor).volts(kWarm_k, 0);
  mtf::Image half = test::flat(16, 16, 1.0F);
  half.at(5, 5) = 0.5F;
  sensor.settings.nonuniformity = NonuniformitySettings{};
  sensor.responsivity = std::make_shared<const mtf::Image>(std::move(half));
  const ShutteredCamera uneven(sensor);
  EXPECT_NEAR((uneven.volts(kWarm_k, 500) - uneven.volts(kWarm_k, 0)) / false_offset, 0.5, 1e-5);
}

TEST(ShutterEvents, what_cannot_be_is_refused) {
  const auto refused = [](std::initializer_list<std::string_view> parts, const auto& change) {
    Sensor sensor = shuttered(ShutterPlace::detector);
    sensor.settings.frame = FrameSettings{.frame_time_s = kFrameTime_s};
    change(sensor.settings);
    expect_refused(parts, [&] { require_consistent(lwir_system(), sensor); });
  };
  refused({"detector.shutter_drift", "shutter_interval"}, [](SensorSettings& s) { s.thermal->drift_k_s = 0.1; });
  refused({"detector.shutter_frames", "shutter_interval"}, [](SensorSettings& s) {
    s.thermal->shutter_interval_s = 1.0;
    s.thermal->shutter_frames = 50;
  });
  refused({"detector.shutter_interval: 0.019 s is shorter than frame.frame_time, 0.02 s", "remove it"},
          [](SensorSettings& s) { s.thermal->shutter_interval_s = 19e-3; });
  refused({"detector.shutter_interval", "detector.shutter_temperature"}, [](SensorSettings& s) {
    s.thermal->shutter_k.reset();
    s.thermal->shutter_interval_s = 1.0;
  });
  refused({"detector.shutter_place", "detector.shutter_temperature"}, [](SensorSettings& s) {
    s.thermal->shutter_k.reset();
    s.thermal->shutter_place = ShutterPlace::optics;
  });
  refused({"frame.frame_time: missing", "closes now and then"}, [](SensorSettings& s) {
    s.frame.reset();
    s.thermal->shutter_frames = 50;
  });
}

}  // namespace
}  // namespace radiometry
