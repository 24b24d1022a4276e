// SPDX-License-Identifier: Apache-2.0

// `mtf fit`: the loop simulate -> measure -> fit -> simulate, and what programs rely on.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "mtf/io/config/config.h"
#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/calib/field_chart.h"
#include "tests/calib/made_edges.h"
#include "tests/mtf/io/png_chunks.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

// The demo's edge went through the FFT plan; its jitter of 2 um is found again, and the fitted file gives the curve
// that the sensor has.
TEST(FitCommand, FindsTheSensorOfTheDemo) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  const Result fit = scratch.run("mtf fit demo/fit.toml demo/edge.exr -o fitted.toml --format json");
  ASSERT_EQ(fit.status, 0) << fit.err;
  const Json json = Json::parse(fit.out);
  EXPECT_EQ(json.at("status"), "converged") << json.at("reason") << json.at("warnings");
  ASSERT_EQ(json.at("parameters").size(), 1U);
  const Json& jitter = json.at("parameters")[0];
  EXPECT_EQ(jitter.at("name"), "jitter.rms");
  EXPECT_EQ(jitter.at("unit"), "um");
  EXPECT_EQ(jitter.at("start").get<double>(), 4.0);
  // Four standard errors of a seeded draw; 0.2 % of the contrast is its noise.
  const double standard_error = jitter.at("stderr").get<double>();
  EXPECT_NEAR(jitter.at("value").get<double>(), 2.0, 4.0 * standard_error);
  EXPECT_LT(standard_error, 0.06);
  const auto at_nyquist = [&](const std::string& sensor) {
    const Result curve = scratch.run("mtf curve " + sensor + " --freq 0.5 --unit cy/px --format json");
    return Json::parse(curve.out).at("system").at("re")[0].get<double>();
  };
  EXPECT_NEAR(at_nyquist("fitted.toml"), at_nyquist("demo/sensor.toml"), 2e-3);
  EXPECT_EQ(scratch.run("mtf config check fitted.toml").status, 0);
  expect_says(read_file(scratch / "fitted.toml"), {"stderr = "});
  EXPECT_TRUE(read_file(scratch / "fitted.toml").starts_with("# demo/fit.toml"));

  const Json measured = Json::parse(scratch.run("mtf measure demo/edge.exr --format json").out).at("edges")[0];
  const Json& nyquist = measured.at("nyquist");
  EXPECT_NEAR(nyquist.at("value").get<double>(), at_nyquist("demo/sensor.toml --angle -5"),
              4.0 * nyquist.at("sd").get<double>());
}

// The same edge as a PNG that states its curve: undone, and said; taken as light it is another sensor's.
TEST(FitCommand, TheCurveThatAFileStatesIsUndone) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  mtf::io::ImageFile edge = mtf::io::read_image((scratch / "demo/edge.exr").string());
  mtf::Image& plane = edge.planes.front();
  const float top = 1.25F * *std::max_element(plane.data(), plane.data() + plane.size());
  for (std::int64_t i = 0; i < plane.size(); ++i)
    plane.data()[i] = std::pow(std::max(0.0F, plane.data()[i] / top), 1.0F / 2.2F);
  mtf::io::write_integer((scratch / "edge.png").string(), {{"Y", plane.view()}}, {1.0 / 65535.0, 0.0}, {});
  io_test::add_chunks(scratch / "edge.png", {io_test::gamma_chunk(45455)});
  const auto fit = [&](const std::string& options) {
    return Json::parse(scratch.run("mtf fit demo/fit.toml " + options + " --format json").out);
  };
  const Json stated = fit("edge.png"), exact = fit("demo/edge.exr"), linear = fit("edge.png --encoding linear");
  const Json& jitter = stated.at("parameters")[0];
  // 16 bits through a curve: a hundredth of the standard error, which is the noise's.
  EXPECT_NEAR(jitter.at("value").get<double>(), exact.at("parameters")[0].at("value").get<double>(),
              0.02 * jitter.at("stderr").get<double>());
  EXPECT_TRUE(says(stated.at("warnings").dump(), "gAMA chunk")) << stated.at("warnings");
  EXPECT_FALSE(says(linear.at("warnings").dump(), "gAMA chunk")) << linear.at("warnings");
  EXPECT_GT(std::abs(linear.at("parameters")[0].value("value", 0.0) - 2.0), 10.0 * jitter.at("stderr").get<double>());
}

