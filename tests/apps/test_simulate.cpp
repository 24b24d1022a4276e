// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/mtf/io/png_chunks.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using mtf::Image;
using mtf::io::NamedPlane;

#ifdef __SANITIZE_ADDRESS__
const std::string kLimitMemory;  // its shadow memory needs more than any limit
#else
const std::string kLimitMemory = "ulimit -v 2000000; ";
#endif

Image pattern(std::int64_t width, std::int64_t height, double level, double contrast) {
  Image image(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x)
      image.at(x, y) = static_cast<float>(level + contrast * std::sin(0.3 * static_cast<double>(x * x % 97)) *
                                                      std::cos(0.21 * static_cast<double>(y)));
  return image;
}

void write_scene(const fs::path& path, const std::vector<std::string>& names = {"Y"}, std::int64_t size = 64) {
  const Image plane = pattern(size, size, 5.0, 1.0);
  std::vector<NamedPlane> planes;
  for (const std::string& name : names) planes.push_back({name, plane.view()});
  mtf::io::write_exr(path.string(), planes, {});
}

class Simulate : public testing::Test {
 protected:
  void SetUp() override {
    scratch.add_sensor();
    write_scene(scratch / "scene.exr");
  }
  // The sensor file with lines of [scene] added.
  void add_to_scene(const std::string& lines) const {
    std::string text = read_file(scratch / "sensor.toml");
    text.insert(text.find("[scene]") + 8, lines);
    write_file(scratch / "sensor.toml", text);
  }
  void expect_refused(const std::string& command, int status, std::initializer_list<std::string_view> parts) const {
    SCOPED_TRACE(command);
    const Result r = scratch.run(command);
    expect_error(r, status, parts);
    EXPECT_EQ(lines(r.err), 1U) << r.err;
    for (const auto& entry : fs::directory_iterator(scratch / ""))
      EXPECT_FALSE(says(entry.path().filename().string(), "out")) << entry.path();
  }
  const Scratch scratch;
};

TEST_F(Simulate, WritesImageAndReport) {
  const Result r = scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --report run.json --explain");
  ASSERT_EQ(r.status, 0) << r.err;
  const auto image = mtf::io::read_image((scratch / "out.exr").string());
  EXPECT_EQ(image.planes.front().width(), 16);
  EXPECT_EQ(image.names, std::vector<std::string>{"Y"});
  EXPECT_EQ(image.info.attributes.at("mtf:units"), "W.m^-2.sr^-1");
  const auto json = nlohmann::json::parse(read_file(scratch / "run.json"));
  EXPECT_TRUE(std::string(json["plan"]["method"]).starts_with("fft"));
  EXPECT_EQ(json["plan"]["size"].size(), 2U);
  EXPECT_LE(json["plan"]["predicted_error"].get<double>(), 1e-4);
  EXPECT_EQ(json["config_sha256"].get<std::string>().size(), 64U);
  EXPECT_GT(json["peak_rss_mib"].get<double>(), 1.0);
  EXPECT_TRUE(json["timing_ms"].contains("run"));
  expect_says(r.out, {"merged"});
}

TEST_F(Simulate, ChannelsAndLayers) {
  write_scene(scratch / "rgb.exr", {"R", "G", "B"});
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml rgb.exr -o rgb_out.exr").status, 0);
  EXPECT_EQ(mtf::io::read_image((scratch / "rgb_out.exr").string()).planes.size(), 3U);
  write_scene(scratch / "layers.exr", {"view.mid.X", "view.long.X"});
  expect_error(scratch.run("mtf simulate sensor.toml layers.exr -o x.exr"), 2, {"view.mid"});
  const Result chosen = scratch.run("mtf simulate sensor.toml layers.exr -o y.exr --layer view.mid");
  ASSERT_EQ(chosen.status, 0) << chosen.err;
  EXPECT_EQ(mtf::io::read_image((scratch / "y.exr").string()).names, std::vector<std::string>{"Y"});
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml layers.exr -o z.exr --channel view.long.X").status, 0);
}

