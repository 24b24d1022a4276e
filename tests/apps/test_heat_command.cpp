// SPDX-License-Identifier: Apache-2.0

// `mtf scene` and `mtf heat`: files, what they say, and what is refused without leaving anything.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/apps/heat_command_case.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

TEST_F(HeatCommand, WritesWhatItSays) {
  const Result result = scratch_.run("mtf heat scene.toml -o out --ply --tolerance '0.1 K'");
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"2 facets", "2 classes", "13 outputs"});
  const auto regions = lines_of(read_file(scratch_ / "out/regions.csv"));
  ASSERT_EQ(regions.size(), 14U);
  EXPECT_EQ(regions[0], "time,region,min_K,mean_K,max_K");
  EXPECT_EQ(regions[1].substr(0, 28), "2026-06-21T00:00:00Z,plates,");
  EXPECT_EQ(lines_of(read_file(scratch_ / "out/times.csv")).size(), 14U);
  const auto facets = lines_of(read_file(scratch_ / "out/facets.csv"));
  ASSERT_EQ(facets.size(), 3U);
  EXPECT_EQ(facets[1], "0,plates,plates,steel,1,0.5,0.5,0,0,0,1");
  EXPECT_EQ(facets[2], "1,plates,plates,steel,1,0.5,0.5,1,0,0,1");
  // An NPY header of 128 bytes and 13 x 2 numbers of 4 bytes; the mean of a region is that of its facets.
  const std::string npy = read_file(scratch_ / "out/temperatures.npy");
  ASSERT_EQ(npy.size(), 128U + 13 * 2 * 4);
  std::array<float, 26> kelvin{};
  std::memcpy(kelvin.data(), npy.data() + 128, sizeof kelvin);
  for (std::size_t i = 0; i < 13; ++i) {
    const double mean = std::stod(regions[i + 1].substr(regions[i + 1].find(',', 28) + 1));
    EXPECT_NEAR(mean, 0.5 * (double{kelvin[2 * i]} + double{kelvin[2 * i + 1]}), 1e-4) << i;
  }
  const auto json = nlohmann::json::parse(read_file(scratch_ / "out/heat.json"));
  EXPECT_LE(json.at("promised_K").get<double>(), 0.1);
  EXPECT_EQ(json.at("facets"), 2);
  EXPECT_EQ(json.at("closures").at("materials").at(0).at("convection"), "mcadams");
  EXPECT_LT(json.at("materials").at(0).at("energy_drift").get<double>(), 1e-12);
  for (const char* name : {"scene.png", "facets.ply"})
    EXPECT_GT(read_file(scratch_ / ("out/" + std::string(name))).size(), 100U);
}

TEST_F(HeatCommand, VerifiesWhatItPromises) {
  const Result result = scratch_.run("mtf heat scene.toml -o out --verify --tolerance '0.3 K'");
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"against runs"});
  const auto json = nlohmann::json::parse(read_file(scratch_ / "out/heat.json"));
  const nlohmann::json& classes = json.at("realised").at("as_classes");
  EXPECT_LE(classes.at("largest_K"), json.at("promised_K"));
  EXPECT_GT(classes.at("largest_K"), 0.0);
  EXPECT_EQ(json.at("realised").at("each_facet").at("count"), 2);
  ASSERT_EQ(scratch_.run("mtf heat scene.toml -o plain").status, 0);
  EXPECT_TRUE(nlohmann::json::parse(read_file(scratch_ / "plain/heat.json")).at("realised").is_null());
}