TEST(FitCommand, EveryOutputIsWritten) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  const Result fit = scratch.run(
      "mtf fit demo/fit.toml demo/edge.exr -o fitted.toml --report fit.json --plot fit.svg --residuals residuals "
      "--profile --residual-otf");
  ASSERT_EQ(fit.status, 0) << fit.err;
  expect_says(fit.out, {"jitter.rms"});
  const Json json = Json::parse(read_file(scratch / "fit.json"));
  EXPECT_TRUE(json.at("parameters")[0].at("interval95").is_array());
  EXPECT_EQ(json.at("residual_otf").at("value").size(), json.at("mtf").at("value").size());
  EXPECT_EQ(json.at("correlation").size(), 1U);
  EXPECT_NE(read_file(scratch / "fit.svg.csv"), "");
  const mtf::io::ImageFile residual = mtf::io::read_image((scratch / "residuals" / "residual-1.exr").string());
  EXPECT_EQ(residual.planes.front().width(), 128);
}

// Jitter and smear along one direction have the same second moment: one edge cannot tell them apart.
TEST(FitCommand, SaysWhatOneEdgeCannotTell) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string fit_jitter =
      "rms = { value = \"2 um\", fit = true, min = \"0 um\", max = \"20 um\" }\n"
      "[[presample]]\nkind = \"linear_motion\"\n"
      "travel = { value = \"5 um\", fit = true, min = \"0 um\", max = \"40 um\" }";
  write_file(scratch / "fit.toml", replaced(read_file(scratch / "sensor.toml"), "rms = \"2 um\"", fit_jitter));
  const double s = 4.0 * 2.0 / 15.0;
  const made::Step step = made::camera_step({.s = s, .pixel = 1.0, .variance = 0.06}, 5.0);
  mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", made::make(step, {.noise_sd = 0.01}).view()}}, {});
  const Result fit = scratch.run("mtf fit fit.toml edge.exr -o fitted.toml --format json");
  ASSERT_EQ(fit.status, 0) << fit.err;
  const Json json = Json::parse(fit.out);
  ASSERT_EQ(json.at("not_separable").size(), 1U) << json;
  expect_says(json.at("not_separable")[0].at("text").get<std::string>(), {"jitter.rms"});
  for (const Json& parameter : json.at("parameters")) {
    EXPECT_TRUE(parameter.at("value").is_null()) << parameter;
    EXPECT_TRUE(parameter.at("stderr").is_null()) << parameter;
  }
  EXPECT_FALSE(says(read_file(scratch / "fitted.toml"), "stderr"));
  EXPECT_EQ(scratch.run("mtf config check fitted.toml").status, 0);
}

