// SPDX-License-Identifier: Apache-2.0
// `mtf fly`: frames, what it refuses, and what an interrupt leaves.

#include <filesystem>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "command.h"
#include "mtf/io/exr/spectral_exr.h"
#include "mtf/io/image_io.h"
#include "plates_case.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

const std::string kScene =
    place_and_weather("start = 2026-06-21T12:00:00Z\nend = 2026-06-21T14:00:00Z\nstep = \"10 min\"\n") +
    R"([[material]]
name = "steel"
solar_absorptance = 0.7
emissivity = 0.9
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "2 mm" }]
)" + soil_and_target("", "material = \"steel\"\n") +
    R"([camera]
path = "flight.csv"
)";
const std::string kFlight =
    "time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n0,3,-40,6,0,0,0.6\n0.4,-3,-30,4,0,0,0.6\n";
const std::string kSensor = uncooled("[noise]\nseed = 1\n");

class FlyCommand : public testing::Test {
 protected:
  FlyCommand() {
    write_file(scratch_ / "scene.toml", kScene);
    write_file(scratch_ / "plates.obj", kGroundAndTarget);
    write_file(scratch_ / "flight.csv", kFlight);
    write_file(scratch_ / "sensor.toml", kSensor);
  }
  void refused(const std::string& command, std::string_view part) const {
    SCOPED_TRACE(command);
    expect_error(scratch_.run("mtf fly " + command), 2, {part});
  }
  Scratch scratch_;
};

TEST_F(FlyCommand, SaysWhenWholeNumbersHardlyShowOrAreClamped) {
  const Result dark = scratch_.run("mtf fly scene.toml sensor.toml --frames 0:1 -o frame.%02d.png");
  expect_says(dark.out, {"hardly show", "--range "});
  const Result clamped = scratch_.run("mtf fly scene.toml sensor.toml --frames 0:1 --range 0:1 -o frame.%02d.png");
  expect_says(clamped.out, {"100 %", "clamped"});
  const Result json =
      scratch_.run("mtf fly scene.toml sensor.toml --frames 0:1 --range 0:1 -o f.%02d.png --format json");
  const nlohmann::json values = nlohmann::json::parse(json.out).at("values");
  EXPECT_EQ(values.at("clamped"), values.at("samples"));
}

TEST_F(FlyCommand, RefusesATemperatureThatADriftStatesToo) {
  const std::string drifts = "shutter_frames = 9\nshutter_drift = 0.1\nshutter_temperature";
  write_file(scratch_ / "drift.toml",
             replaced(replaced(kSensor, "format", "frame_time = \"20 ms\"\nformat"), "shutter_temperature", drifts));
  write_file(scratch_ / "changes.csv", "frame,parameter,value\n2,optics.stop_temperature,299 K\n");
  refused("scene.toml drift.toml --schedule changes.csv --frames 0:3", "shutter_drift states too");
}

TEST_F(FlyCommand, WritesTheFramesOfThePath) {
  const Result made = scratch_.run("mtf fly scene.toml sensor.toml -o frame.%02d.exr");
  ASSERT_EQ(made.status, 0) << made.err;
  expect_says(made.out, {"11 frames", "the heat balance took", "left out: ", "\nvalues "});
  EXPECT_FALSE(says(made.out, "hardly show")) << made.out;
  for (const std::string name : {"frame.00.exr", "frame.10.exr"})
    EXPECT_EQ(mtf::io::read_info((scratch_ / name).string()).width, 64) << name;
  // A frame does not depend on those before it.
  ASSERT_EQ(scratch_.run("mtf fly scene.toml sensor.toml --frames 6:8:2 -o own.%02d.exr").status, 0);
  const mtf::Image with = mtf::io::read_plane((scratch_ / "frame.08.exr").string(), {"Y"}),
                   own = mtf::io::read_plane((scratch_ / "own.08.exr").string(), {"Y"});
  for (std::int64_t i = 0; i < with.size(); ++i) ASSERT_NEAR(with.data()[i], own.data()[i], 1.0F);
}