TEST_F(Simulate, IntegerScenesNeedTheirScale) {
  const Image plane = pattern(64, 48, 20000.0, 5000.0);
  mtf::io::write_integer((scratch / "counts.png").string(), {{"Y", plane.view()}}, {1.0, 0.0}, {});
  expect_refused("mtf simulate sensor.toml counts.png -o out.exr", 2, {"gain"});
  add_to_scene("gain = 0.001\noffset = 1.5\n");
  const Result r = scratch.run("mtf simulate sensor.toml counts.png -o out.exr");
  ASSERT_EQ(r.status, 0) << r.err;
  const auto image = mtf::io::read_image((scratch / "out.exr").string());
  double mean = 0.0;
  for (std::int64_t i = 0; i < image.planes[0].size(); ++i) mean += image.planes[0].data()[i];
  mean /= static_cast<double>(image.planes[0].size());
  EXPECT_NEAR(mean, 21.5, 0.5);
}

TEST_F(Simulate, EncodedScenesAskForTheirCurve) {
  const Image plane = pattern(64, 48, 20000.0, 5000.0);
  mtf::io::write_integer((scratch / "coded.png").string(), {{"Y", plane.view()}}, {1.0, 0.0}, {});
  io_test::add_chunks(scratch / "coded.png", {io_test::gamma_chunk(50000)});
  add_to_scene("gain = 1.0\noffset = 0.0\n");
  expect_refused("mtf simulate sensor.toml coded.png -o out.exr", 2, {"encoding = \"gamma:2\""});
  add_to_scene("encoding = \"gamma:2\"\n");
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml coded.png -o out.exr --report run.json").status, 0);
  const auto json = nlohmann::json::parse(read_file(scratch / "run.json"));
  EXPECT_EQ(json.at("scene_encoding"), "gamma:2");
  EXPECT_EQ(json.at("scene_encoding_source"), "[scene]");
  double mean = 0.0, expected = 0.0;
  for (std::int64_t i = 0; i < plane.size(); ++i)
    expected += std::pow(std::round(plane.data()[i]), 2) / 65535.0 / static_cast<double>(plane.size());
  const auto image = mtf::io::read_image((scratch / "out.exr").string());
  for (std::int64_t i = 0; i < image.planes[0].size(); ++i)
    mean += image.planes[0].data()[i] / static_cast<double>(image.planes[0].size());
  EXPECT_NEAR(mean, expected, 0.02 * expected);  // borders move a little light
  EXPECT_GT(20000.0 - expected, 0.5 * expected);
  const Result explained = scratch.run("mtf config explain sensor.toml");
  expect_says(explained.out, {"scene.encoding"});
}

TEST_F(Simulate, ValuesBeyondTheEncodingTableAreSaid) {
  Image plane = pattern(64, 48, 100.0, 50.0);
  plane.at(5, 3) = 201.0F;
  mtf::io::write_integer((scratch / "coded.png").string(), {{"Y", plane.view()}}, {1.0, 0.0}, {});
  write_file(scratch / "oecf.csv", "stored,linear\n0,0\n200,20\n");
  add_to_scene("gain = 1.0\noffset = 0.0\nencoding = \"./oecf.csv\"\n");
  for (const char* more : {"", " --roi 0,0,4,4"}) {
    const std::string command = std::string("mtf simulate sensor.toml coded.png -o out.exr") + more;
    expect_error(scratch.run(command), 2,
                 {"coded.png: 1 samples", "oecf.csv", "from 0 to 200", "201", "column 5, row 3"});
  }
  ASSERT_EQ(scratch.run("mkdir b").status, 0);
  EXPECT_EQ(scratch.run("mtf bench sensor.toml coded.png -o b").status, 2);
  const Result filled = scratch.run("mtf simulate sensor.toml coded.png -o filled.exr --nan fill");
  EXPECT_EQ(filled.status, 0) << filled.err;
  expect_says(filled.err, {"the first is 201"});
}

