// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using mtf::Image;

class SimulateTiles : public testing::Test {
 protected:
  void SetUp() override {
    scratch.add_sensor();
    std::string text = read_file(scratch / "sensor.toml");
    text = replaced(text, "format = [640, 512]", "# no format        ");
    write_file(scratch / "sensor.toml", text);
    write_scene("scene.exr", 1700);
  }
  void write_scene(const std::string& name, std::int64_t size, float bad = 0.0F) const {
    Image plane(size, size);
    for (std::int64_t y = 0; y < size; ++y)
      for (std::int64_t x = 0; x < size; ++x)
        plane.at(x, y) = static_cast<float>(
            5.0 + std::sin(0.3 * static_cast<double>(x * x % 97)) * std::cos(0.21 * static_cast<double>(y)) +
            (x > y ? 2.0 : 0.0));
    if (!std::isfinite(bad)) plane.at(70, 900) = bad;
    mtf::io::write_exr((scratch / name).string(), {{"Y", plane.view()}}, {});
  }
  double rms_between(const std::string& a, const std::string& b, std::int64_t x0 = 0, std::int64_t y0 = 0) const {
    const auto p = mtf::io::read_image((scratch / a).string()), q = mtf::io::read_image((scratch / b).string());
    double squares = 0.0;
    for (std::int64_t y = 0; y < p.planes[0].height(); ++y)
      for (std::int64_t x = 0; x < p.planes[0].width(); ++x)
        squares += std::pow(static_cast<double>(p.planes[0].at(x, y)) - q.planes[0].at(x0 + x, y0 + y), 2);
    return std::sqrt(squares / static_cast<double>(p.planes[0].size()));
  }
  nlohmann::json report() const { return nlohmann::json::parse(read_file(scratch / "run.json")); }
  void expect_refused(const std::string& command, int status, std::initializer_list<std::string_view> parts) const {
    SCOPED_TRACE(command);
    const Result r = scratch.run(command);
    expect_error(r, status, parts);
    EXPECT_EQ(lines(r.err), 1U) << r.err;
    EXPECT_FALSE(fs::exists(scratch / "out.exr"));
  }
  const std::string tiled = "mtf simulate sensor.toml scene.exr -o out.exr --memory 105MiB --report run.json";
  const Scratch scratch;
};

TEST_F(SimulateTiles, EqualTheWholeImageWithinTheTolerance) {
  const Result r = scratch.run(tiled + " --progress plain");
  ASSERT_EQ(r.status, 0) << r.err;
  expect_says(r.err, {"tiles"});
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o all.exr").status, 0);
  EXPECT_LT(rms_between("out.exr", "all.exr"), 1e-4);
  EXPECT_GT(report()["tiles"]["count"].get<int>(), 1) << report()["tiles"];
  EXPECT_EQ(report()["scene_size"][0], 1700);
  EXPECT_LE(report()["tiles"]["bytes"].get<double>(), 105.0 * (1 << 20));
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LE(report()["peak_rss_mib"].get<double>(), 105.0);
#endif
  EXPECT_EQ(report()["out_size"][0], 425);
  const auto out = mtf::io::read_image((scratch / "out.exr").string());
  expect_says(out.info.storage, {"tiled"});
  EXPECT_EQ(out.info.attributes.at("mtf:units"), "W.m^-2.sr^-1");
  EXPECT_FALSE(fs::exists(scratch / "out.exr.part"));
}

TEST_F(SimulateTiles, EnviGoesThroughInPieces) {
  const auto scene = mtf::io::read_image((scratch / "scene.exr").string());
  write_file(scratch / "envi.dat", {reinterpret_cast<const char*>(scene.planes[0].data()),
                                    static_cast<std::size_t>(scene.planes[0].size()) * sizeof(float)});
  write_file(scratch / "envi.hdr", "ENVI\nsamples = 1700\nlines = 1700\nbands = 1\ndata type = 4\nbyte order = 0\n");
  const Result r = scratch.run("mtf simulate sensor.toml envi.dat -o out.img --memory 105MiB --report run.json");
  ASSERT_EQ(r.status, 0) << r.err;
  EXPECT_GT(report()["tiles"]["count"].get<int>(), 1) << report()["tiles"];
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o all.exr").status, 0);
  EXPECT_LT(rms_between("out.hdr", "all.exr"), 1e-4);
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml envi.hdr -o whole.hdr").status, 0);
  EXPECT_EQ(rms_between("whole.img", "all.exr"), 0.0);
  expect_refused("mtf simulate sensor.toml envi.dat -o envi.hdr", 2, {"envi.hdr", "is the input"});
  expect_refused("mtf simulate sensor.toml envi.hdr -o other.hdr --report envi.dat", 2, {"envi.dat", "is the input"});
}

TEST_F(SimulateTiles, ARegionIsThatPartOfTheImage) {
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o all.exr").status, 0);
  for (const std::string more : {"", " --memory 300MiB"}) {
    const Result r = scratch.run("mtf simulate sensor.toml scene.exr -o part.exr --roi 100,40,50,30" + more);
    ASSERT_EQ(r.status, 0) << r.err;
    const auto part = mtf::io::read_image((scratch / "part.exr").string());
    EXPECT_EQ(part.planes[0].width(), 50);
    EXPECT_EQ(part.planes[0].height(), 30);
    EXPECT_LT(rms_between("part.exr", "all.exr", 100, 40), 2e-4);
  }
  ASSERT_EQ(scratch.run("mtf simulate sensor.toml scene.exr -o part.png --roi 0,0,8,8").status, 0);
}

