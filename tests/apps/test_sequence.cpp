// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using mtf::Image;
using mtf::io::NamedPlane;

constexpr const char* kSensor = R"(schema = 1
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "10 ms"
[scene]
sample = "7.5 um"
quantity = "radiance"
[optics]
f_number = 2.0
wavelength = "4 um"
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 1.0
[[presample]]
kind = "jitter"
rms = "8 urad"
[[postsample]]
kind = "fir"
label = "sharpen"
taps = [[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]
)";

Image pattern(std::int64_t width, std::int64_t height, double level, double phase) {
  Image image(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x)
      image.at(x, y) = static_cast<float>(level + std::sin(0.3 * static_cast<double>(x * x % 97) + phase) *
                                                      std::cos(0.21 * static_cast<double>(y)));
  return image;
}

void write_scene(const fs::path& path, std::int64_t width, double level, double phase,
                 const std::vector<std::string>& names = {"Y"}) {
  const Image plane = pattern(width, 48, level, phase);
  std::vector<NamedPlane> planes;
  for (const std::string& name : names) planes.push_back({name, plane.view()});
  mtf::io::write_exr(path.string(), planes, {});
}

std::string frame_name(const std::string& start, int frame) {
  const std::string digits = std::to_string(frame);
  return start + "." + std::string(4 - digits.size(), '0') + digits + ".exr";
}

class Sequence : public testing::Test {
 protected:
  void SetUp() override { write_file(scratch / "sensor.toml", kSensor); }
  void add_frames(int first, int last) const {
    for (int frame = first; frame <= last; ++frame)
      write_scene(scratch / frame_name("frame", frame), 64, 5.0 + frame % 3, 0.1 * frame);
  }
  void expect_same_image(const std::string& a, const std::string& b) const {
    const auto first = mtf::io::read_image((scratch / a).string()),
               second = mtf::io::read_image((scratch / b).string());
    ASSERT_EQ(first.planes[0].size(), second.planes[0].size());
    for (std::int64_t i = 0; i < first.planes[0].size(); ++i)
      ASSERT_EQ(first.planes[0].data()[i], second.planes[0].data()[i]) << a << " " << b << " " << i;
  }
  std::size_t outputs() const {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(scratch / ""))
      count += entry.path().filename().string().starts_with("out") ? 1U : 0U;
    return count;
  }
  void expect_refused(const std::string& command, int status, std::initializer_list<std::string_view> parts) const {
    SCOPED_TRACE(command);
    const Result r = scratch.run("mtf --quiet simulate sensor.toml " + command);
    expect_error(r, status, parts);
    EXPECT_EQ(lines(r.err), 1U) << r.err;
  }
  nlohmann::json report(const std::string& command) const {
    const Result r = scratch.run("mtf simulate sensor.toml " + command + " --report run.json");
    EXPECT_EQ(r.status, 0) << r.err;
    return nlohmann::json::parse(read_file(scratch / "run.json"));
  }
  const Scratch scratch;
};

TEST_F(Sequence, EveryFrameAsIfAlone) {
  add_frames(1, 5);
  const auto json = report("frame.%04d.exr -o out.%04d.exr --tolerance 1e-3");
  EXPECT_EQ(json["sequence"]["frames"], 5);
  EXPECT_EQ(json["sequence"]["plans_compiled"], 1);
  EXPECT_EQ(json["sequence"]["plans_updated"], 0);
  EXPECT_GT(json["sequence"]["fps"].get<double>(), 0.0);
  EXPECT_LE(json["sequence"]["predicted_error"].get<double>(), 1e-3);
  for (int frame = 1; frame <= 5; ++frame) {
    const Result alone =
        scratch.run("mtf simulate sensor.toml " + frame_name("frame", frame) + " -o alone.exr --tolerance 1e-4");
    ASSERT_EQ(alone.status, 0) << alone.err;
    const auto a = mtf::io::read_image((scratch / "alone.exr").string());
    const auto b = mtf::io::read_image((scratch / frame_name("out", frame)).string());
    EXPECT_EQ(b.info.attributes.at("mtf:frame"), std::to_string(frame));
    ASSERT_EQ(a.planes[0].size(), b.planes[0].size());
    for (std::int64_t i = 0; i < a.planes[0].size(); ++i)
      ASSERT_NEAR(a.planes[0].data()[i], b.planes[0].data()[i], 5e-3);
  }
}