TEST_F(FlyCommand, ReportsAsJson) {
  const Result made = scratch_.run("mtf fly scene.toml sensor.toml --seconds 0.2 --format json --report fly.json");
  ASSERT_EQ(made.status, 0) << made.err;
  const nlohmann::json json = nlohmann::json::parse(made.out);
  EXPECT_EQ(json.at("frames"), 6);
  EXPECT_GE(json.at("fps").at("median").get<double>(), json.at("fps").at("least").get<double>());
  EXPECT_GT(json.at("stage_ms").at("pixels").at("min").get<double>(), 0.0);
  EXPECT_EQ(json.at("left_out").size(), 3u);
  EXPECT_EQ(nlohmann::json::parse(read_file(scratch_ / "fly.json")), json);
}

TEST_F(FlyCommand, FollowsAScheduleOfAirAndOptics) {
  write_file(scratch_ / "airy.toml",
             kSensor + "[atmosphere]\nmodel = \"mid_latitude_summer\"\nhaze = \"rural\"\nrange = \"1 km\"\n");
  write_file(
      scratch_ / "changes.csv",
      "frame,parameter,value\n2,optics.f_number,1.6\n4,frame.focal_length,16 mm\n5,atmosphere.visibility,5 km\n");
  const Result made =
      scratch_.run("mtf fly scene.toml airy.toml --schedule changes.csv --frames 0:7 -o frame.%02d.exr");
  ASSERT_EQ(made.status, 0) << made.err;
  expect_says(made.out, {"made 2 times"});
}

// A camera that turns from the scene into the sky and comes so near to a wall that it sees nothing else.
TEST_F(FlyCommand, DrawsViewsWithoutContrastAndWithoutFacets) {
  write_file(scratch_ / "flight.csv",
             "time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n0,0,-40,4,0,0,0.6\n0.1,0,-40,4,0,-35,9\n"
             "0.2,0,-3,0.7,0,0,0.7\n0.3,0,-0.2,0.7,0,0,0.7\n");
  const Result made = scratch_.run("mtf fly scene.toml sensor.toml -o frame.%02d.exr");
  EXPECT_EQ(made.status, 0) << made.err;
  expect_says(made.out, {"8 frames"});
  const Result asked = scratch_.run("mtf fly scene.toml sensor.toml --tolerance 1e-4");
  EXPECT_EQ(asked.status, 0) << asked.err;
  expect_says(asked.out, {"8 frames"});
}

TEST_F(FlyCommand, FramesSayWhenAndWhereFrom) {
  ASSERT_EQ(scratch_.run("mtf fly scene.toml sensor.toml --frames 5:5 -o frame.%02d.exr").status, 0);
  auto says = mtf::io::read_info((scratch_ / "frame.05.exr").string()).attributes;
  EXPECT_EQ(says["mtf:cameraPosition"], "0 -35 5");
  EXPECT_TRUE(says["mtf:cameraAhead"].starts_with("0 0.9")) << says["mtf:cameraAhead"];
  EXPECT_TRUE(says["mtf:time"].starts_with("20")) << says["mtf:time"];
}

// A path that ends below the ground is refused with its first frame.
TEST_F(FlyCommand, LooksAtTheWholePathFirst) {
  write_file(scratch_ / "flight.csv",
             "time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n0,3,-40,6,0,0,0.6\n0.4,3,-30,-6,0,0,1\n");
  refused("scene.toml sensor.toml -o frame.%02d.exr", "frame 6 (");
  EXPECT_TRUE(std::filesystem::exists(scratch_ / "frame.00.exr"));
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "frame.01.exr"));
}

