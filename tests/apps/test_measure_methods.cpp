// SPDX-License-Identifier: Apache-2.0

// `mtf measure`: JPEG files, ISO 12233 beside the MTF with the reasons of the difference, and tables of images.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/calib/made_edges.h"
#include "tests/mtf/io/jpeg_file.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

Json report(const Scratch& scratch, const std::string& arguments) {
  const Result result = scratch.run("mtf measure " + arguments + " --format json");
  EXPECT_EQ(result.status, 0) << result.err;
  return Json::parse(result.out);
}

/// An edge of MTF50 0.3 in sRGB.
void add_jpeg(const Scratch& scratch, const char* name, int quality, bool colour = false) {
  mtf::Image image = made::make(made::Step::gaussian(0.3), {.noise_sd = 0.01});
  for (std::int64_t i = 0; i < image.size(); ++i)
    image.data()[i] = static_cast<float>(255.0 * (1.055 * std::pow(image.data()[i], 1.0 / 2.4) - 0.055));
  io_test::write_jpeg((scratch / name).string(), image.view(), io_test::jpeg_steps(quality), colour);
}

TEST(MeasureJpeg, TheLuminancePlaneWithItsRounding) {
  const Scratch scratch;
  add_jpeg(scratch, "grey.jpg", 97);
  add_jpeg(scratch, "colour.jpg", 97, true);
  const Json grey = report(scratch, "grey.jpg").at("edges")[0], colour = report(scratch, "colour.jpg").at("edges")[0];
  EXPECT_NEAR(grey.at("mtf50").at("value").get<double>(), 0.3, 5.0 * grey.at("mtf50").at("sd").get<double>());
  EXPECT_EQ(grey.at("linearisation").at("encoding"), "srgb");
  EXPECT_EQ(grey.at("mtf50"), colour.at("mtf50"));
  // Steps of 1 to 7 at this quality: sqrt(sum q^2 / 12 / 64) of table K.1 at 6 %.
  EXPECT_NEAR(grey.at("linearisation").at("dct_rounding_sd").get<double>(), 1.2, 0.1);
  EXPECT_EQ(grey.at("warnings"), Json::array());
  const std::string note = scratch.run("mtf measure grey.jpg").err;
  expect_says(note, {"JPEG, sRGB by convention", "counts rms", "steps of 1 to 7"});
  EXPECT_EQ(report(scratch, "grey.jpg --encoding linear").at("edges")[0].at("linearisation").at("encoding"), "linear");
  expect_error(scratch.run("mtf measure colour.jpg --channel Cb"), 2, {"only the luminance plane"});
  EXPECT_EQ(scratch.run("mtf measure colour.jpg --channel luminance").status, 0);
  const std::string info = scratch.run("mtf info colour.jpg").out;
  expect_says(info, {"JPEG, 8-bit", "luminance"});
}

TEST(MeasureJpeg, RoundingAboveTheNoiseIsAWarning) {
  const Scratch scratch;
  add_jpeg(scratch, "coarse.jpg", 75);
  const Json edge = report(scratch, "coarse.jpg").at("edges")[0];
  // Coarse rounding also leaves pixels that stand out like hot ones, which another warning counts.
  ASSERT_FALSE(edge.at("warnings").empty());
  EXPECT_TRUE(says(edge.at("warnings").back().get<std::string>(), "JPEG: the rounding")) << edge.at("warnings");
}