TEST_F(Sequence, SameBitsForAnyThreads) {
  add_frames(1, 9);
  write_file(scratch / "s.csv",
             "frame,parameter,value\n3,jitter.rms,20 urad\n5,sharpen.taps,\"[[0.5, 0, 0.5]]\"\n"
             "6,jitter.rms,9 urad\n7,optics.f_number,4\n");
  for (const std::string threads : {"1", "2", "5"}) {
    const auto json = report("frame.%04d.exr -o out" + threads + ".%04d.exr --schedule s.csv --threads " + threads);
    EXPECT_EQ(json["sequence"]["schedule_changes"], 4);
    EXPECT_EQ(json["sequence"]["plans_updated"].get<int>() + json["sequence"]["plans_compiled"].get<int>(), 5);
  }
  for (int frame = 1; frame <= 9; ++frame)
    for (const std::string threads : {"2", "5"})
      expect_same_image(frame_name("out1", frame), frame_name("out" + threads, frame));
}

// What a schedule makes of the sensor is what another sensor file would be.
TEST_F(Sequence, ScheduleOverAStillScene) {
  write_scene(scratch / "scene.exr", 64, 5.0, 0.0);
  write_file(scratch / "s.csv", "frame,parameter,value\n10,jitter.rms,8 urad\n20,jitter.rms,30 urad\n");
  const auto json = report("scene.exr -o out.%04d.exr --schedule s.csv");
  EXPECT_EQ(json["sequence"]["frames"], 2);
  EXPECT_EQ(json["sequence"]["plans_compiled"], 1);
  EXPECT_EQ(json["sequence"]["plans_updated"], 1);
  EXPECT_EQ(outputs(), 2U);
  std::string text = kSensor;
  text = replaced(text, "8 urad", "30 urad");
  write_file(scratch / "sensor.toml", text);
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o alone.exr").status, 0);
  const auto a = mtf::io::read_image((scratch / "alone.exr").string());
  const auto b = mtf::io::read_image((scratch / "out.0020.exr").string());
  for (std::int64_t i = 0; i < a.planes[0].size(); ++i) ASSERT_NEAR(a.planes[0].data()[i], b.planes[0].data()[i], 1e-3);
  EXPECT_EQ(b.info.attributes.at("mtf:schedule"), "jitter.rms = 30 urad");
}

// Angular samples follow the focal length; another pitch is another detector grid.
TEST_F(Sequence, ChangesOfTheGridCompileAnew) {
  std::string text = kSensor;
  text = replaced(text, "sample = \"7.5 um\"", "ifov = \"75 urad\"");
  write_file(scratch / "sensor.toml", text);
  write_scene(scratch / "scene.exr", 64, 5.0, 0.0);
  add_frames(1, 3);
  write_file(scratch / "s.csv", "frame,parameter,value\n2,frame.focal_length,200 mm\n3,frame.pitch,30 um\n");
  for (const std::string scene : {"scene.exr", "frame.%04d.exr"}) {
    const auto json = report(scene + " -o out.%04d.exr --schedule s.csv --frames 1:3");
    EXPECT_EQ(json["sequence"]["plans_compiled"], 3);
    const std::array<std::int64_t, 3> widths{32, 64, 32};
    for (int frame = 1; frame <= 3; ++frame)
      EXPECT_EQ(mtf::io::read_info((scratch / frame_name("out", frame)).string()).width,
                widths[static_cast<std::size_t>(frame - 1)]);
  }
}

// A frame on a far higher level needs a plan of its own, or says that none will do.
TEST_F(Sequence, ThePromiseIsKeptForEveryFrame) {
  add_frames(1, 2);
  write_scene(scratch / "frame.0003.exr", 64, 5e3, 0.0);
  const auto json = report("frame.%04d.exr -o out.%04d.exr --tolerance 1e-2");
  EXPECT_EQ(json["sequence"]["plans_compiled"], 2);
  expect_refused("frame.%04d.exr -o out.%04d.exr --tolerance 1e-4", 2, {"frame 3: ", "can be kept"});
  const Result loosened = scratch.run("mtf simulate sensor.toml frame.%04d.exr -o out.%04d.exr");
  EXPECT_EQ(loosened.status, 0);
  expect_says(loosened.err, {"frame 3:", "default tolerance"});
  Image flat(64, 48);
  std::fill_n(flat.data(), flat.size(), 3.0F);
  for (const char* name : {"flat.0001.exr", "flat.0003.exr"})
    mtf::io::write_exr((scratch / name).string(), {{"Y", flat.view()}}, {});
  write_scene(scratch / "flat.0002.exr", 64, 5.0, 0.0);
  EXPECT_EQ(report("flat.%04d.exr -o out.%04d.exr")["sequence"]["plans_compiled"], 2);
}

