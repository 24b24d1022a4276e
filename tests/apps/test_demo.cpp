// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sstream>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"

namespace apps_test {
namespace {

TEST(Demo, SaysPassWithTheNumbersToFollowByHand) {
  const Scratch scratch;
  const Result demo = scratch.run("mtf demo -o mtf-demo");
  ASSERT_EQ(demo.status, 0) << demo.err;
  expect_says(demo.out, {"125.0 cy/mm", "33.33 cy/mm", "0.5333", "0.6645", "0.6366", "0.9160", "= 0.3875", "PASS"});
  for (const char* name : {"sensor.toml", "scene.exr", "sensor.exr", "preview.png", "mtf.csv", "targets.exr"})
    EXPECT_GT(fs::file_size(scratch / "mtf-demo" / name), 0U) << name;
  const mtf::io::ImageFile scene = mtf::io::read_image((scratch / "mtf-demo/scene.exr").string());
  EXPECT_EQ(scene.info.attributes.at("mtf:quantity"), "radiance");
  EXPECT_EQ(scene.planes.front().width(), 1024);
}

TEST(Demo, SimulateRepeatsItsImages) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o d").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate d/sensor.toml d/scene.exr -o sensor.exr").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate d/camera.toml d/thermal.exr -o camera.exr").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate d/uncooled.toml d/thermal.exr -o uncooled.exr").status, 0);
  for (const std::string name : {"sensor.exr", "camera.exr", "uncooled.exr"}) {
    const auto first = mtf::io::read_image((scratch / ("d/" + name)).string());
    const auto second = mtf::io::read_image((scratch / name).string());
    ASSERT_EQ(first.planes.front().size(), second.planes.front().size());
    for (std::int64_t i = 0; i < first.planes.front().size(); ++i)
      ASSERT_EQ(first.planes.front().data()[i], second.planes.front().data()[i]) << name << " " << i;
  }
}

TEST(Demo, KeepsWhatIsThere) {
  const Scratch scratch;
  fs::create_directory(scratch / "d");
  write_file(scratch / "d/mine", "precious");
  expect_error(scratch.run("mtf demo -o d"), 2, {"--force"});
  EXPECT_EQ(scratch.run("mtf demo -o d --force").status, 0);
  EXPECT_EQ(read_file(scratch / "d/mine"), "precious");
  EXPECT_EQ(scratch.run("mtf demo -o no/such/folder").status, 1);
}

TEST(Demo, WhereTheDiskIsFullNothingIsLeft) {
  const Scratch scratch;
  const std::string full = "ulimit -f 64; ";  // no file above 32 KiB: sensor.toml is written, scene.exr is not
  const Result fresh = scratch.run(full + "mtf demo -o d");
  EXPECT_EQ(fresh.status, 1);
  EXPECT_EQ(lines(fresh.err), 1U) << fresh.err;
  expect_says(fresh.err, {"d/scene.exr"});
  EXPECT_FALSE(fs::exists(scratch / "d"));

  fs::create_directory(scratch / "d");
  write_file(scratch / "d/mine", "precious");
  EXPECT_EQ(scratch.run(full + "mtf demo -o d --force").status, 1);
  EXPECT_EQ(scratch.run("ls -A d").out, "mine\n");
  EXPECT_EQ(read_file(scratch / "d/mine"), "precious");
}

TEST(Demo, WithoutGnuplotItNamesTheFilesThatAreThere) {
  const Scratch scratch;
  const Result demo = scratch.run("m=$(command -v mtf); PATH=/nonexistent $m demo -o d");
  ASSERT_EQ(demo.status, 0) << demo.err;
  expect_says(demo.err, {"gnuplot is not installed"});
  const std::size_t begin = demo.out.find("written to d/:"), end = demo.out.find('\n', begin);
  ASSERT_NE(end, std::string::npos) << demo.out;
  std::istringstream names(demo.out.substr(begin + 14, end - begin - 14));
  std::size_t named = 0;
  for (std::string name; names >> name; ++named) EXPECT_TRUE(fs::exists(scratch / "d" / name)) << name;
  EXPECT_EQ(named, 16U);
  EXPECT_FALSE(fs::exists(scratch / "d/mtf.svg"));
}

TEST(Demo, AToleranceBelowFloatIsRefusedWithTheOneToUse) {
  const Scratch scratch;
  expect_error(scratch.run("mtf demo -o d --tolerance 1e-12"), 2, {"float32"});
}

}  // namespace
}  // namespace apps_test