// The camera looks down on a cube, whose top sees the sky alone and does not depend on the other sides.
TEST_F(HeatCommand, LeavesOutWhatTheCameraDoesNotSee) {
  std::string text = replaced(kScene, "[\"4 m\", \"-3 m\", \"3 m\"]", "[\"0.4 m\", \"0.5 m\", \"9 m\"]");
  text = replaced(text, "[[region]]", "[[region]]\ngroup = \"low\"");
  text = replaced(text, "[camera]", "[[region]]\nmesh = \"plates\"\ngroup = \"high\"\nmaterial = \"steel\"\n[camera]");
  write_file(scratch_ / "scene.toml", text);
  write_file(scratch_ / "plates.obj",
             kPlates.substr(0, kPlates.find("f 1")) +
                 "g high\nf 5 6 7 8\ng low\nf 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const Result result = scratch_.run("mtf heat scene.toml -o out --seen --ply --vtk --sensitivity --tolerance '0.1 K'");
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"sees 1 facets", "not seen"});
  ASSERT_EQ(scratch_.run("mtf heat scene.toml -o all --tolerance '0.1 K'").status, 0);
  constexpr std::size_t kFacets = 6, kOutputs = 13;
  const auto kelvin_in = [&](const std::string& folder) {
    std::vector<float> kelvin(kFacets * kOutputs);
    const std::string npy = read_file(scratch_ / (folder + "/temperatures.npy"));
    EXPECT_EQ(npy.size(), 128U + sizeof(float) * kelvin.size());
    std::memcpy(kelvin.data(), npy.data() + 128, sizeof(float) * kelvin.size());
    return kelvin;
  };
  const std::vector<float> seen = kelvin_in("out"), all = kelvin_in("all");
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (i % kFacets == 0)
      EXPECT_NEAR(seen[i], all[i], 1e-3) << i;
    else
      EXPECT_TRUE(std::isnan(seen[i])) << i;
  const auto regions = lines_of(read_file(scratch_ / "out/regions.csv"));
  EXPECT_TRUE(regions[1].ends_with(",low,,,")) << regions[1];
  EXPECT_FALSE(regions[2].ends_with(",")) << regions[2];
  const auto json = nlohmann::json::parse(read_file(scratch_ / "out/heat.json"));
  EXPECT_EQ(json.at("seen").at("facets"), 1);
  EXPECT_EQ(json.at("seen").at("facets_left_out"), 5);
  EXPECT_TRUE(nlohmann::json::parse(read_file(scratch_ / "all/heat.json")).at("seen").is_null());

  // Where temperatures are taken from there, one that is missing is named.
  write_file(scratch_ / "table.toml",
             replaced(text, "group = \"low\"", "group = \"low\"\ntemperature = \"out/temperatures.npy\""));
  expect_error(scratch_.run("mtf heat table.toml -o taken"), 2, {"'low'", "temperature"});

  EXPECT_EQ(scratch_.run("mtf heat scene.toml -o fit.toml --fit --seen").status, 2);
  write_file(scratch_ / "scene.toml", kScene.substr(0, kScene.find("[camera]")));
  expect_error(scratch_.run("mtf heat scene.toml -o none --seen"), 2, {"[camera]"});
  EXPECT_FALSE(fs::exists(scratch_ / "none"));
}

TEST_F(HeatCommand, BenchShowsWhatAToleranceCosts) {
  const Result result =
      scratch_.run("mtf bench scene.toml -o ladder --tolerance '1 K' --tolerance '0.1 K' --format csv");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto rows = lines_of(result.out);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].substr(0, 33), "tolerance_K,promised_K,realised_K");
  EXPECT_EQ(result.out, read_file(scratch_ / "ladder/heat_bench.csv"));
  const auto json = nlohmann::json::parse(read_file(scratch_ / "ladder/heat_bench.json"));
  for (const nlohmann::json& row : json.at("rows")) {
    EXPECT_LE(row.at("promised_K"), row.at("tolerance_K"));
    EXPECT_LE(row.at("realised_K"), row.at("promised_K"));
    EXPECT_GT(row.at("time_ms_min"), 0.0);
  }
  EXPECT_LT(json.at("rows").at(1).at("realised_K"), json.at("rows").at(0).at("realised_K"));
  EXPECT_EQ(scratch_.run("mtf bench scene.toml -o ladder").status, 2);  // not empty
  EXPECT_EQ(scratch_.run("mtf bench scene.toml -o other --channel R").status, 2);
}