TEST_F(Sequence, FramesAreFoundAndChosen) {
  for (const int frame : {10, 20, 30, 100}) write_scene(scratch / frame_name("frame", frame), 64, 5.0, 0.0);
  write_scene(scratch / "frame.5.exr", 64, 5.0, 0.0);      // not of this pattern
  write_scene(scratch / "frame.00020.exr", 64, 5.0, 0.0);  // neither
  expect_refused("frame.%04d.exr -o out.%04d.exr", 1, {"frame 40 is missing", "frame.0040.exr", "--frames 10:30"});
  expect_refused("frame.%04d.exr -o out.%04d.exr --frames 10:20", 1, {"frame 11 is missing"});
  expect_refused("none.%04d.exr -o out.%04d.exr", 1, {"no file none.%04d.exr"});
  expect_refused("no/frame.%04d.exr -o out.%04d.exr", 1, {"cannot list no/"});
  EXPECT_EQ(outputs(), 0U);
  EXPECT_EQ(report("frame.%04d.exr -o out.%d.exr --frames 10:30:10")["sequence"]["last"], 30);
  EXPECT_EQ(outputs(), 3U);
  EXPECT_TRUE(fs::exists(scratch / "out.30.exr"));
  EXPECT_EQ(report("./frame.%d.exr -o 100%%.%06d.exr")["sequence"]["frames"], 1);
  EXPECT_TRUE(fs::exists(scratch / "100%.000005.exr"));
}

TEST_F(Sequence, AFrameOfAnotherKindEndsItAndLeavesWholeOnes) {
  for (const std::string other : {"size", "channels", "samples", "damaged"}) {
    add_frames(1, 6);
    const std::string bad = (scratch / "frame.0004.exr").string();
    if (other == "size") write_scene(bad, 80, 5.0, 0.0);
    if (other == "channels") write_scene(bad, 64, 5.0, 0.0, {"R", "G", "B"});
    if (other == "samples")
      mtf::io::write_exr(bad, {{"Y", pattern(64, 48, 5.0, 0.0).view()}},
                         {.text = {}, .pairs = {{"mtf:pixelPitch", {5e-6, 5e-6}}}, .lists = {}, .history = {}});
    if (other == "damaged") fs::resize_file(bad, fs::file_size(bad) / 2);
    expect_refused("frame.%04d.exr -o out.%04d.exr", 1,
                   {"frame 4: ", "frame.0004.exr", other == "damaged" ? "" : other});
    for (int frame = 1; frame <= 3; ++frame)
      EXPECT_EQ(mtf::io::read_image((scratch / frame_name("out", frame)).string()).planes.size(), 1U) << other;
    EXPECT_FALSE(fs::exists(scratch / "out.0004.exr")) << other;
    for (const auto& entry : fs::directory_iterator(scratch / ""))
      EXPECT_FALSE(says(entry.path().string(), ".tmp")) << entry.path();
  }
}