// A diffusion that is not there ends at its bound, where the derivative by it vanishes: the jitter beside it has an
// interval by profile and no standard error, and nothing is said of their correlation.
TEST(FitCommand, AFlatBoundGivesIntervals) {
  const Scratch scratch;
  scratch.add_sensor();
  const std::string fit_both =
      "rms = { value = \"3 um\", fit = true }\n"
      "[[presample]]\nkind = \"diffusion\"\nabsorption_length = \"10 um\"\ndepletion_depth = \"3 um\"\n"
      "diffusion_length = { value = \"3 um\", fit = true }\n"
      // With these no further unknown is tried, which would take ten times as long.
      "[[presample]]\nkind = \"linear_motion\"\ntravel = \"0 um\"\n[[presample]]\nkind = \"rms_wavefront\"\nrms = 0.0";
  write_file(scratch / "fit.toml", replaced(read_file(scratch / "sensor.toml"), "rms = \"2 um\"", fit_both));
  const made::Camera camera{.s = 4.0 * 2.0 / 15.0, .pixel = 1.0, .variance = 0.028};  // 2.5 um
  const mtf::Image edge = made::make(made::camera_step(camera, 5.0), {.noise_sd = 0.002, .seed = 4});
  mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", edge.view()}}, {});
  const Result fit = scratch.run("mtf fit fit.toml edge.exr -o fitted.toml --format json");
  ASSERT_EQ(fit.status, 0) << fit.err;
  const Json json = Json::parse(fit.out);
  const Json &jitter = json.at("parameters")[0], &diffusion = json.at("parameters")[1];
  ASSERT_EQ(diffusion.at("knowledge"), "at_bound") << json.at("parameters");
  EXPECT_GT(diffusion.at("limit95").get<double>(), 0.1);
  EXPECT_EQ(jitter.at("knowledge"), "interval") << jitter;
  EXPECT_TRUE(jitter.at("stderr").is_null());
  const Json& interval = jitter.at("interval");
  EXPECT_EQ(interval.at("confidence"), 0.95);
  EXPECT_TRUE(interval.at("reason").is_null());
  EXPECT_LT(interval.at("low").get<double>(), 2.5);
  EXPECT_GT(interval.at("high").get<double>(), 2.5);
  EXPECT_EQ(jitter.at("interval95")[0], interval.at("low"));
  EXPECT_TRUE(json.at("correlation")[0][1].is_null());
  EXPECT_TRUE(json.at("correlation")[1][0].is_null());
  EXPECT_TRUE(json.at("not_separable").empty());
  const std::string fitted = read_file(scratch / "fitted.toml");
  expect_says(fitted, {"jitter.rms: interval, 95 %"});
  EXPECT_FALSE(says(fitted, "stderr")) << fitted;

  const std::string table = scratch.run("mtf fit fit.toml edge.exr").out;
  expect_says(table, {"um (95 %: ", "not determined"});

  // Up to 1.5 um nothing speaks against a diffusion: its interval has no upper end, and says so.
  write_file(scratch / "short.toml",
             replaced(read_file(scratch / "fit.toml"), "diffusion_length = { value = \"3 um\", fit = true }",
                      "diffusion_length = { value = \"1 um\", fit = true, max = \"1.5 um\" }"));
  const Json open = Json::parse(scratch.run("mtf fit short.toml edge.exr --format json").out);
  const Json& end = open.at("parameters")[1].at("interval");
  ASSERT_TRUE(end.is_object()) << open.at("parameters");
  EXPECT_TRUE(end.at("high").is_null()) << end;
  EXPECT_TRUE(says(end.at("reason").get<std::string>(), "bound it from above")) << end;
  EXPECT_EQ(open.at("parameters")[1].at("knowledge"), "not_determined");
  expect_says(scratch.run("mtf fit short.toml edge.exr").out, {"bound it from above"});
}

// A sensor without the defocus that the edge has.
TEST(FitCommand, AModelThatDoesNotDescribeTheDataIsAFailedCheck) {
  const Scratch scratch;
  scratch.add_sensor();
  write_file(scratch / "fit.toml",
             replaced(read_file(scratch / "sensor.toml"), "rms = \"2 um\"", "rms = { value = \"2 um\", fit = true }"));
  const made::Camera camera{.s = 4.0 * 2.0 / 15.0, .pixel = 1.0, .w020 = 0.5};
  const mtf::Image edge = made::make(made::camera_step(camera, 5.0), {.noise_sd = 0.002});
  mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", edge.view()}}, {});
  const std::string command =
      "mtf fit fit.toml edge.exr -o fitted.toml --report fit.json --plot fit.svg --residuals residuals --format json";
  const auto all_written = [&] {
    for (const char* file : {"fitted.toml", "fit.json", "fit.svg.csv", "residuals/residual-1.exr"})
      EXPECT_TRUE(std::filesystem::exists(scratch / file)) << file;
  };
  const Result wrong = scratch.run(command);
  EXPECT_EQ(wrong.status, 3) << wrong.err;
  EXPECT_EQ(Json::parse(wrong.out).at("status"), "converged_model_wrong");
  expect_says(wrong.err, {"--allow-misfit"});
  all_written();
  for (const char* file : {"fitted.toml", "fit.json", "fit.svg.csv", "residuals"})
    std::filesystem::remove_all(scratch / file);
  const Result allowed = scratch.run(command + " --allow-misfit");
  EXPECT_EQ(allowed.status, 0) << allowed.err;
  EXPECT_EQ(Json::parse(allowed.out).at("status"), "converged_model_wrong");
  all_written();
}

/// f/8 out of focus, in visible light, pitch 4.73 um, and what the sensor file gives of it.
struct OutOfFocus {
  std::string text =
      "schema = 1\n[frame]\nfocal_length = \"50 mm\"\npitch = \"4.73 um\"\n[optics]\nf_number = 8.0\n"
      "wavelength = \"0.55 um\"\n[[presample]]\nkind = \"PUPIL\"\n[[presample]]\nkind = \"footprint\"\n"
      "width = \"4.73 um\"\n";
  OutOfFocus(const Scratch& scratch, double waves, double noise_sd) {
    made::Camera camera = made::camera_of(8.0);
    camera.w020 = waves;
    const mtf::Image edge = made::make(made::camera_step(camera, 5.0), {.noise_sd = noise_sd, .seed = 3});
    mtf::io::write_exr((scratch / "edge.exr").string(), {{"Y", edge.view()}}, {});
  }
};

