// SPDX-License-Identifier: Apache-2.0

// Figures of `mtf curve --plot`: files that are what their name says, data beside them, labels taken literally.

#include <gtest/gtest.h>

#include "tests/apps/command.h"

namespace apps_test {
namespace {

bool have_gnuplot(const Scratch& scratch) { return scratch.run("command -v gnuplot").status == 0; }

TEST(Plot, EveryFormatWithItsData) {
  const Scratch scratch;
  if (!have_gnuplot(scratch)) GTEST_SKIP() << "no gnuplot";
  scratch.add_sensor();
  struct Case {
    const char *name, *start;
  };
  for (const Case& c : {Case{"f.svg", "<?xml"}, {"f.PDF", "%PDF"}, {"f.png", "\x89PNG"}}) {
    const Result result = scratch.run(std::string("mtf curve sensor.toml --freq 0:60:31 --plot ") + c.name);
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.out, "") << "the table is still shown";
    EXPECT_TRUE(read_file(scratch / c.name).starts_with(c.start)) << c.name;
    const std::string data = read_file(scratch / (c.name + std::string(".csv")));
    EXPECT_TRUE(data.starts_with("spatial frequency [cy/mm],diffraction,footprint,jitter,system\n0,1,1,1,1\n")) << data;
    EXPECT_EQ(lines(data), 32U);
  }
  EXPECT_EQ(scratch.run("ls").out, "f.PDF\nf.PDF.csv\nf.png\nf.png.csv\nf.svg\nf.svg.csv\nsensor.toml\n");
  const std::string svg = read_file(scratch / "f.svg");
  expect_says(svg, {"Nyquist 33.33", "spatial frequency [cy/mm]", "MTF = |OTF|", "MWIR staring 640x512"});
}

TEST(Plot, NoFileThatWasNotNamedIsReplaced) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  for (const char* command : {"mtf curve demo/sensor.toml --plot ", "mtf measure demo/edge.exr --plot ",
                              "mtf measure demo/edge.exr --map ", "mtf fit demo/fit.toml demo/edge.exr --plot "}) {
    for (const char* name : {"x.csv", "x", "x.CSV", "x.svg.txt"}) write_file(scratch / name, "mine");
    for (int again = 0; again < 2; ++again) {  // its own data are replaced
      const Result result = scratch.run(std::string(command) + "x.svg");
      EXPECT_EQ(result.status, 0) << command << result.err;
    }
    for (const char* name : {"x.csv", "x", "x.CSV", "x.svg.txt"})
      EXPECT_EQ(read_file(scratch / name), "mine") << command << name;
    EXPECT_GT(lines(read_file(scratch / "x.svg.csv")), 1U) << command;
  }
}

TEST(Plot, WhereTheDiskIsFullNeitherFigureNorDataAreLeft) {
  const Scratch scratch;
  if (!have_gnuplot(scratch)) GTEST_SKIP() << "no gnuplot";
  scratch.add_sensor();
  ASSERT_EQ(scratch.run("mtf curve sensor.toml --plot whole.svg").status, 0);
  constexpr std::uintmax_t kLimit = 8192;
  ASSERT_LT(std::filesystem::file_size(scratch / "whole.svg.csv"), kLimit);
  ASSERT_GT(std::filesystem::file_size(scratch / "whole.svg"), kLimit);
  const Result result = scratch.run("ulimit -f 16; mtf curve sensor.toml --plot f.svg");
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(lines(result.err), 1U) << result.err;
  EXPECT_EQ(scratch.run("ls -A").out, "sensor.toml\nwhole.svg\nwhole.svg.csv\n");
}

TEST(Plot, LabelsAreTakenLiterally) {
  const Scratch scratch;
  if (!have_gnuplot(scratch)) GTEST_SKIP() << "no gnuplot";
  scratch.add_sensor();
  std::string text = read_file(scratch / "sensor.toml");
  text.insert(text.find("kind = \"jitter\""), "label = '''a_b^{c}'\"`touch pwned`\\n$x <&> %d'''\n");
  write_file(scratch / "odd.toml", text);
  const Result result = scratch.run("mtf curve odd.toml --plot odd.svg");
  ASSERT_EQ(result.status, 0) << result.err;
  const std::string svg = read_file(scratch / "odd.svg");
  expect_says(svg, {"a_b^{c}'\"`touch pwned`\\n$x &lt;&amp;"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "pwned"));
}

TEST(Plot, Characters) {
  const Scratch scratch;
  if (!have_gnuplot(scratch)) GTEST_SKIP() << "no gnuplot";
  scratch.add_sensor();
  const Result result = scratch.run("mtf curve sensor.toml --plot ascii -o values.csv --format csv");
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"Nyquist 33.33", "= 0.3875\n"});
  for (std::size_t at = 0; at < result.out.size(); at = result.out.find('\n', at) + 1)
    EXPECT_LE(result.out.find('\n', at) - at, 100U);
  EXPECT_EQ(lines(read_file(scratch / "values.csv")), 62U);
}

TEST(Plot, WithoutGnuplotTheDataAreWritten) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string only_mtf = "m=$(command -v mtf); PATH=/nonexistent $m curve sensor.toml --plot ";
  const Result result = scratch.run(only_mtf + "f.svg");
  EXPECT_EQ(result.status, 0) << result.err;
  expect_says(result.err, {"gnuplot is not installed"});
  EXPECT_EQ(scratch.run("ls").out, "f.svg.csv\nsensor.toml\n");
  const Result characters = scratch.run(only_mtf + "ascii");
  EXPECT_EQ(characters.status, 0);
  expect_says(characters.out, {"diffraction"});
}

}  // namespace
}  // namespace apps_test