TEST_F(Sequence, MisuseIsSaidBeforeAnythingIsWritten) {
  add_frames(1, 2);
  write_scene(scratch / "scene.exr", 64, 5.0, 0.0);
  write_file(scratch / "s.csv", "frame,parameter,value\n1,jitter.rms,9 urad\n");
  write_file(scratch / "bad.csv", "frame,parameter,value\n1,jiter.rms,9 urad\n");
  expect_refused("frame.%04d.exr -o out.exr", 2, {"needs a frame number", "out.%04d.exr"});
  expect_refused("scene.exr -o out.%04d.exr", 2, {"one image", "--frames N", "--schedule"});
  expect_refused("scene.exr -o out.exr --frames 2", 2, {"needs a frame number"});
  expect_refused("frame.%04d.%d.exr -o out.%04d.exr", 2, {"one frame number"});
  expect_refused("%d/frame.exr -o out.%04d.exr", 2, {"not of a folder"});
  expect_refused("frame.%099d.exr -o out.%04d.exr", 2, {"digits"});
  expect_refused("frame.%04d.exr -o frame.%04d.exr", 2, {"frame of the input"});
  expect_refused("frame.%04d.exr -o ./frame.%04d.exr", 2, {"frame of the input"});
  expect_refused("frame.%04d.exr -o out.%04d.exr --report out.0002.exr", 2, {"an output frame"});
  expect_refused("frame.%04d.exr -o no/out.%04d.exr", 1, {"there is no folder"});
  expect_refused("frame.%04d.exr -o out.%04d.png", 2, {"--range"});
  expect_refused("frame.%04d.exr -o out.%04d.jpg", 2, {".exr"});
  expect_refused("scene.exr -o out.%04d.exr --schedule bad.csv", 2, {"bad.csv:2:", "did you mean jitter.rms?"});
  expect_refused("scene.exr -o out.%04d.exr --schedule no.csv", 1, {"no.csv"});
  for (const std::string range : {"0", "2:1", "1:2:0", "1:2:3:4", "a:b", "-1:2", "1:9999999999"})
    expect_refused("frame.%04d.exr -o out.%04d.exr --frames " + range, 2, {"--frames"});
  expect_refused("scene.exr -o out.%04d.exr --schedule s.csv --frames 0:999999999", 2, {"--frames"});
  EXPECT_EQ(outputs(), 0U);
  ASSERT_EQ(scratch.run("ln -s l.0002.exr l.0001.exr; ln -s m.0001.exr report.json").status, 0);
  for (const char* linked : {"-o l.%04d.exr", "-o m.%04d.exr --report report.json"}) {
    const Result r = scratch.run(std::string("mtf simulate sensor.toml frame.%04d.exr ") + linked);
    EXPECT_EQ(r.status, 2) << r.err;
    EXPECT_FALSE(fs::exists(scratch / "l.0002.exr") || fs::exists(scratch / "m.0001.exr"));
  }
  EXPECT_EQ(scratch.run("mtf --quiet simulate sensor.toml frame.%04d.exr -o out.%04d.png --range 0:20").status, 0);
  EXPECT_EQ(outputs(), 2U);
}

TEST_F(Sequence, StoppingItLeavesWholeFramesOnly) {
  write_scene(scratch / "scene.exr", 256, 5.0, 0.0);
  write_file(scratch / "s.csv", "frame,parameter,value\n1,jitter.rms,9 urad\n");
  const Result r = scratch.run(
      "mtf simulate sensor.toml scene.exr -o out.%06d.exr --schedule s.csv --frames 1:999999 &\n"
      "pid=$!\nwhile [ ! -e out.000003.exr ] && kill -0 $pid; do sleep 0.01; done\nkill -INT $pid\nwait $pid\n");
  EXPECT_EQ(r.status, 130) << r.err;
  EXPECT_GE(outputs(), 2U);
  for (const auto& entry : fs::directory_iterator(scratch / "")) {
    const std::string path = entry.path().string();
    EXPECT_FALSE(says(path, ".tmp")) << path;
    if (path.find("out.") != std::string::npos) {
      EXPECT_EQ(mtf::io::read_image(path).planes.size(), 1U);
    }
  }
}

TEST_F(Sequence, BadPixelsAndProgress) {
  add_frames(1, 3);
  Image holed = pattern(64, 48, 5.0, 0.0);
  holed.at(7, 9) = std::nanf("");
  mtf::io::write_exr((scratch / "frame.0002.exr").string(), {{"Y", holed.view()}}, {});
  expect_refused("frame.%04d.exr -o out.%04d.exr", 1, {"frame 2: ", "column 7, row 9"});
  const Result r =
      scratch.run("mtf simulate sensor.toml frame.%04d.exr -o out.%04d.exr --nan propagate --progress json");
  ASSERT_EQ(r.status, 0) << r.err;
  std::istringstream text(r.err);
  double share = 0.0;
  for (std::string line; std::getline(text, line);) {
    if (!line.starts_with('{')) continue;
    const auto json = nlohmann::json::parse(line);
    EXPECT_GT(json["share"].get<double>(), share);
    share = json["share"];
  }
  EXPECT_EQ(share, 1.0);
  const auto image = mtf::io::read_image((scratch / "out.0002.exr").string());
  EXPECT_TRUE(std::isnan(image.planes[0].at(3, 4)));
  EXPECT_FALSE(std::isnan(image.planes[0].at(30, 20)));
}

}  // namespace
}  // namespace apps_test