// Defocus has no sign: the fit gives both, in the table, in JSON and above the fitted file, which has no stderr then.
TEST(FitCommand, BothSignsOfADefocus) {
  const Scratch scratch;
  const OutOfFocus made(scratch, 0.35, 0.01);
  write_file(scratch / "fit.toml",
             replaced(made.text, "\"PUPIL\"", "\"defocus\"\nwaves = { value = -0.2, fit = true }"));
  const Result fit = scratch.run("mtf fit fit.toml edge.exr -o fitted.toml --format json");
  ASSERT_EQ(fit.status, 0) << fit.err;
  const Json json = Json::parse(fit.out), waves = json.at("parameters")[0];
  EXPECT_EQ(waves.at("knowledge"), "ambiguous");
  EXPECT_NEAR(waves.at("value").get<double>(), -0.35, 4.0 * waves.at("stderr").get<double>());
  ASSERT_EQ(waves.at("other_values").size(), 1U);
  EXPECT_EQ(waves.at("other_values")[0].at("value").get<double>(), -waves.at("value").get<double>());
  EXPECT_EQ(waves.at("other_values")[0].at("chi2_rise"), 0.0);
  EXPECT_EQ(json.at("alternatives")[0].at("parameters")[0], "defocus.waves");
  const std::string fitted = read_file(scratch / "fitted.toml");
  expect_says(fitted, {"# defocus.waves: ambiguous, -0.3"});
  EXPECT_FALSE(says(fitted, "stderr")) << fitted;
  const std::string table = scratch.run("mtf fit fit.toml edge.exr").out;
  expect_says(table, {" or 0.3", "do not tell -0.3"});
}

// The lens of f/8 fitted without its defocus: residuals that look right, and yet not what the data say.
TEST(FitCommand, WhatOneMoreUnknownMakesOfAValue) {
  const Scratch scratch;
  const OutOfFocus made(scratch, 0.4, 0.02);
  write_file(scratch / "fit.toml", replaced(replaced(made.text, "PUPIL", "diffraction"), "f_number = 8.0",
                                            "f_number = { value = 6.0, fit = true }"));
  const Result fit = scratch.run("mtf fit fit.toml edge.exr -o fitted.toml --format json");
  EXPECT_EQ(fit.status, 3) << fit.err;
  const Json json = Json::parse(fit.out), f_number = json.at("parameters")[0];
  EXPECT_EQ(json.at("status"), "converged_model_wrong");
  EXPECT_TRUE(says(json.at("reason").get<std::string>(), "defocus unknown")) << json.at("reason");
  EXPECT_GT(json.at("whiteness_p").get<double>(), 1e-4);
  const Json& model = json.at("richer_models")[0];
  EXPECT_EQ(model.at("unknown"), "defocus");
  EXPECT_LT(model.at("p").get<double>(), 1e-6);
  const Json& then = f_number.at("model_sensitivity")[0];
  EXPECT_EQ(then.at("unknown"), "defocus");
  EXPECT_NEAR(then.at("value").get<double>(), 8.0, 4.0 * then.at("stderr").get<double>());
  EXPECT_NEAR(then.at("moves_by").get<double>(), then.at("value").get<double>() - f_number.at("value").get<double>(),
              1e-9);
  expect_says(read_file(scratch / "fitted.toml"), {"# optics.f_number with unknown"});
  const Result table = scratch.run("mtf fit fit.toml edge.exr --allow-misfit");
  EXPECT_EQ(table.status, 0);
  expect_says(table.out, {"   with unknown defocus: "});
}