TEST_F(Simulate, SixteenBitOutputSaysItsScale) {
  for (const char* name : {"out16.png", "out16.tif"}) {
    const Result r = scratch.run("mtf simulate sensor.toml scene.exr -o " + std::string(name) + " --report run.json");
    ASSERT_EQ(r.status, 0) << r.err;
    const auto json = nlohmann::json::parse(read_file(scratch / "run.json"));
    const double gain = json["integer_output"]["gain"], offset = json["integer_output"]["offset"];
    ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o float.exr").status, 0);
    const auto file = mtf::io::read_image((scratch / name).string());
    const auto exact = mtf::io::read_image((scratch / "float.exr").string());
    EXPECT_EQ(std::stod(file.info.attributes.at("gain")), gain);
    for (std::int64_t i = 0; i < exact.planes[0].size(); ++i)
      ASSERT_NEAR(gain * file.planes[0].data()[i] + offset, exact.planes[0].data()[i], 0.51 * gain);
  }
  const Result clamped =
      scratch.run("mtf simulate sensor.toml scene.exr -o out16.png --range 4.9:5.1 --report run.json");
  ASSERT_EQ(clamped.status, 0) << clamped.err;
  const auto count = [&] {
    return nlohmann::json::parse(read_file(scratch / "run.json"))["integer_output"]["clamped"].get<int>();
  };
  const int one = count();
  EXPECT_GT(one, 0);
  // So do sequences and regions.
  for (const auto& [more, times] : {std::pair{"f.%d.png --frames 2", 2}, {"roi.png --roi 0,0,16,16", 1}}) {
    const Result r = scratch.run("mtf simulate sensor.toml scene.exr -o " + std::string(more) +
                                 " --range 4.9:5.1 --report run.json");
    expect_says(r.err, {"note: 16-bit output, value = ", std::to_string(times * one) + " samples clamped"});
    EXPECT_EQ(count(), times * one) << more;
  }
}

TEST_F(Simulate, BadPixels) {
  Image plane = pattern(64, 64, 5.0, 1.0);
  plane.at(3, 7) = std::numeric_limits<float>::quiet_NaN();
  plane.at(40, 50) = std::numeric_limits<float>::infinity();
  mtf::io::write_exr((scratch / "bad.exr").string(), {{"Y", plane.view()}}, {});
  expect_refused("mtf simulate sensor.toml bad.exr -o out.exr", 1, {"2 pixels", "NaN", "column 3, row 7"});
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml bad.exr -o filled.exr --nan fill").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml bad.exr -o spoilt.exr --nan propagate --tolerance 1e-3").status, 0);
  const auto filled = mtf::io::read_image((scratch / "filled.exr").string());
  const auto spoilt = mtf::io::read_image((scratch / "spoilt.exr").string());
  int bad = 0;
  for (std::int64_t i = 0; i < filled.planes[0].size(); ++i) {
    EXPECT_TRUE(std::isfinite(filled.planes[0].data()[i]));
    bad += std::isnan(spoilt.planes[0].data()[i]) ? 1 : 0;
  }
  EXPECT_TRUE(std::isnan(spoilt.planes[0].at(0, 1)));    // holds sample (3, 7)
  EXPECT_TRUE(std::isnan(spoilt.planes[0].at(10, 12)));  // holds sample (40, 50)
  EXPECT_FALSE(std::isnan(spoilt.planes[0].at(15, 0)));
  EXPECT_GT(bad, 4);
  EXPECT_LT(bad, 200);
  plane.at(0, 32) = std::numeric_limits<float>::quiet_NaN();
  mtf::io::write_exr((scratch / "bad.exr").string(), {{"Y", plane.view()}}, {});
  write_file(scratch / "round.toml",
             replaced(read_file(scratch / "sensor.toml"), "border = \"reflect\"", "border = \"periodic\""));
  ASSERT_EQ(scratch.run("mtf simulate round.toml bad.exr -o round.exr --nan propagate --tolerance 1e-3").status, 0);
  EXPECT_TRUE(std::isnan(mtf::io::read_image((scratch / "round.exr").string()).planes[0].at(15, 8)));
}

