// SPDX-License-Identifier: Apache-2.0

// `mtf measure`: shapes that programs rely on, edges of known MTF through files, and what is said of bad ones.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/calib/made_edges.h"
#include "tests/calib/made_scenes.h"
#include "tests/mtf/io/png_chunks.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

/// An EXR of an edge with a Gaussian point spread, MTF50 at 0.3 cycles/pixel.
void add_edge(const Scratch& scratch, const char* name, const made::Scene& scene) {
  static const made::Step step = made::Step::gaussian(0.3);
  mtf::io::write_exr((scratch / name).string(), {{"Y", made::make(step, scene).view()}}, {});
}

Json measure(const Scratch& scratch, const std::string& arguments, int status = 0) {
  const Result result = scratch.run("mtf measure " + arguments + " --format json");
  EXPECT_EQ(result.status, status) << result.err;
  return Json::parse(result.out);
}

double value(const Json& edge, const char* name) { return edge.at(name).at("value").get<double>(); }

TEST(Measure, OneEdgeWithItsCurves) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {.noise_sd = 0.01});
  const Json json = measure(scratch, "edge.exr");
  ASSERT_EQ(json.at("edges").size(), 1U);
  EXPECT_EQ(json.at("unit"), "cycles/pixel");
  const Json& edge = json.at("edges")[0];
  EXPECT_EQ(edge.at("roi"), Json({0, 0, 128, 100}));
  EXPECT_EQ(edge.at("linearisation").at("encoding"), "linear");
  EXPECT_EQ(edge.at("missing_pixels"), 0);
  EXPECT_NEAR(edge.at("position_px")[0].get<double>(), 64.0, 1.0);
  EXPECT_TRUE(edge.at("reason").is_null()) << edge.at("reason");
  EXPECT_NEAR(edge.at("angle_deg").get<double>(), 5.0, 0.1);
  // Within five of its own standard deviations, which are those of the noise: 0.6 to 0.75 % (calib/README.md).
  EXPECT_NEAR(value(edge, "mtf50"), 0.3, 5.0 * edge.at("mtf50").at("sd").get<double>());
  EXPECT_LT(edge.at("mtf50").at("sd").get<double>(), 0.004);
  const auto frequency = edge.at("mtf").at("frequency").get<std::vector<double>>();
  const auto mtf = edge.at("mtf").at("value").get<std::vector<double>>();
  const auto sd = edge.at("mtf").at("sd").get<std::vector<double>>();
  ASSERT_EQ(frequency.size(), mtf.size());
  ASSERT_EQ(frequency.size(), sd.size());
  EXPECT_EQ(frequency.front(), 0.0);
  EXPECT_EQ(frequency.back(), 1.0);
  EXPECT_NEAR(mtf.front(), 1.0, 1e-9);
  for (std::size_t i = 0; i < mtf.size(); ++i)
    EXPECT_NEAR(mtf[i], std::exp2(-std::pow(frequency[i] / 0.3, 2)), 6.0 * sd[i] + 1e-4) << frequency[i];
  EXPECT_EQ(edge.at("esf").at("distance_px").size(), edge.at("esf").at("value").size());
}

TEST(Measure, EveryOutputIsWritten) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {.noise_sd = 0.01});
  const Result result = scratch.run(
      "mtf measure edge.exr --format csv -o edge.csv --curves curves.csv --plot plot.svg --map map.svg "
      "--annotate edges.png");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(lines(read_file(scratch / "edge.csv")), 2U);
  const std::string curves = read_file(scratch / "curves.csv");
  EXPECT_TRUE(curves.starts_with("edge,curve,x,value,sd\n"));
  for (const char* curve : {"mtf", "otf_re", "otf_im", "esf", "lsf"})
    EXPECT_TRUE(says(curves, "\n1," + std::string(curve) + ",")) << curve;
  EXPECT_NE(read_file(scratch / "plot.svg.csv"), "");
  const std::string map = read_file(scratch / "map.svg.csv");
  EXPECT_TRUE(map.starts_with("edge,image,channel,direction,x_px,y_px,")) << map;
  EXPECT_EQ(lines(map), 2U);
  const mtf::io::FileInfo picture = mtf::io::read_info((scratch / "edges.png").string());
  EXPECT_EQ(picture.width % 128, 0);
  EXPECT_EQ(picture.channels.size(), 3U);
  const Result table = scratch.run("mtf measure edge.exr");
  expect_says(table.out, {"MTF50 [cy/px]", " +- "});
}

