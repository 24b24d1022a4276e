// SPDX-License-Identifier: Apache-2.0

// `mtf measure`: JPEG files.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/calib/made_edges.h"
#include "tests/mtf/io/jpeg_file.h"

namespace {

using apps_test::Result;
using apps_test::Scratch;
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
  for (const char* part : {"JPEG, sRGB by convention", "counts rms", "steps of 1 to 7"})
    EXPECT_NE(note.find(part), std::string::npos) << note;
  EXPECT_EQ(report(scratch, "grey.jpg --encoding linear").at("edges")[0].at("linearisation").at("encoding"), "linear");
  const Result chroma = scratch.run("mtf measure colour.jpg --channel Cb");
  EXPECT_EQ(chroma.status, 2);
  EXPECT_NE(chroma.err.find("only the luminance plane"), std::string::npos) << chroma.err;
  EXPECT_EQ(scratch.run("mtf measure colour.jpg --channel luminance").status, 0);
  const std::string info = scratch.run("mtf info colour.jpg").out;
  EXPECT_NE(info.find("JPEG, 8-bit, luminance of a colour image"), std::string::npos) << info;
}

TEST(MeasureJpeg, RoundingAboveTheNoiseIsAWarning) {
  const Scratch scratch;
  add_jpeg(scratch, "coarse.jpg", 75);
  const Json edge = report(scratch, "coarse.jpg").at("edges")[0];
  ASSERT_EQ(edge.at("warnings").size(), 1U) << edge.at("warnings");
  EXPECT_NE(edge.at("warnings")[0].get<std::string>().find("JPEG: the rounding"), std::string::npos);
}

}  // namespace