TEST_F(HeatCommand, CheckAndExplain) {
  EXPECT_EQ(scratch_.run("mtf scene check scene.toml").out, "scene.toml: ok, 2 facets in 1 region\n");
  const Result explained = scratch_.run("mtf scene explain scene.toml");
  ASSERT_EQ(explained.status, 0) << explained.err;
  // C = 7800 x 480 x 0.005 J/m2/K, h = 5.7 + 3.8 x 2.
  EXPECT_TRUE(
      std::regex_search(explained.out, std::regex("steel +5 +0\\.000111 +18\\.7 +0\\.7 +0\\.9 +13\\.3 +17 min")))
      << explained.out;
  expect_says(explained.out, {"rises at 2026-06-21T04:"});
}

TEST_F(HeatCommand, TheDemoIsAScene) {
  ASSERT_EQ(scratch_.run("mtf scene demo -o demo").status, 0);
  const Result checked = scratch_.run("mtf scene check demo/scene.toml");
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_EQ(checked.out, "demo/scene.toml: ok, 185836 facets in 5 regions\n");
  EXPECT_EQ(scratch_.run("mtf scene demo -o demo").status, 2);  // not empty
}

TEST_F(HeatCommand, RefusalsLeaveNothing) {
  const auto refused = [&](const std::string& command, const std::string& words) {
    const Result result = scratch_.run(command);
    EXPECT_NE(result.status, 0) << command;
    expect_says(result.err, {words});
    EXPECT_FALSE(fs::exists(scratch_ / "out")) << command;
  };
  refused("mtf heat scene.toml -o out --tolerance 0.1", "\"0.1 K\"");
  refused("mtf heat scene.toml -o out --tolerance '0 K'", "above 0");
  refused("mtf heat missing.toml -o out", "missing.toml");
  std::string text = kScene;
  text = replaced(text, "convection = \"mcadams\"", "convection = \"none\"");
  text = replaced(text, "[[mesh]]", "inside = { kind = \"flux\", flux = \"-600 W/m2\" }\n[[mesh]]");
  write_file(scratch_ / "frozen.toml", text);
  refused("mtf heat frozen.toml -o out", "region 'plates' comes to");
  write_file(scratch_ / "times.csv",
             "time,air_temperature (K),wind_speed (m/s),direct_normal (W/m2),diffuse_horizontal (W/m2),longwave_down "
             "(W/m2)\n1999-06-21T00:00:00Z,288,2,0,0,320\n");
  text = kScene;
  const std::size_t values = text.find("air_temperature");
  text.replace(values, text.find("[[material]]") - values, "file = \"times.csv\"\n");
  write_file(scratch_ / "once.toml", text);
  refused("mtf heat once.toml -o out", "it has one record");
  expect_error(scratch_.run("mtf heat once.toml -o . --force"), 2, {"which this run reads"});
  write_file(scratch_ / "plates.obj", "v 0 0 0\n");
  refused("mtf heat scene.toml -o out", "plates.obj");
  write_file(scratch_ / "plates.obj", kPlates);
  text = kScene;
  text = replaced(text, "2026-06-22T00:00:00Z", "2026-06-22T00:00:00");
  write_file(scratch_ / "zoneless.toml", text);
  refused("mtf heat zoneless.toml -o out", "zoneless.toml:8:");
  text = kScene;
  text = replaced(text, "longwave_down = \"320 W/m2\"\n", "");
  write_file(scratch_ / "skyless.toml", text);
  refused("mtf heat skyless.toml -o out", "longwave_down");
}

TEST_F(HeatCommand, NamesMissingFilesWithTheirPlace) {
  std::filesystem::remove(scratch_ / "plates.obj");
  expect_error(scratch_.run("mtf heat scene.toml -o out"), 1, {"scene.toml:24:8", "mesh[0].file", "plates.obj"});
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "out"));
}