TEST(Measure, Iso12233IsLowAndSaysSo) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {});
  const Json json = measure(scratch, "edge.exr --method iso12233");
  const Json& edge = json.at("edges")[0];
  EXPECT_EQ(json.at("method"), "iso12233");
  EXPECT_TRUE(edge.at("mtf50").at("sd").is_null());
  // sfrmat5 measures 0.29837 on the public edge of this kind (edges of MTF50 0.3 at 5 degrees).
  EXPECT_NEAR(value(edge, "mtf50"), 0.2984, 5e-4);
  EXPECT_FALSE(edge.at("warnings").empty());
  EXPECT_EQ(edge.at("clipped_share").get<double>(), 0.0);
}

// Its curve is then too high. The share is known where the other method refuses the edge, too.
TEST(Measure, Iso12233SaysThatValuesAreClipped) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {});
  for (const bool standard : {true, false}) {
    const Json edge =
        measure(scratch, std::string("edge.exr --saturation 0.5 --method ") + (standard ? "iso12233" : "regression"),
                standard ? 0 : 1)
            .at("edges")[0];
    EXPECT_NEAR(edge.at("clipped_share").get<double>(), 0.5, 0.05);
    EXPECT_EQ(edge.at("outcome"), standard ? "measured" : "clipped");
    expect_says(edge.dump(), {"pixels are clipped"});
  }
}

/// 16 bits through the curve of IEC 61966-2-1, or 1 / 2.2.
void add_coded(const Scratch& scratch, const char* name, const mtf::Image& image, bool srgb = true) {
  mtf::Image coded = image.clone();
  for (std::int64_t i = 0; i < coded.size(); ++i) {
    const double l = coded.data()[i];
    const double v = !srgb            ? std::pow(l, 1.0 / 2.2)
                     : l <= 0.0031308 ? 12.92 * l
                                      : 1.055 * std::pow(l, 1.0 / 2.4) - 0.055;
    coded.data()[i] = static_cast<float>(v);
  }
  mtf::io::write_integer((scratch / name).string(), {{"Y", coded.view()}}, {1.0 / 65535.0, 0.0}, {});
}

/// An edge in JSON less its provenance, which is where runs of the same numbers differ.
Json numbers_of(const Json& report) {
  Json edge = report.at("edges").at(0);
  for (const char* key : {"image", "linearisation"}) edge.erase(key);
  return edge;
}

