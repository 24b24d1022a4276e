// SPDX-License-Identifier: Apache-2.0
// `mtf render` and the line that it prints for `mtf simulate`.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command.h"

namespace {

using apps_test::read_file, apps_test::Result, apps_test::Scratch, apps_test::write_file;

const std::string kScene = R"(schema = 1
[place]
latitude = "40 deg"
longitude = "0 deg"
altitude = "0 m"
[time]
start = 2026-06-21T12:00:00Z
end = 2026-06-22T12:00:00Z
step = "2 h"
[weather]
air_temperature = "288 K"
wind_speed = "2 m/s"
direct_normal = "700 W/m2"
diffuse_horizontal = "80 W/m2"
longwave_down = "320 W/m2"
vapour_pressure = "10 hPa"
[[mesh]]
name = "plates"
file = "plates.obj"
[[region]]
mesh = "plates"
group = "soil"
temperature = "290 K"
[[region]]
mesh = "plates"
group = "target"
temperature = "310 K"
[camera]
position = ["3 m", "-40 m", "4 m"]
look_at = ["0 m", "0 m", "0.6 m"]
)";
const std::string kPlates =
    "v -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\nv -0.5 0 0.2\nv 0.5 0 0.2\nv 0.5 0 1.2\nv -0.5 0 1.2\n"
    "g soil\nf 1 2 3 4\ng target\nf 5 6 7 8\n";
const std::string kSensor = R"(schema = 1
name = "uncooled"
[frame]
focal_length = "50 mm"
pitch = "12 um"
format = [64, 48]
[scene]
quantity = "temperature"
[optics]
f_number = 1.2
stop_temperature = "293 K"
[band]
wavelength = ["8 um", "13 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.85
[detector]
kind = "thermal"
absorptance = 0.8
responsivity = 1e5
shutter_temperature = "293 K"
netd = "30 mK"
netd_f_number = 1.0
netd_transmission = 1.0
netd_temperature = "300 K"
[adc]
bits = 14
volts_per_count = "0.05 uV"
offset = 4000
)";
const std::string kAir = R"([atmosphere]
pressure = "1013 hPa"
temperature = "288 K"
relative_humidity = 0.5
range = "1 km"
)";

class RenderCommand : public testing::Test {
 protected:
  RenderCommand() {
    write_file(scratch_ / "scene.toml", kScene);
    write_file(scratch_ / "plates.obj", kPlates);
    write_file(scratch_ / "sensor.toml", kSensor);
    write_file(scratch_ / "airy.toml", kSensor + kAir);
  }
  Scratch scratch_;
};

/// The command after "next: ".
std::string next(const std::string& text) {
  const auto from = text.find("next: ");
  return from == std::string::npos ? "false" : text.substr(from + 6);
}

TEST_F(RenderCommand, SaysACommandThatWorks) {
  for (const std::string sensor : {"sensor.toml", "airy.toml"}) {
    const Result made = scratch_.run("mtf render scene.toml " + sensor + " -o scene.exr");
    ASSERT_EQ(made.status, 0) << made.err;
    const Result then = scratch_.run(next(made.out));
    EXPECT_EQ(then.status, 0) << then.err;
    EXPECT_EQ(then.err.find("says quantity"), std::string::npos) << then.err;
  }
  const Result twice = scratch_.run("mtf simulate airy.toml scene.exr -o image.exr");
  EXPECT_EQ(twice.status, 2);
  EXPECT_NE(twice.err.find("--without-path"), std::string::npos) << twice.err;
}

TEST_F(RenderCommand, TheSceneExplainsTheSkyThatPicturesHave) {
  write_file(scratch_ / "scene.toml", kScene + "[atmosphere]\nmodel = \"mid_latitude_summer\"\n");
  const Result made = scratch_.run("mtf render scene.toml sensor.toml -o scene.exr --format json");
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string sky = nlohmann::json::parse(made.out).at("closures").at("sky");
  EXPECT_NE(sky.find("clear sky of the air"), std::string::npos) << sky;
  const Result explained = scratch_.run("mtf scene explain scene.toml");
  EXPECT_NE(explained.out.find("sky: " + sky), std::string::npos) << explained.out;
}

TEST_F(RenderCommand, RefusesACameraBesideTheFacetsAndBelowThem) {
  const Result low = scratch_.run("mtf render scene.toml sensor.toml --position 3,-40,-4 -o scene.exr");
  EXPECT_EQ(low.status, 2);
  EXPECT_NE(low.err.find("below the ground"), std::string::npos) << low.err;
}

}  // namespace