// The same curve as a plain CSV and in the JSON of another program.
TEST(FitCommand, CurvesInJson) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  const std::string ask = "mtf curve demo/sensor.toml --freq 0.125,0.25,0.375 --unit cy/px --format json";
  const Json values = Json::parse(scratch.run(ask).out).at("system").at("re"), frequencies{0.125, 0.25, 0.375};
  std::string csv = "frequency_cy_px,mtf\n";
  for (std::size_t i = 0; i < 3; ++i) csv += frequencies[i].dump() + "," + values[i].dump() + "\n";
  write_file(scratch / "a.csv", csv);
  const Json edge{{"frequency", frequencies}, {"freq_units", "Cy/Pxl"}, {"MTF_R", {1, 1, 1}}, {"MTF_Y", values}};
  write_file(scratch / "a.json", Json{{"sfrResults", {{"edges", {edge, edge}}, {"mtf50", {0.2, 0.3}}}}}.dump());
  const auto jitter = [&](const std::string& files) {
    const Result fit = scratch.run("mtf fit demo/fit.toml --format json " + files);
    EXPECT_EQ(fit.status, 0) << fit.err;
    return Json::parse(fit.out).at("parameters")[0];
  };
  EXPECT_NEAR(jitter("--curve a.csv").at("value").get<double>(), 2.0, 1e-3);  // of the sensor that the curve is of
  EXPECT_EQ(jitter("--curve a.json"), jitter("--curve a.csv --curve a.csv"));
  write_file(scratch / "bad.json", Json{{"freq", frequencies}, {"MTF", values}}.dump());
  expect_error(scratch.run("mtf fit demo/fit.toml --curve bad.json"), 2, {"bad.json", "no unit"});
  EXPECT_EQ(jitter("--curve bad.json --curve-unit cy/px"), jitter("--curve a.csv"));
  const auto refused = [&](const std::string& text, std::initializer_list<std::string_view> parts) {
    write_file(scratch / "bad.json", text);
    expect_error(scratch.run("mtf fit demo/fit.toml --curve bad.json"), 2, parts);
  };
  refused(R"({"a;b": [1, 2], "Cy/Pxl": [0.1, 0.2], "MTF_G": [0.9, 0.7], "MTF_Y": [0.9, null]})",
          {"bad.json: $", "element 1", "null"});
  refused(R"({"Cy/Pxl": [0.2, 0.1], "MTF": [0.9, 0.7]})", {"element 1", "increase"});
  refused(R"({"Cy/Pxl": [0.2, 0.1)", {"bad.json", "no JSON", "line 1"});
  write_file(scratch / "bad.json", R"({"mtf50": 0.2})");
  expect_error(scratch.run("mtf fit demo/fit.toml --curve bad.json"), 2, {"bad.json", "frequency_cy_px"});
}

// Data that are given twice count as independent: that is said, whatever names and regions they have.
TEST(FitCommand, DataGivenTwiceAreTold) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  write_file(scratch / "c.csv", "frequency_cy_px,mtf,sd\n0.05,0.95,0.02\n0.1,0.9,0.02\n0.2,0.7,0.02\n0.3,0.5,0.02\n");
  const auto told = [&](const std::string& data) {
    const Result result = scratch.run("mtf fit demo/fit.toml --format json " + data);
    const Json warnings = Json::parse(result.out).at("warnings");
    std::string all;
    for (const Json& one : warnings)
      if (says(one.get<std::string>(), "is given twice")) all += one.get<std::string>() + "\n";
    return all;
  };
  expect_says(told("demo/edge.exr demo/../demo/edge.exr"), {"demo/../demo/edge.exr", "counts as independent"});
  expect_says(told("demo/edge.exr --roi 32,32,64,64 --roi 32,32,64,64"), {"edge.exr 32,32,64,64"});
  expect_says(told("--curve c.csv --curve ./c.csv"), {"./c.csv is given twice"});
  expect_says(told("--curve c.csv --spot demo/edge.exr --spot ./demo/edge.exr"), {"./demo/edge.exr is given twice"});
  EXPECT_EQ(told("demo/edge.exr --roi 32,32,64,64 --roi 32,33,64,64 --curve c.csv"), "");
}