TEST(Measure, TheCurveThatAFileStatesIsUndone) {
  const Scratch scratch;
  const mtf::Image image = made::make(made::Step::gaussian(0.3), {.noise_sd = 0.005});
  add_coded(scratch, "plain.png", image);
  add_coded(scratch, "srgb.png", image);
  io_test::add_chunks(scratch / "srgb.png", {io_test::srgb_chunk(), io_test::gamma_chunk(45455)});
  add_coded(scratch, "gamma.png", image, false);
  io_test::add_chunks(scratch / "gamma.png", {io_test::gamma_chunk(45455)});

  // As if it had been asked for: values, weights of the rounding, deviations.
  const Json stated = measure(scratch, "srgb.png"), asked = measure(scratch, "plain.png --encoding srgb");
  EXPECT_EQ(numbers_of(stated), numbers_of(asked));
  EXPECT_EQ(stated.at("edges")[0].at("linearisation").at("step_at_mid_level"),
            asked.at("edges")[0].at("linearisation").at("step_at_mid_level"));
  const Json linearisation = stated.at("edges")[0].at("linearisation");
  EXPECT_EQ(linearisation.at("encoding"), "srgb");
  EXPECT_EQ(linearisation.at("encoding_source"), "sRGB chunk");
  EXPECT_EQ(linearisation.at("stated_encoding"), "srgb");
  const Json gamma = measure(scratch, "gamma.png").at("edges")[0];
  EXPECT_EQ(gamma.at("linearisation").at("encoding"), "gamma:2.2");
  for (const Json& edge : {stated.at("edges")[0], gamma})
    EXPECT_NEAR(value(edge, "mtf50"), 0.3, 5.0 * edge.at("mtf50").at("sd").get<double>());

  // The user's word is the last one.
  const Json linear = measure(scratch, "srgb.png --encoding linear");
  EXPECT_EQ(numbers_of(linear), numbers_of(measure(scratch, "plain.png")));
  EXPECT_EQ(linear.at("edges")[0].at("linearisation").at("encoding_source"), "--encoding");
  EXPECT_EQ(linear.at("edges")[0].at("linearisation").at("stated_by"), "sRGB chunk");
  EXPECT_EQ(measure(scratch, "plain.png").at("edges")[0].at("linearisation").at("encoding_source"), "assumed");
}

TEST(Measure, WhatAFileStatesIsSaid) {
  const Scratch scratch;
  const mtf::Image image = made::make(made::Step::gaussian(0.3), {});
  for (const char* name : {"srgb.png", "adobe.png", "linear.png"}) add_coded(scratch, name, image);
  io_test::add_chunks(scratch / "srgb.png", {io_test::srgb_chunk()});
  io_test::add_chunks(scratch / "adobe.png", {io_test::profile_chunk("Adobe RGB (1998)")});
  io_test::add_chunks(scratch / "linear.png", {io_test::gamma_chunk(100000)});
  const auto said = [&](const std::string& command) { return scratch.run("mtf " + command).err; };
  expect_says(said("measure srgb.png"), {"mtf: note: srgb.png:", "sRGB chunk", "srgb is undone", "--encoding linear"});
  expect_says(said("measure adobe.png"), {"\"Adobe RGB (1998)\" is not"});
  for (const char* silent : {"measure srgb.png --encoding srgb", "measure srgb.png --encoding linear",
                             "measure adobe.png --encoding gamma", "measure linear.png"})
    EXPECT_EQ(said(silent), "") << silent;
  const auto info = [&](const std::string& name) {
    return Json::parse(scratch.run("mtf info " + name + " --format json").out);
  };
  EXPECT_EQ(info("srgb.png").at("encoding"), "srgb");
  EXPECT_EQ(info("srgb.png").at("encoding_source"), "sRGB chunk");
  EXPECT_TRUE(info("adobe.png").at("encoding").is_null());
  expect_says(scratch.run("mtf info srgb.png").out, {"[scene] encoding"});
}

TEST(Measure, EdgesThatAreLeftOutAreCounted) {
  const Scratch scratch;
  mtf::Image image = calib::test::made_scene(300, 200, {}, 0.005);
  for (const double x : {60.0, 150.0, 240.0})
    for (const double y : {55.0, 145.0}) calib::test::add_rectangle(image, {x, y}, 22.0, 22.0, 7.0, -0.6);
  mtf::io::write_exr((scratch / "chart.exr").string(), {{"Y", image.view()}}, {});
  const Json all = measure(scratch, "chart.exr");
  EXPECT_EQ(all.at("edges").size(), 24U);
  EXPECT_EQ(all.at("left_out"), Json::array());
  const Result few = scratch.run("mtf measure chart.exr --edges 5 --format json");
  const Json left = Json::parse(few.out).at("left_out").at(0);
  EXPECT_EQ(left.at("usable"), 19);
  EXPECT_EQ(left.at("not_tried"), 0);
  expect_says(few.err, {"5 of 24"});
}