TEST_F(Simulate, BadPixelsReachThroughAFilterOfZeroSum) {
  std::string text = read_file(scratch / "sensor.toml");
  text += "\n[[postsample]]\nkind = \"fir\"\ntaps = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]\n";
  write_file(scratch / "sensor.toml", text);
  Image plane = pattern(128, 128, 5.0, 1.0);
  for (std::int64_t y = 40; y < 80; ++y)
    for (std::int64_t x = 40; x < 80; ++x) plane.at(x, y) = std::numeric_limits<float>::quiet_NaN();
  mtf::io::write_exr((scratch / "hole.exr").string(), {{"Y", plane.view()}}, {});
  const Result r = scratch.run("mtf simulate sensor.toml hole.exr -o out.exr --nan propagate --tolerance 1e-3");
  ASSERT_EQ(r.status, 0) << r.err;
  const auto image = mtf::io::read_image((scratch / "out.exr").string());
  for (std::int64_t y = 9; y <= 20; ++y)
    for (std::int64_t x = 9; x <= 20; ++x) EXPECT_TRUE(std::isnan(image.planes[0].at(x, y))) << x << " " << y;
  EXPECT_FALSE(std::isnan(image.planes[0].at(0, 0)));
}

TEST_F(Simulate, GainIsForFilesThatStateNoQuantity) {
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o first.exr").status, 0);  // states quantity and pitch
  add_to_scene("gain = 0.5\noffset = 100.0\n");
  const Result r = scratch.run("mtf simulate sensor.toml first.exr -o second.exr");
  ASSERT_EQ(r.status, 0) << r.err;
  expect_says(r.err, {"gain and offset"});
  EXPECT_LT(mtf::io::read_image((scratch / "second.exr").string()).planes[0].at(3, 3), 50.0F);
}

TEST_F(Simulate, ReportOnStandardOutputIsTheReportAlone) {
  const Result r = scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --report - --explain --progress json");
  ASSERT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(std::string(nlohmann::json::parse(r.out)["plan"]["method"]).starts_with("fft"));
  expect_says(r.err, {"{\"stage\":\"run\""});
}

TEST_F(Simulate, WarnsBelowTwoSamplesPerPitchAndGoesOn) {
  std::string text = read_file(scratch / "sensor.toml");
  text = replaced(text, "sample = \"3.75 um\"", "sample = \"12.0 um\"");
  write_file(scratch / "sensor.toml", text);
  const Result r = scratch.run("mtf simulate sensor.toml scene.exr -o out.exr");
  EXPECT_EQ(r.status, 0);
  expect_says(r.err, {"samples per pitch"});
}