TEST_F(HeatCommand, SaysWhatTheTemperaturesDependOn) {
  const Result result = scratch_.run("mtf heat scene.toml -o out --sensitivity --vtk --tolerance '0.1 K' --rays 64");
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.out, {"convection +10 %"});
  const auto rows = lines_of(read_file(scratch_ / "out/sensitivity.csv"));
  ASSERT_EQ(rows.size(), 7U);
  EXPECT_EQ(rows[0], "change,region,mean_K,largest_K");
  const auto mean = [&](std::size_t row) {
    std::istringstream cells(rows[row]);
    std::string cell;
    for (int i = 0; i < 3; ++i) std::getline(cells, cell, ',');
    return std::stod(cell);
  };
  // The sunlit plates are warmer than the air: more wind cools them. 10 W/m2 of long wave, times 0.9, into what gives
  // off 13.3 + 5 W/m2 for each kelvin is 0.49 K where a plate sees nothing but the sky; the lower one sees less of it.
  EXPECT_LT(mean(1), -0.2);
  EXPECT_GT(mean(2), 0.2);
  EXPECT_LT(mean(2), 0.55);
  EXPECT_GT(mean(3), 0.0);
  EXPECT_TRUE(read_file(scratch_ / "out/facets.vtk").starts_with("# vtk DataFile"));
}

// The shipped day was made with other numbers than the file's, which it keeps: make_ground_day.py has them.
TEST(HeatFitCommand, FindsTheNumbersOfTheExample) {
  const Scratch scratch;
  const std::filesystem::path data = std::filesystem::path(MTFKIT_SOURCE_DIR) / "notebooks-data/heat";
  for (const char* name : {"ground.toml", "ground_weather.csv"}) write_file(scratch / name, read_file(data / name));
  const Result fit = scratch.run("mtf heat ground.toml --fit -o fitted.toml --format json --plot fit.svg");
  ASSERT_EQ(fit.status, 0) << fit.err;
  const nlohmann::json json = nlohmann::json::parse(fit.out);
  EXPECT_EQ(json.at("status"), "converged");
  const std::array<double, 4> truth{9.0, 2.2, 0.55, 6.0};
  ASSERT_EQ(json.at("parameters").size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const nlohmann::json& p = json.at("parameters")[i];
    EXPECT_EQ(p.at("knowledge"), "determined") << p;
    EXPECT_NEAR(p.at("value").get<double>(), truth[i], 3.0 * p.at("stderr").get<double>()) << p;
  }
  EXPECT_LT(json.at("after").at("rms_K").get<double>(), 0.3);
  EXPECT_GT(json.at("before").at("rms_K").get<double>(), 1.0);
  EXPECT_TRUE(std::filesystem::exists(scratch / "fit.svg.csv"));

  const std::string text = read_file(scratch / "fitted.toml");
  EXPECT_TRUE(text.starts_with("# ground.toml (sha256 ")) << text;
  expect_says(text, {"# The first guess:", "dry sandy soil", "stderr = "});
  const Result again = scratch.run("mtf heat fitted.toml -o day");
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(lines_of(read_file(scratch / "day/facets.csv")).size(), 2U);
  // Fitted again it stays, and the head is not doubled.
  ASSERT_EQ(scratch.run("mtf heat fitted.toml --fit -o twice.toml").status, 0);
  const std::string twice = read_file(scratch / "twice.toml");
  EXPECT_EQ(twice.find("fitted by mtf"), twice.rfind("fitted by mtf"));

  EXPECT_EQ(scratch.run("mtf heat ground.toml --fit -o ground_weather.csv").status, 2);
  EXPECT_EQ(scratch.run("mtf heat ground.toml -o out --plot fit.svg").status, 2);
  EXPECT_EQ(scratch.run("mtf heat ground.toml --fit -o x.toml --ply").status, 2);
  EXPECT_FALSE(std::filesystem::exists(scratch / "x.toml"));
}

}  // namespace
}  // namespace apps_test