TEST_F(SimulateTiles, BadPixels) {
  write_scene("bad.exr", 1700, std::numeric_limits<float>::quiet_NaN());
  expect_refused("mtf simulate sensor.toml bad.exr -o out.exr --memory 300MiB", 1,
                 {"1 pixels", "NaN", "column 70, row 900"});
  expect_refused("mtf simulate sensor.toml bad.exr -o out.exr --memory 300MiB --nan fill", 2, {"--nan"});
  for (const std::string policy : {"fill", "propagate"}) {
    const std::string nan = " --tolerance 1e-3 --nan " + policy;
    ASSERT_EQ(scratch.run("mtf simulate sensor.toml bad.exr -o all.exr" + nan).status, 0);
    ASSERT_EQ(scratch.run("mtf simulate sensor.toml bad.exr -o part.exr --roi 10,215,20,20" + nan).status, 0);
    const auto all = mtf::io::read_image((scratch / "all.exr").string());
    const auto part = mtf::io::read_image((scratch / "part.exr").string());
    int bad = 0;
    for (std::int64_t y = 0; y < 20; ++y)
      for (std::int64_t x = 0; x < 20; ++x) {
        const float a = all.planes[0].at(10 + x, 215 + y), b = part.planes[0].at(x, y);
        ASSERT_EQ(std::isnan(a), std::isnan(b)) << x << " " << y;
        if (std::isnan(a))
          ++bad;
        else
          ASSERT_NEAR(a, b, 5e-3);
      }
    EXPECT_EQ(bad > 0, policy == "propagate");
  }
}

TEST_F(SimulateTiles, ValuesBeyondFloatAreRefusedByEveryRoute) {
  Image plane(1700, 1700);
  for (std::int64_t i = 0; i < plane.size(); ++i) plane.data()[i] = i % 1700 / 64 % 2 == 0 ? 3e38F : -3e38F;
  mtf::io::write_exr((scratch / "huge.exr").string(), {{"Y", plane.view()}}, {});
  write_file(scratch / "sharp.toml", read_file(scratch / "sensor.toml") +
                                         "\n[[postsample]]\nkind = \"fir\"\ntaps = [[0, -1, 0], [-1, 5, -1], [0, -1, "
                                         "0]]\n");
  for (const std::string more : {"", " --memory 120MiB", " --roi 0,0,50,50"})
    expect_refused("mtf simulate sharp.toml huge.exr -o out.exr --tolerance 1e-3" + more, 1, {"3.4e38"});
  EXPECT_FALSE(fs::exists(scratch / "out.exr.part"));
  expect_error(scratch.run("cp huge.exr s.1.exr; mtf simulate sharp.toml s.%d.exr -o t.%d.exr --tolerance 1e-3"), 1,
               {"frame 1: channel Y:", "exceed"});
  EXPECT_FALSE(fs::exists(scratch / "t.1.exr"));
}

TEST_F(SimulateTiles, ExplainSaysWhoseThePlanIs) {
  const Result r = scratch.run(tiled + " --explain");
  ASSERT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(r.out.starts_with("plan of one tile")) << r.out;
  const std::string all = scratch.run("mtf simulate sensor.toml scene.exr -o all.exr --explain").out;
  EXPECT_FALSE(says(all, "tile")) << all;
}

TEST_F(SimulateTiles, AStoppedRunGoesOn) {
  ASSERT_EQ(scratch.run(tiled + " && mv out.exr first.exr").status, 0);
  write_scene("scene.exr", 1700);  // the same pixels, a new file
  // Stopped by a signal, as soon as a tile is there.
  const Result stopped = scratch.run(
      tiled +
      " & pid=$!\nwhile kill -0 $pid 2>/dev/null; do\n  size=$(wc -c < out.exr.part.tiles 2>/dev/null || echo 0)\n"
      "  if [ $size -gt 90 ]; then kill -INT $pid; break; fi\ndone\nwait $pid\n");
  if (stopped.status == 0) GTEST_SKIP() << "too fast to be stopped";
  EXPECT_EQ(stopped.status, 130) << stopped.err;
  expect_says(stopped.err, {"the same command"});
  EXPECT_FALSE(fs::exists(scratch / "out.exr"));
  ASSERT_TRUE(fs::exists(scratch / "out.exr.part.tiles"));
  const Result again = scratch.run(tiled);
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_GT(report()["tiles"]["resumed"].get<int>(), 0) << again.err;
  EXPECT_EQ(rms_between("out.exr", "first.exr"), 0.0);
  EXPECT_FALSE(fs::exists(scratch / "out.exr.part"));
}

TEST_F(SimulateTiles, ACorruptStateIsSaidAndNotUsed) {
  write_file(scratch / "out.exr.part.tiles", "mtfkit tiles 1 something that this version has never written, and more");
  write_file(scratch / "out.exr.part", "nothing");
  const Result r = scratch.run(tiled);
  ASSERT_EQ(r.status, 0) << r.err;
  expect_says(r.err, {"starting over"});
  EXPECT_EQ(report()["tiles"]["resumed"], 0);
}

TEST_F(SimulateTiles, FullDiskIsSaid) {
  // A limit on the size of files stands in for a full disk.
  expect_refused("ulimit -f 8; mtf simulate sensor.toml scene.exr -o out.exr --memory 105MiB", 1, {"out.exr.part"});
}

TEST_F(SimulateTiles, Refusals) {
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --memory 2MiB", 2, {"MiB"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --memory 0", 2, {"--memory"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --memory lots", 2, {"512MiB"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.png --memory 1GiB", 2, {".exr"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --roi 1,2,3", 2, {"--roi"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --roi 400,0,26,5", 2, {"425x425"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --memory 1GiB --resume maybe", 2, {"--resume"});
  expect_refused("mtf simulate sensor.toml scene.exr -o out.exr --memory 1GiB --tolerance 1e-20", 2, {"float32"});
}

}  // namespace
}  // namespace apps_test