TEST(Measure, EncodedMosaicAndMaskedImages) {
  const Scratch scratch;
  static const made::Step step = made::Step::gaussian(0.3);
  mtf::Image image = made::make(step, {.width = 160, .height = 160});
  add_coded(scratch, "srgb.png", image);
  EXPECT_NEAR(value(measure(scratch, "srgb.png --encoding srgb").at("edges")[0], "mtf50"), 0.3, 0.0005);
  EXPECT_GT(std::abs(value(measure(scratch, "srgb.png").at("edges")[0], "mtf50") - 0.3), 0.001);

  mtf::io::write_exr((scratch / "mosaic.exr").string(), {{"Y", image.view()}}, {});
  const Json mosaic = measure(scratch, "mosaic.exr --roi 0,0,160,160 --bayer all");
  ASSERT_EQ(mosaic.at("edges").size(), 4U);
  for (const Json& edge : mosaic.at("edges")) EXPECT_NEAR(value(edge, "mtf50"), 0.3, 0.002) << edge.at("channel");

  mtf::Image mask(160, 160);
  for (std::int64_t y = 0; y < 160; ++y)
    for (std::int64_t x = 0; x < 160; ++x) {
      const bool hidden = x > 100 && y > 60 && y < 100;
      mask.at(x, y) = hidden ? 0.0F : 1.0F;
      if (hidden) image.at(x, y) = 5.0F;
    }
  mtf::io::write_exr((scratch / "stain.exr").string(), {{"Y", image.view()}}, {});
  mtf::io::write_exr((scratch / "mask.exr").string(), {{"Y", mask.view()}}, {});
  const Json masked = measure(scratch, "stain.exr --mask mask.exr --roi 0,0,160,160");
  EXPECT_NEAR(value(masked.at("edges")[0], "mtf50"), 0.3, 0.001);
}

// A value that means no data (tRNS of a grey PNG; GDAL writes it so) is that, and not a dark side.
TEST(Measure, PixelsWithoutDataAreNotUsed) {
  const Scratch scratch;
  mtf::Image image = made::make(made::Step::gaussian(0.3), {.width = 160, .height = 160, .noise_sd = 0.002});
  for (std::int64_t y = 0; y < 160; ++y)
    for (std::int64_t x = 0; x < 160; ++x)
      if (x + y > 230) image.at(x, y) = 0.0F;
  mtf::io::write_integer((scratch / "target.png").string(), {{"Y", image.view()}}, {1.0 / 65535.0, 0.0}, {});
  io_test::add_chunks((scratch / "target.png").string(), {{"tRNS", std::string(2, '\0')}});
  const Json edges = measure(scratch, "target.png").at("edges");
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_NEAR(value(edges[0], "mtf50"), 0.3, 5.0 * edges[0].at("mtf50").at("sd").get<double>());
  expect_says(scratch.run("mtf measure target.png").err, {"value 0 (tRNS)"});
  expect_says(scratch.run("mtf info target.png").out, {"value 0 (tRNS)"});
}

/// Makes the display window of an OpenEXR larger than its data.
void enlarge_display(const std::string& file, std::int32_t columns, std::int32_t rows) {
  std::string bytes = read_file(file);
  const std::string name("displayWindow\0box2i\0\x10\0\0\0", 24);
  const std::size_t corner = bytes.find(name) + name.size() + 8;
  for (const auto& [at, value] : {std::pair{corner, columns - 1}, {corner + 4, rows - 1}})
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(value >> (8 * i) & 0xff);
  write_file(file, bytes);
}

// Zeros around the data would be edges that no lens could make.
TEST(Measure, PixelsOutsideTheDataWindowAreNoData) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {.noise_sd = 0.01});
  enlarge_display(scratch / "edge.exr", 200, 160);
  const Json edges = measure(scratch, "edge.exr").at("edges");
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_NEAR(value(edges[0], "mtf50"), 0.3, 5.0 * edges[0].at("mtf50").at("sd").get<double>());
  expect_says(scratch.run("mtf measure edge.exr").err, {"19200 pixels", "data window"});
}