// A chart over the field at two settings of the focus. At one of them w020 and w222 may all have the other sign
// (FitField.OneFocusSettingLeavesTheSignOfEvenTermsOpen); the second one tells it.
TEST(FitCommand, ASecondFocusTellsTheSignOverTheField) {
  const Scratch scratch;
  const field_chart::Lens lens{.w040 = 0.0, .w131 = 0.5, .w222 = 0.6, .curvature = 0.4, .tilt_x = 0.0, .tilt_y = 0.0};
  constexpr int kColumns = 4, kRows = 3;
  const std::vector<field_chart::Patch> patches = field_chart::patches(kColumns, kRows);
  std::string regions = "x,y,width,height\n";
  for (const auto& [column, row, angle_deg] : patches)
    regions += std::to_string(32 * column) + "," + std::to_string(32 * row) + ",32,32\n";
  write_file(scratch / "regions.csv", regions);
  for (const auto& [name, more_focus] : {std::pair{"chart.exr", 0.0}, {"refocused.exr", 0.5}}) {
    const mtf::Image chart = field_chart::with_noise(
        field_chart::image_of(field_chart::sensor_of(lens, kColumns, kRows, more_focus), patches), 0.006, 7);
    mtf::io::write_exr((scratch / name).string(), {{"Y", chart.view()}}, {});
  }
  write_file(scratch / "lens.toml",
             "schema = 2\n[frame]\nfocal_length = \"50 mm\"\npitch = \"4.73 um\"\nformat = [128, 96]\n[optics]\n"
             "f_number = 5.6\nwavelength = \"0.55 um\"\n[[presample]]\nkind = \"wavefront\"\norientation = \"field\"\n"
             "w131 = { r = 0.5 }\nw222 = { r2 = { value = 0.4, fit = true } }\nzernike = [0, 0, 0, 0]\n"
             "w020 = { 1 = { value = -0.1, fit = true }, r2 = { value = 0.2, fit = true } }\n"
             "[[presample]]\nkind = \"footprint\"\nwidth = \"1 px\"\n");
  write_file(scratch / "focus.csv", "frame,parameter,value\n2,wavefront.zernike[3],0.25\n");  // Z4: 2 p^2 - 1
  const Result result = scratch.run(
      "mtf fit lens.toml --roi-file regions.csv --format json chart.exr refocused.exr --conditions focus.csv");
  ASSERT_EQ(result.status, 0) << result.err << result.out;
  const std::map<std::string, double> truth{
      {"wavefront.w222.r2", lens.w222}, {"wavefront.w020.1", lens.focus}, {"wavefront.w020.r2", lens.curvature}};
  const Json parameters = Json::parse(result.out).at("parameters");
  ASSERT_EQ(parameters.size(), truth.size());
  for (const Json& p : parameters) {
    EXPECT_EQ(p.at("knowledge"), "determined") << p;
    EXPECT_TRUE(p.at("other_values").empty()) << p;
    ASSERT_TRUE(p.at("stderr").is_number()) << p;
    EXPECT_NEAR(p.at("value").get<double>(), truth.at(p.at("name")), 4.0 * p.at("stderr").get<double>()) << p;
  }
}

// What is fitted holds for all images: one of --conditions cannot set it.
TEST(FitCommand, AConditionThatSetsWhatIsFittedIsRefused) {
  const Scratch scratch;
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  ASSERT_EQ(scratch.run("cp demo/edge.exr other.exr").status, 0);
  const std::string fit = "mtf fit demo/fit.toml demo/edge.exr other.exr --conditions c.csv";
  write_file(scratch / "c.csv", "frame,parameter,value\n2,jitter.rms,1 um\n");
  expect_error(scratch.run(fit), 2, {"other.exr", "jitter.rms", "out of the conditions", "fit = true away"});
}

TEST(FitCommand, BadRequests) {
  const Scratch scratch;
  scratch.add_sensor();
  ASSERT_EQ(scratch.run("mtf demo -o demo").status, 0);
  const auto refused = [&](const std::string& arguments, const std::string& word, int status = 2) {
    const Result result = scratch.run("mtf fit " + arguments);
    EXPECT_EQ(result.status, status) << arguments << result.out;
    expect_says(result.err + result.out, {word});
    EXPECT_FALSE(std::filesystem::exists(scratch / "fitted.toml")) << arguments;
  };
  refused("sensor.toml demo/edge.exr -o fitted.toml", "nothing to fit");
  refused("demo/fit.toml -o fitted.toml", "no data");
  refused("demo/fit.toml demo/edge.exr -o demo/fit.toml", "demo/fit.toml");
  refused("demo/fit.toml demo/edge.exr --curve missing.csv", "missing.csv", 1);
  write_file(scratch / "curve.csv", "frequency_cy_px,mtf\n0.1,nan\n0.2,0.5\n");
  refused("demo/fit.toml --curve curve.csv -o fitted.toml", "curve.csv");
}

}  // namespace
}  // namespace apps_test
