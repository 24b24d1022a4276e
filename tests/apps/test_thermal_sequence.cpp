// SPDX-License-Identifier: Apache-2.0

// An uncooled camera over the frames of a sequence: schedules of its temperatures and its gain, and the false offset
// between two closings of its shutter.

#include "radiometry/light/blackbody.h"
#include "tests/apps/thermal_sensor.h"
#include "tests/expect_error.h"

namespace apps_test {
namespace {

class ThermalSequence : public ThermalSensor {
 protected:
  /// Volts of one pixel in each of the frames 0 to `last`.
  std::vector<double> volts(int last, const std::string& more = "") const { return volts_from(0, last, 1, more); }

  std::vector<double> volts_from(int first, int last, int step, const std::string& more) const {
    for (int n = first; n <= last; n += step) write_flat(scratch / ("t." + std::to_string(n) + ".exr"), 300.0F);
    const std::string frames =
        std::to_string(first) + ":" + std::to_string(last) + (step > 1 ? ":" + std::to_string(step) : "");
    const Result r = scratch.run("mtf simulate s.toml t.%d.exr -o o.%d.exr --stage volts --frames " + frames + more);
    EXPECT_EQ(r.status, 0) << r.err;
    std::vector<double> values;
    for (int n = first; n <= last; n += step)
      values.push_back(static_cast<double>(read(scratch / ("o." + std::to_string(n) + ".exr")).at(9, 7)));
    return values;
  }
};

double watts(double temperature_k) {
  return radiometry::band_radiance(radiometry::Flux::watts, 8.0, 14.0, temperature_k);
}

/// F/1, 17 um, 1e5 V/W: 0.9 of the scene and 0.1 of the lens in the cone, the housing around it, less the shutter.
double expected_v(double shutter_k, double housing_k, double lens_k = 295.0) {
  const double cone = mtf::kPi / 5.0;
  const double light = cone * (0.9 * watts(300.0) + 0.1 * watts(lens_k)) + (mtf::kPi - cone) * watts(housing_k);
  return 1e5 * 17e-6 * 17e-6 * (light - mtf::kPi * watts(shutter_k));
}

const double kTolerance = 1e-6 * 1e5 * 17e-6 * 17e-6 * 300.0;  // floats of the light

TEST_F(ThermalSequence, AScheduleOfTemperaturesLensAndGain) {
  camera("");
  write_file(scratch / "schedule.csv",
             "frame,parameter,value\n1,detector.shutter_temperature,297 K\n2,optics.stop_temperature,299 K\n"
             "3,detector.responsivity,2e5\n4,frame.focal_length,36 mm\n5,optics.f_number,2\n");
  const std::vector<double> v = volts(5, " --schedule schedule.csv");
  EXPECT_NEAR(v[0], expected_v(295.0, 295.0), kTolerance);
  EXPECT_NEAR(v[1], expected_v(297.0, 295.0), kTolerance);
  EXPECT_NEAR(v[2], expected_v(297.0, 299.0), kTolerance);
  EXPECT_NEAR(v[3], 2.0 * expected_v(297.0, 299.0), 2.0 * kTolerance);
  EXPECT_NEAR(v[4], v[3], kTolerance);  // the f-number, and so the light, stays
  const double cone = mtf::kPi / 17.0, lens = 0.9 * watts(300.0) + 0.1 * watts(295.0);
  const double slow = cone * lens + (mtf::kPi - cone) * watts(299.0) - mtf::kPi * watts(297.0);
  EXPECT_NEAR(v[5], 2.0 * 1e5 * 17e-6 * 17e-6 * slow, 2.0 * kTolerance);
}

/// The shutter gets warmer at frame 1, the camera knows of it when it closes again at frame 4.
TEST_F(ThermalSequence, TheOffsetIsThatOfTheLastClosing) {
  write_file(scratch / "schedule.csv",
             "frame,parameter,value\n1,detector.shutter_temperature,297 K\n1,optics.stop_temperature,297 K\n");
  for (const char* more : {"", "[microscan]\nsteps = 2\n"}) {
    camera(more, "shutter_temperature", "shutter_frames = 4\nshutter_temperature");
    const std::vector<double> v = volts(5, " --schedule schedule.csv");
    EXPECT_NEAR(v[0], expected_v(295.0, 295.0), kTolerance);
    for (const std::size_t n : {1U, 2U, 3U}) EXPECT_NEAR(v[n], expected_v(295.0, 297.0), kTolerance) << n << more;
    for (const std::size_t n : {4U, 5U}) EXPECT_NEAR(v[n], expected_v(297.0, 297.0), kTolerance) << n << more;
  }
}

/// What the shutter does between two closings is not seen by the pixels, however slow they are.
TEST_F(ThermalSequence, AShutterThatChangesBetweenClosingsLeavesNoLag) {
  camera("[lag]\ntime_constant = \"40 ms\"\n", "shutter_temperature", "shutter_frames = 10\nshutter_temperature");
  write_file(scratch / "schedule.csv", "frame,parameter,value\n4,detector.shutter_temperature,297 K\n");
  const std::vector<double> v = volts(12, " --schedule schedule.csv");
  for (std::size_t n = 0; n < v.size(); ++n)
    EXPECT_NEAR(v[n], expected_v(n < 10 ? 295.0 : 297.0, 295.0), kTolerance) << n;
}

/// Neither where the frames begin nor what is left out of them changes a frame.
TEST_F(ThermalSequence, AFrameIsTheSameInEveryRange) {
  camera("", "shutter_temperature", "shutter_frames = 10\nshutter_temperature");
  write_file(scratch / "schedule.csv",
             "frame,parameter,value\n4,detector.shutter_temperature,297 K\n12,detector.shutter_temperature,299 K\n"
             "17,optics.stop_temperature,296 K\n");
  const auto shutter_k = [](int n) { return n < 10 ? 295.0 : n < 20 ? 297.0 : 299.0; };
  for (const auto& [first, last, step] : {std::tuple{5, 6, 1}, std::tuple{13, 22, 1}, std::tuple{5, 23, 9}}) {
    const std::vector<double> v = volts_from(first, last, step, " --schedule schedule.csv");
    for (int n = first, i = 0; n <= last; n += step, ++i)
      EXPECT_NEAR(v[static_cast<std::size_t>(i)], expected_v(shutter_k(n), n < 17 ? 295.0 : 296.0), kTolerance) << n;
  }
}

/// A schedule may say in the middle of a sequence that the shutter closes now and then.
TEST_F(ThermalSequence, AShutterThatTheScheduleLetsCloseNowAndThen) {
  camera("");
  write_file(scratch / "schedule.csv",
             "frame,parameter,value\n1,detector.shutter_frames,4\n2,detector.shutter_temperature,297 K\n");
  const std::vector<double> v = volts(5, " --schedule schedule.csv");
  for (std::size_t n = 0; n < v.size(); ++n)
    EXPECT_NEAR(v[n], expected_v(n < 4 ? 295.0 : 297.0, 295.0), kTolerance) << n;
}

TEST_F(ThermalSequence, ADriftOfScheduledTemperaturesIsRefused) {
  camera("", "shutter_temperature", "shutter_drift = 5.0\nshutter_frames = 4\nshutter_temperature");
  write_file(scratch / "schedule.csv", "frame,parameter,value\n0,optics.temperature,297 K\n");
  volts(2, " --schedule schedule.csv");  // of frame 0, from which the drift counts
  for (const std::string name : {"detector.shutter_temperature", "optics.stop_temperature", "optics.temperature"}) {
    write_file(scratch / "schedule.csv", "frame,parameter,value\n2," + name + ",297 K\n");
    const Result r =
        scratch.run("mtf simulate s.toml t.%d.exr -o o.%d.exr --stage volts --frames 0:2 --schedule schedule.csv");
    EXPECT_NE(r.status, 0);
    for (const std::string& part : {"schedule.csv:2: error: " + name, std::string("remove shutter_drift")})
      expect_says(r.err, {part});
  }
}

TEST_F(ThermalSequence, ADriftShowsAsAFalseOffsetUntilTheNextClosing) {
  camera("", "shutter_temperature", "shutter_drift = 5.0\nshutter_interval = \"60 ms\"\nshutter_temperature");
  const std::vector<double> v = volts(7);
  for (std::size_t n = 0; n < v.size(); ++n) {
    const double now_k = 295.0 + 0.1 * static_cast<double>(n), closed_k = 295.0 + 0.1 * static_cast<double>(n / 3 * 3);
    EXPECT_NEAR(v[n], expected_v(closed_k, now_k, now_k), kTolerance) << n;
  }
  expect_says(scratch.run("mtf config explain s.toml").out, {"every 0.06 s", "5 K/s"});
}

}  // namespace
}  // namespace apps_test