TEST(MeasureBoth, TheReasonsLeadFromOneMethodToTheOther) {
  const Scratch scratch;
  const mtf::Image image = made::make(made::Step::gaussian(0.3), {.noise_sd = 0.001});
  mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", image.view()}}, {});
  const Json both = report(scratch, "edge.exr --method both"), alone = report(scratch, "edge.exr"),
             standard = report(scratch, "edge.exr --method iso12233").at("edges")[0];
  EXPECT_EQ(both.at("method"), "both");
  const Json edge = both.at("edges")[0], iso = edge.at("iso12233");
  EXPECT_EQ(edge.at("mtf50"), alone.at("edges")[0].at("mtf50"));
  for (const char* figure : {"mtf50", "nyquist"}) {
    EXPECT_EQ(iso.at(figure), standard.at(figure).at("value"));
    double sum = iso.at("unexplained").at(figure).get<double>();
    for (const Json& reason : iso.at("reasons")) sum += reason.at(figure).get<double>();
    EXPECT_NEAR(sum, iso.at("difference").at(figure).get<double>(), 1e-5);
    EXPECT_NEAR(sum, iso.at(figure).get<double>() - edge.at(figure).at("value").get<double>(), 1e-5);
  }
  ASSERT_EQ(iso.at("reasons").size(), 5U);
  expect_says(iso.at("reasons")[0].at("reason").get<std::string>(), {"a quarter pixel"});
  EXPECT_FALSE(alone.at("edges")[0].contains("iso12233"));

  const Json scaled = report(scratch, "edge.exr --method both --unit cy/mm --pitch 5um").at("edges")[0].at("iso12233");
  EXPECT_NEAR(scaled.at("reasons")[0].at("mtf50").get<double>(), 200.0 * iso.at("reasons")[0].at("mtf50").get<double>(),
              1e-9);
  EXPECT_EQ(scaled.at("nyquist"), iso.at("nyquist"));
  const std::string table = scratch.run("mtf measure edge.exr --method both").out;
  expect_says(table, {"averages over bins", "not explained", "ISO 12233"});
  const std::string csv = scratch.run("mtf measure edge.exr --method both --format csv").out;
  expect_says(csv, {",iso12233_mtf50,iso12233_nyquist\n"});
  EXPECT_EQ(scratch.run("mtf measure edge.exr --method both --circle").status, 2);
}

// Images of a series in their order; an image without an edge, and one that cannot be read, have a line too.
TEST(MeasureTable, ALineAnImage) {
  const Scratch scratch;
  const auto add = [&](const char* name, double mtf50) {
    const mtf::Image image = made::make(made::Step::gaussian(mtf50), {.noise_sd = 0.005});
    mtf::io::write_exr((scratch / name).string(), {{"Y", image.view()}}, {});
  };
  add("1.exr", 0.2);
  add("2.exr", 0.3);
  const mtf::Image flat = made::make(made::Step::gaussian(0.3), {.dark = 0.5, .bright = 0.5, .noise_sd = 0.005});
  mtf::io::write_exr((scratch / "3.exr").string(), {{"Y", flat.view()}}, {});
  write_file(scratch / "4.png", "no image");
  const std::string regions = "--roi 0,0,128,50 --roi 0,50,128,50 --roi 0,0,20,20";
  const Result result = scratch.run("mtf measure 1.exr 2.exr 3.exr 4.png --table t.csv -o edges.csv --format csv " +
                                    regions + " --unit cy/mm --pitch 5um");
  EXPECT_EQ(result.status, 1);
  std::istringstream table(read_file(scratch / "t.csv"));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(table, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  std::erase_if(rows, [](const auto& row) { return row.at(2) != "all"; });
  ASSERT_EQ(rows.size(), 4U);
  for (std::size_t i = 0; i < 2; ++i) {
    const double truth = i == 0 ? 40.0 : 60.0;  // cycles/mm
    EXPECT_EQ(rows[i].at(3), "3");
    EXPECT_EQ(rows[i].at(4), "2");
    EXPECT_NEAR(std::stod(rows[i].at(5)), 1.0 / 3.0, 1e-12);
    const double best = std::stod(rows[i].at(6)), median = std::stod(rows[i].at(8)), sd = std::stod(rows[i].at(9));
    EXPECT_GE(best, median);
    EXPECT_NEAR(median, truth, 5.0 * sd);
    EXPECT_LT(sd, std::stod(rows[i].at(7)));  // a mean of two
    EXPECT_EQ(rows[i].at(10), "cy/mm");
  }
  EXPECT_EQ(rows[2].at(4), "0");
  EXPECT_EQ(rows[2].at(6), "");
  EXPECT_GT(rows[2].size(), 11U);  // the reason
  EXPECT_EQ(rows[3].at(0), "4.png");
  EXPECT_EQ(rows[3].at(3), "0");
}

// A region that the standard's method cannot take: the MTF is there, and why there is no comparison.
TEST(MeasureBoth, AnEdgeThatOnlyOneMethodMeasures) {
  const Scratch scratch;
  const mtf::Image image = made::make(made::Step::gaussian(0.3), {.angle_deg = 0.2, .noise_sd = 0.005});
  mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", image.view()}}, {});
  const Json edge = report(scratch, "edge.exr --roi 0,0,128,100 --method both").at("edges")[0];
  EXPECT_TRUE(edge.at("mtf50").is_object());
  EXPECT_TRUE(edge.at("iso12233").at("mtf50").is_null());
  expect_says(edge.at("iso12233").at("reason").get<std::string>(), {"drifts by"});
  EXPECT_FALSE(edge.at("iso12233").contains("reasons"));
}

}  // namespace
}  // namespace apps_test