// Air, a camera that sinks, and the ground beyond: a frame alone is that of the flight.
TEST_F(FlyCommand, AFrameOfADescentIsThatFrameAlone) {
  write_file(scratch_ / "airy.toml",
             kSensor + "[atmosphere]\nmodel = \"mid_latitude_summer\"\nhaze = \"rural\"\nrange = \"1 km\"\n");
  write_file(scratch_ / "flight.csv",
             "time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n0,0,-40,12,0,0,3\n0.4,0,-20,1,0,0,1\n");
  ASSERT_EQ(scratch_.run("mtf fly scene.toml airy.toml -o frame.%02d.exr").status, 0);
  ASSERT_EQ(scratch_.run("mtf fly scene.toml airy.toml --frames 9:9 -o own.%02d.exr").status, 0);
  const mtf::Image with = mtf::io::read_plane((scratch_ / "frame.09.exr").string(), {"Y"}),
                   own = mtf::io::read_plane((scratch_ / "own.09.exr").string(), {"Y"});
  for (std::int64_t i = 0; i < with.size(); ++i) ASSERT_NEAR(with.data()[i], own.data()[i], 2.0F) << i;
}

TEST_F(FlyCommand, RefusesWhatCannotFly) {
  std::filesystem::create_symlink(scratch_ / "sensor.toml", scratch_ / "link.03.exr");
  refused("scene.toml sensor.toml -o link.%02d.exr", "is a link");
  for (const char* input : {"scene.toml", "sensor.toml", "flight.csv", "plates.obj"}) {
    const std::string before = read_file(scratch_ / input);
    refused("scene.toml sensor.toml --report " + std::string(input), "is the input");
    EXPECT_EQ(read_file(scratch_ / input), before);
  }
  refused("scene.toml sensor.toml -o frame.%02d.exr --report frame.04.exr", "one of the frames");
  refused("scene.toml sensor.toml -o frame.%02d.txt", ".exr, .png or .tif");
  refused("scene.toml sensor.toml --light-every 1e-300", "--light-every");
  refused("scene.toml sensor.toml --heat-tolerance '1e-12 K'", "--heat-tolerance");
  refused("scene.toml sensor.toml -o frame.png", "number into the name");
  refused("scene.toml sensor.toml --frames 0:99", "no place at");
  refused("scene.toml sensor.toml --frames 0:1 --seconds 2", "how many frames");
  refused("scene.toml sensor.toml --rate 0", "--rate");
  refused("scene.toml sensor.toml --time 2027-01-01T00:00:00Z", "outside of the run");
  write_file(scratch_ / "flight.csv",
             "time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n0,3,-40,-9,0,0,1\n");
  refused("scene.toml sensor.toml", "below");
  std::string still = kScene;
  still = replaced(still, "path = \"flight.csv\"",
                   "position = [\"3 m\", \"-40 m\", \"4 m\"]\nlook_at = [\"0 m\", \"0 m\", \"1 m\"]");
  write_file(scratch_ / "scene.toml", still);
  refused("scene.toml sensor.toml", "stands still");
  still.resize(still.find("[camera]"));
  write_file(scratch_ / "scene.toml", still);
  refused("scene.toml sensor.toml --frames 0:1", "[camera]: missing");
}

TEST_F(FlyCommand, AnInterruptLeavesWholeFrames) {
  const Result made = scratch_.run(
      "mtf fly scene.toml sensor.toml --rate 1e5 --frames 0:39999 -o frame.%05d.exr & pid=$!\n"
      "while kill -0 $pid 2>/dev/null; do [ -e frame.00003.exr ] && kill -INT $pid && break; sleep 0.02; done\nwait "
      "$pid");
  EXPECT_EQ(made.status, 130) << made.err;
  expect_says(made.err, {"frames are finished"});
  std::size_t frames = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scratch_ / "")) {
    const std::string name = entry.path().filename().string();
    EXPECT_FALSE(says(name, ".tmp.")) << name;
    if (!name.starts_with("frame.")) continue;
    ++frames;
    EXPECT_EQ(mtf::io::read_plane(entry.path().string(), {"Y"}).width(), 64) << name;
  }
  EXPECT_GE(frames, 4u);
}

}  // namespace
}  // namespace apps_test