TEST_F(Simulate, RefusesBeforeAnythingIsWritten) {
  expect_refused("mtf simulate sensor.toml scene.exr -o no/such/folder/out.exr", 1, {"no/such/folder"});
  expect_refused("mtf simulate sensor.toml scene.exr -o scene.exr", 2, {"scene.exr"});
  expect_refused("mtf simulate sensor.toml scene.exr -o ./scene.exr", 2, {"scene.exr"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.jpg", 2, {".jpg"});
  expect_refused("mtf simulate sensor.toml missing.exr -o out.exr", 1, {"missing.exr"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --tolerance 1e-20", 2, {"float32"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --tolerance 0", 2, {"tolerance"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --tolerance -1", 2, {"tolerance"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --tolerance nan", 2, {"tolerance"});
  expect_refused("mtf simulate sensor.toml sensor.toml -o out.exr", 1, {"sensor.toml"});
  write_file(scratch / "empty.exr", "");
  expect_refused("mtf simulate sensor.toml empty.exr -o out.exr", 1, {"empty.exr"});
  write_scene(scratch / "tiny.exr", {"Y"}, 3);
  expect_refused("mtf simulate sensor.toml tiny.exr -o out.exr", 2, {"one detector pixel"});
}

// Two names of one file are one output too many, whatever leads from one to the other.
TEST_F(Simulate, OutputsThatAreOneFileAreRefused) {
  ASSERT_EQ(scratch.run("ln -s o.exr soft.json; echo old > hard.json; ln hard.json h.exr; ln -s . folder").status, 0);
  for (const char* outputs : {"-o o.exr --report o.exr", "-o o.exr --report ./o.exr", "-o o.exr --report soft.json",
                              "-o h.exr --report hard.json", "-o o.exr --report folder/o.exr"}) {
    expect_error(scratch.run(std::string("mtf simulate sensor.toml scene.exr ") + outputs), 2,
                 {"two outputs", "its own name"});
  }
  EXPECT_EQ(read_file(scratch / "hard.json"), "old\n");
  expect_error(scratch.run("mtf simulate sensor.toml scene.exr -o o.exr --memory 1GiB --report o.exr.part"), 2,
               {"where finished tiles"});
  EXPECT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o soft.json.exr --report hard.json").status, 0);
}

TEST_F(Simulate, FullDiskLeavesNothing) {
  write_scene(scratch / "big.exr", {"Y"}, 1024);
  // A limit on the size of files stands in for a full disk.
  expect_error(scratch.run("ulimit -f 8; mtf simulate sensor.toml big.exr -o out.exr"), 1, {"out.exr"});
  for (const auto& entry : fs::directory_iterator(scratch / ""))
    EXPECT_FALSE(says(entry.path().filename().string(), "out")) << entry.path();
}

TEST_F(Simulate, SameBitsForAnyThreads) {
  write_scene(scratch / "big.exr", {"Y"}, 512);
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml big.exr -o one.exr --threads 1").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml big.exr -o two.exr --threads 2").status, 0);
  const auto one = mtf::io::read_image((scratch / "one.exr").string());
  const auto two = mtf::io::read_image((scratch / "two.exr").string());
  for (std::int64_t i = 0; i < one.planes[0].size(); ++i) ASSERT_EQ(one.planes[0].data()[i], two.planes[0].data()[i]);
}

TEST_F(Simulate, WisdomIsKept) {
  const std::string command = "mtf simulate sensor.toml scene.exr -o out.exr --rigor measure --wisdom fft.wisdom";
  ASSERT_EQ(scratch.run(command).status, 0);
  EXPECT_GT(fs::file_size(scratch / "fft.wisdom"), 0U);
  const Result again = scratch.run(command);
  EXPECT_EQ(again.status, 0);
  EXPECT_FALSE(says(again.err, "no FFT wisdom")) << again.err;
}

TEST_F(Simulate, WisdomReplacesNothingElse) {
  for (const std::string name : {"scene.exr", "sensor.toml", "notes.txt", "/dev/zero"}) {
    if (name == "notes.txt") write_file(scratch / name, "mine");
    const std::string before = name.front() == '/' ? "" : read_file(scratch / name);
    const Result r = scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --wisdom " + name);
    EXPECT_EQ(r.status, 2) << name << r.err;
    EXPECT_TRUE(name.front() == '/' || read_file(scratch / name) == before) << name;
    EXPECT_FALSE(fs::exists(scratch / "out.exr"));
  }
  EXPECT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --wisdom out.exr").status, 2);
}

TEST_F(Simulate, ToleranceAdviceCanBeFollowed) {
  std::string text = read_file(scratch / "sensor.toml");
  text += "\n[[postsample]]\nkind = \"fir\"\ntaps = [[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]\n";
  write_file(scratch / "sensor.toml", text);
  const Result refused = scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --tolerance 1e-6");
  ASSERT_EQ(refused.status, 2);
  const std::size_t at = refused.err.find("use ");
  ASSERT_NE(at, std::string::npos) << refused.err;
  const std::string advice = refused.err.substr(at + 4, refused.err.find(' ', at + 4) - at - 4);
  const Result followed = scratch.run("mtf simulate sensor.toml scene.exr -o out.exr --tolerance " + advice);
  EXPECT_EQ(followed.status, 0) << advice << followed.err;
}

TEST_F(Simulate, DefaultToleranceGivesWayWithAWarning) {
  const Image plane = pattern(64, 64, 1e3, 1.0);
  mtf::io::write_exr((scratch / "faint.exr").string(), {{"Y", plane.view()}}, {});
  const Result r = scratch.run("mtf simulate sensor.toml faint.exr -o out.exr");
  EXPECT_EQ(r.status, 0) << r.err;
  expect_says(r.err, {"default tolerance"});
}

TEST_F(Simulate, ScenesThatWouldBecomeHugeAreRefusedAtOnce) {
  std::string text = read_file(scratch / "sensor.toml");
  text = replaced(text, "sample = \"3.75 um\"", "sample = \"0.1 m\"  ");
  text = replaced(text, "format = [640, 512]", "# no format        ");
  write_file(scratch / "sensor.toml", text);
  expect_refused(kLimitMemory + "mtf simulate sensor.toml scene.exr -o out.exr", 2, {"above 2^31"});
}

class RealImages : public testing::Test {
 protected:
  static fs::path shared() {
    const char* set = std::getenv("MTFKIT_SHARED");
    return set != nullptr ? fs::path(set) : fs::path(MTFKIT_SOURCE_DIR) / ".." / "shared";
  }
};

TEST_F(RealImages, ThermalCountsThroughAMicrobolometer) {
  const fs::path folder = shared() / "data/thermal";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no shared data";
  const Scratch scratch;
  int done = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".png") continue;
    const Result r = scratch.run("mtf simulate '" MTFKIT_SOURCE_DIR "/notebooks-data/lwir_microbolometer.toml' '" +
                                 entry.path().string() + "' -o out.exr");
    ASSERT_EQ(r.status, 0) << entry.path() << r.err;
    const auto in = mtf::io::read_image(entry.path().string());
    const auto out = mtf::io::read_image((scratch / "out.exr").string());
    EXPECT_EQ(out.info.attributes.at("mtf:units"), "counts");
    EXPECT_EQ(out.planes[0].width(), in.planes[0].width() / 2);
    double mean_in = 0.0, mean_out = 0.0;
    for (std::int64_t i = 0; i < in.planes[0].size(); ++i) mean_in += in.planes[0].data()[i];
    for (std::int64_t i = 0; i < out.planes[0].size(); ++i) mean_out += out.planes[0].data()[i];
    mean_in /= static_cast<double>(in.planes[0].size());
    mean_out /= static_cast<double>(out.planes[0].size());
    // Even sizes and a reflect border: sampling keeps the sum exactly, whatever the OTF.
    EXPECT_NEAR(mean_out / mean_in, 1.0, 1e-6) << entry.path();
    ++done;
  }
  EXPECT_EQ(done, 8);
}

TEST_F(RealImages, SampleExrFiles) {
  const fs::path folder = shared() / "data/exr_samples";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no shared data";
  const Scratch scratch;
  scratch.add_sensor();
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".exr") continue;
    const std::string name = entry.path().filename().string();
    const Result r = scratch.run("mtf simulate sensor.toml '" + entry.path().string() + "' -o out.exr --nan fill");
    EXPECT_EQ(r.status, name == "Trunks.exr" ? 2 : 0) << name << r.err;  // deep data: refused with the remedy
  }
}

TEST_F(RealImages, DamagedExrFilesAreRefused) {
  const fs::path folder = shared() / "data/exr_damaged";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no shared data";
  const Scratch scratch;
  scratch.add_sensor();
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name == "COPYING" || name == "README.rst") continue;
    const Result r = scratch.run(kLimitMemory + "mtf simulate sensor.toml '" + entry.path().string() + "' -o out.exr");
    EXPECT_TRUE(r.status == 1 || r.status == 2) << name << " " << r.status << r.err;
    EXPECT_EQ(lines(r.err), 1U) << r.err;
    EXPECT_FALSE(fs::exists(scratch / "out.exr"));
  }
}

}  // namespace
}  // namespace apps_test