TEST(Measure, ColourAsksForAChannel) {
  const Scratch scratch;
  static const made::Step step = made::Step::gaussian(0.3);
  const mtf::Image red = made::make(step, {}), green = made::make(step, {.bright = 0.9});
  mtf::io::write_exr((scratch / "colour.exr").string(), {{"R", red.view()}, {"G", green.view()}, {"B", red.view()}},
                     {});
  expect_error(scratch.run("mtf measure colour.exr"), 2, {"--channel"});
  EXPECT_EQ(measure(scratch, "colour.exr --channel all").at("edges").size(), 3U);
  EXPECT_EQ(measure(scratch, "colour.exr --channel luminance").at("edges")[0].at("channel"), "luminance");
  mtf::io::write_exr((scratch / "grey.exr").string(), {{"R", red.view()}, {"G", red.view()}, {"B", red.view()}}, {});
  EXPECT_EQ(measure(scratch, "grey.exr").at("edges").size(), 1U);
}

TEST(Measure, WhatCannotBeMeasuredIsNullWithAReason) {
  const Scratch scratch;
  const auto write = [&](const char* name, const mtf::Image& image) {
    mtf::io::write_exr((scratch / name).string(), {{"Y", image.view()}}, {});
  };
  mtf::Image flat(64, 64), none(64, 64), dot(1, 1);
  for (std::int64_t i = 0; i < flat.size(); ++i) {
    flat.data()[i] = 0.5F;
    none.data()[i] = std::numeric_limits<float>::quiet_NaN();
  }
  dot.data()[0] = 1.0F;
  write("flat.exr", flat);
  write("none.exr", none);
  write("dot.exr", dot);
  for (const std::string name : {"flat.exr", "none.exr", "dot.exr"})
    for (const std::string region : {"", " --roi 0,0,1,1"}) {
      const Json json = measure(scratch, name + region, 1);
      ASSERT_EQ(json.at("edges").size(), 1U) << name;
      const Json& edge = json.at("edges")[0];
      EXPECT_TRUE(edge.at("mtf50").is_null()) << name;
      EXPECT_TRUE(edge.at("mtf").is_null()) << name;
      EXPECT_TRUE(edge.at("reason").is_string()) << name;
      EXPECT_NE(edge.at("outcome"), "measured") << name;
    }
}

TEST(Measure, ARegionOutsideIsAnOutcomeOfItsOwn) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {});
  const Json json = measure(scratch, "edge.exr --roi 0,0,128,100 --roi 100,0,60,60");
  ASSERT_EQ(json.at("edges").size(), 2U);
  EXPECT_EQ(json.at("edges")[0].at("outcome"), "measured");
  EXPECT_EQ(json.at("edges")[1].at("outcome"), "off_region");
  EXPECT_TRUE(json.at("edges")[1].at("reason").is_string());
}

TEST(Measure, ABatchGoesOnWithTheOthers) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {});
  write_file(scratch / "broken.png", "no image");
  expect_error(scratch.run("mtf measure broken.png edge.exr --format json -o all.json"), 1, {"1 of 2"});
  const Json json = Json::parse(read_file(scratch / "all.json"));
  EXPECT_EQ(json.at("edges").size(), 1U);
  ASSERT_EQ(json.at("failed").size(), 1U);
  EXPECT_EQ(json.at("failed")[0].at("image"), "broken.png");
  const std::string table = scratch.run("mtf measure broken.png edge.exr").out;
  const std::size_t named = table.find("broken.png");
  ASSERT_NE(named, std::string::npos) << table;
  EXPECT_EQ(table.find("broken.png", named + 1), std::string::npos) << table;
}

TEST(Measure, InfoOnAnEdgeAdvisesIt) {
  const Scratch scratch;
  add_edge(scratch, "edge.exr", {.noise_sd = 0.01});
  expect_says(scratch.run("mtf info edge.exr").out, {"next: mtf measure edge.exr"});
}

}  // namespace
}  // namespace apps_test
