// SPDX-License-Identifier: Apache-2.0

// What `mtf budget` says beside its figures, and what every command says of a sensor file that makes no chain.

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <sstream>

#include "mtf/words.h"
#include "tests/apps/chain_sensor.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

class BudgetCommand : public ChainSensor {
 protected:
  /// The words of the row of the table that begins with `name`; none without one. Titles of groups are no rows.
  static std::vector<std::string> line_of(const std::string& table, const std::string& name) {
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("  ")) continue;
      std::istringstream words(line);
      const std::vector<std::string> all{std::istream_iterator<std::string>(words), {}};
      if (!all.empty() && all.front() == name) return all;
    }
    return {};
  }
};

TEST_F(BudgetCommand, ABudgetSaysWhyAFigureHasNoValue) {
  sensor("");
  for (const char* hot : {"1e100", "1.1e9", "-1", "nan"}) {
    expect_error(scratch.run(std::string("mtf budget s.toml --temperature ") + hot), 2, {"temperature"});
  }
  expect_says(scratch.run("mtf budget s.toml --temperature 1e100").err, {"from 0 to 1e9"});
  const std::string table = scratch.run("mtf budget s.toml --temperature 0").out;
  expect_says(table, {"no shot_netd, netd, ", "no light", "makes electrons"});
  sensor("", "full_well = \"10 Me-\"\n", "");
  const Json terms = budget();
  EXPECT_TRUE(terms["dynamic_range"]["value"].is_null());
  EXPECT_EQ(terms["dynamic_range"]["reason"], "no detector.full_well");
  for (const auto& [name, term] : terms.items()) EXPECT_EQ(term["value"].is_null(), term.contains("reason")) << name;
}

// The table is for people: what JSON has, in 4 digits, with the share of each term in its variance and the largest in
// words; rows of 0 are named in one line.
TEST_F(BudgetCommand, TheTableSaysWhatTheNoiseIsMadeOf) {
  const std::string camera = "[noise]\nseed = 1\nrow = \"300 e-\"\n[nonuniformity]\nprnu = 0.001\ndsnu = \"2 ke-\"\n";
  const std::map<std::string, std::vector<std::string>> sums{{"temporal", {"scene_shot", "read", "other"}},
                                                             {"spatial", {"prnu", "dsnu"}}};
  for (const double read_e : {500.0, 5e4}) {
    sensor(camera, "\"500 e-\"", "\"" + std::to_string(read_e) + " e-\"");
    const Json terms = budget();
    const std::string table = scratch.run("mtf budget s.toml").out;
    for (const auto& [name, term] : terms.items()) {
      const std::vector<std::string> line = line_of(table, name);
      const double value = term["value"];
      ASSERT_EQ(line.size() >= 2, value != 0.0) << name;
      if (value != 0.0)
        EXPECT_NEAR(std::stod(line[1]), value, 5.001e-4 * std::abs(value)) << name;
      else
        EXPECT_TRUE(says(table.substr(table.find("\nZero: ")), name)) << name;
    }
    for (const auto& [sum, parts] : sums) {
      std::string largest = parts.front();
      for (const std::string& part : parts) {
        const auto share = [&](const std::string& name) {
          return 100.0 * std::pow(terms[name]["value"].get<double>() / terms[sum]["value"].get<double>(), 2);
        };
        if (share(part) > share(largest)) largest = part;
        const std::vector<std::string> line = line_of(table, part);
        ASSERT_GT(line.size(), 4U);
        const std::string& shown = line[3] == "<" ? line[4] : line[3];
        EXPECT_NEAR(std::stod(shown), share(part), 0.05001 + (line[3] == "<" ? 0.05 : 0.0)) << part;
      }
      expect_says(table, {"The largest " + sum + " term, ", " is " + largest + ": "});
    }
  }
}

// Noise of several steps of the converter dithers it: what rounding leaves is far below what a double resolves.
TEST_F(BudgetCommand, RowsNextToNothingAreNamedAmongTheZeros) {
  const std::string spatial = "[noise]\nseed = 1\n[nonuniformity]\ndsnu = \"2 ke-\"\n[adc]\nbits = ";
  for (const auto& [bits, nothing] : {std::pair{"13\n", true}, std::pair{"12\n", false}}) {
    sensor(spatial + bits);
    const double rounding = budget()["rounding"]["value"];
    ASSERT_GT(rounding, 0.0);
    ASSERT_EQ(rounding < 1e-12 * 2000.0, nothing) << rounding;
    const std::string table = scratch.run("mtf budget s.toml").out;
    EXPECT_EQ(line_of(table, "rounding").empty(), nothing);
    EXPECT_EQ(says(table.substr(table.find("\nZero: ")), "rounding (" + mtf::significant(rounding, 2) + " e-)"),
              nothing);
  }
}

TEST_F(BudgetCommand, ANoiselessTableHasNoLargestTerm) {
  sensor("", "read_noise = \"500 e-\"\n", "");
  const std::string dark = scratch.run("mtf budget s.toml --temperature 0").out;
  EXPECT_FALSE(says(dark, "The largest "));
  expect_says(dark, {"\nZero: scene, "});
}

// |sinc(w / (2 p))| of a square of side w at the Nyquist frequency of pixels of the pitch p.
TEST_F(BudgetCommand, TheTableHasTheMtfAtNyquistAlongBothAxes) {
  write_file(scratch / "s.toml",
             replaced(replaced(kSensor, "pitch = \"15 um\"", "pitch_x = \"20 um\"\npitch_y = \"30 um\""),
                      "[[presample]]\nkind = \"diffraction\"\n", ""));
  const std::string table = scratch.run("mtf budget s.toml").out;
  const auto sinc = [](double x) { return std::sin(std::numbers::pi * x) / (std::numbers::pi * x); };
  for (const auto& [name, pitch_um] : {std::pair{"mtf_nyquist_x", 20.0}, std::pair{"mtf_nyquist_y", 30.0}}) {
    const std::vector<std::string> line = line_of(table, name);
    ASSERT_GT(line.size(), 2U) << name;
    EXPECT_NEAR(std::stod(line[1]), sinc(15.0 / (2.0 * pitch_um)), 6e-5) << name;
  }
  expect_says(table, {"along x, 25 cy/mm", "along y, 16.67 cy/mm"});
}

// Of a lens that changes over the field: the budget of one place is that of the sensor as it is there.
TEST_F(BudgetCommand, APlaceInTheImage) {
  const std::string sensor = replaced(kSensor, "pitch = \"15 um\"", "pitch = \"15 um\"\nformat = [640, 512]");
  const auto lens = [&](const std::string& w020) {
    return replaced(sensor, "kind = \"diffraction\"", "kind = \"wavefront\"\nw020 = " + w020);
  };
  write_file(scratch / "field.toml", lens("{ r2 = 0.8 }"));
  write_file(scratch / "there.toml", lens("0.4"));
  const auto terms = [&](const std::string& command) {
    const Result run = scratch.run("mtf budget " + command + " --format json");
    EXPECT_EQ(run.status, 0) << run.err;
    return Json::parse(run.out).at("terms");
  };
  const std::string half = " --field 0.5,0.5";  // r^2 of 1/2
  const Json here = terms("field.toml" + half), there = terms("there.toml");
  for (const auto& [name, row] : there.items()) {
    if (!row.at("value").is_number()) continue;
    const double value = row.at("value").get<double>();
    EXPECT_NEAR(here.at(name).at("value").get<double>(), value, 1e-9 * std::abs(value)) << name;
  }
  expect_says(scratch.run("mtf budget field.toml").out,
              {"on the optical axis", "mtf_nyquist_x.mean", "mtf_nyquist_y.worst", "of 81 places, at pixel"});
  expect_says(scratch.run("mtf budget field.toml" + half).out, {"at the field point (0.5, 0.5)"});
  expect_error(scratch.run("mtf budget field.toml --field 1"), 2, {"--field"});
}

TEST_F(BudgetCommand, ATemperatureMayHaveItsUnit) {
  sensor("");
  const std::string plain = scratch.run("mtf budget s.toml --temperature 288").out;
  EXPECT_EQ(scratch.run("mtf budget s.toml --temperature '288 K'").out, plain);
  EXPECT_EQ(scratch.run("mtf budget s.toml --temperature 288K").out, plain);
  EXPECT_EQ(scratch.run("mtf budget s.toml --temperature '14.85 degC'").out, plain);
  EXPECT_EQ(scratch.run("mtf budget s.toml --temperature '14.85 °C'").out, plain);
  const Result cold = scratch.run("mtf budget s.toml --temperature 27");
  EXPECT_EQ(cold.status, 0);
  expect_says(cold.err, {"27 K", "\"27 degC\""});
  EXPECT_FALSE(says(scratch.run("mtf budget s.toml --temperature '27 K'").err, "Celsius"));
  for (const char* wrong : {"'288 mK'", "'15 C'", "K", "''"})
    expect_refused(std::string("mtf budget s.toml --temperature ") + wrong, {"a temperature in K"});
}

// One message for every command, in the words of the sensor file.
TEST_F(BudgetCommand, ADetectorThatMakesNoElectronsIsRefusedAlike) {
  const auto all_say = [&](const std::string& part) {
    for (const std::string command : {"budget s.toml", "simulate s.toml t300.exr -o out.exr", "config check s.toml",
                                      "curve s.toml", "config explain s.toml"}) {
      expect_refused("mtf " + command, {"s.toml:22:1: error: detector.quantum_efficiency: ", part});
      EXPECT_FALSE(says(scratch.run("mtf " + command).err, "electron_nodes"));
    }
  };
  sensor("", "quantum_efficiency = 0.75", "quantum_efficiency = 0.0");
  all_say("no light makes electrons");
  sensor("", "quantum_efficiency = 0.75", "quantum_efficiency = \"qe.csv\"");
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n2,0\n6,0\n");
  all_say("qe.csv is 0");
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n3000,0.5\n5000,0.5\n");
  all_say("qe.csv: covers 3000 um to 5000 um");
  std::string text = kSensor;
  text = replaced(text, "transmission = 0.85", "transmission = \"tau.csv\"");
  text = replaced(text, "quantum_efficiency = 0.75", "quantum_efficiency = \"qe.csv\"");
  write_file(scratch / "s.toml", text);
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n2,0.5\n3.5,0.5\n3.501,0\n6,0\n");
  write_file(scratch / "tau.csv", "wavelength_um,transmission\n2,0\n4,0\n4.001,0.9\n6,0.9\n");
  all_say("multiply to 0");
}

TEST_F(BudgetCommand, ABudgetSaysWhatFramesDoOtherwise) {
  sensor("[noise]\nseed = 1\n");
  EXPECT_EQ(Json::parse(scratch.run("mtf budget s.toml --format json").out)["notes"], Json::array());
  const double netd = budget()["netd"]["value"];
  sensor("[noise]\nseed = 1\nshot = false\n");
  const Result r = scratch.run("mtf budget s.toml --format json");
  expect_says(r.err, {"[noise] shot = false", "shot noise out"});
  EXPECT_EQ(Json::parse(r.out)["notes"].size(), 1U);
  EXPECT_EQ(budget()["netd"]["value"], netd);  // photons arrive as they do
}

// The spread of a map is its standard deviation, as that of random factors is.
TEST_F(BudgetCommand, MapsCountInTheBudget) {
  Image gain(32, 24), offset(32, 24);
  for (std::int64_t i = 0; i < gain.size(); ++i) {
    gain.data()[i] = i % 2 == 0 ? 0.75F : 1.25F;
    offset.data()[i] = i % 2 == 0 ? -64.0F : 64.0F;
  }
  mtf::io::write_exr((scratch / "gain.exr").string(), {{"Y", gain.view()}}, {});
  mtf::io::write_exr((scratch / "offset.exr").string(), {{"Y", offset.view()}}, {});
  sensor("[nonuniformity]\nprnu = 0.25\ndsnu = \"64 e-\"\n");
  const Json random = budget();
  sensor("[nonuniformity]\nresponsivity = \"gain.exr\"\noffset = \"offset.exr\"\n");
  const Json maps = budget();
  for (const char* name : {"prnu", "dsnu", "spatial", "spatial_netd"}) EXPECT_EQ(maps[name], random[name]) << name;
  EXPECT_EQ(Json::parse(scratch.run("mtf budget s.toml --format json").out)["notes"], Json::array());
  for (float& value : std::span(gain.data(), static_cast<std::size_t>(gain.size()))) value *= 0.5F;
  mtf::io::write_exr((scratch / "gain.exr").string(), {{"Y", gain.view()}}, {});
  const std::string err = scratch.run("mtf budget s.toml").err;
  expect_says(err, {"mean of nonuniformity.responsivity", "0.5", "standard deviation", "0.125", "not divided"});
  EXPECT_NEAR(budget()["prnu"]["value"].get<double>(), 0.5 * random["prnu"]["value"].get<double>(), 1.0);
}

// The mean of 768 independent pixels scatters by 1/28 of their standard deviation.
TEST_F(BudgetCommand, AMeanWithinItsSamplingErrorIsNoNews) {
  const auto notes_of = [&](float shift) {
    Image gain(32, 24), offset(32, 24);
    for (std::int64_t i = 0; i < gain.size(); ++i) {
      const float sign = i % 2 == 0 ? -1.0F : 1.0F;
      gain.data()[i] = 1.0F + 0.05F * (sign + shift);
      offset.data()[i] = 64.0F * (sign + shift);
    }
    mtf::io::write_exr((scratch / "gain.exr").string(), {{"Y", gain.view()}}, {});
    mtf::io::write_exr((scratch / "offset.exr").string(), {{"Y", offset.view()}}, {});
    return Json::parse(scratch.run("mtf budget s.toml --format json").out)["notes"].size();
  };
  sensor("[nonuniformity]\nresponsivity = \"gain.exr\"\noffset = \"offset.exr\"\n");
  EXPECT_EQ(notes_of(0.07F), 0U) << "two standard deviations of the mean";
  EXPECT_EQ(notes_of(-0.13F), 0U);
  EXPECT_EQ(notes_of(0.2F), 2U) << "more than five";
}

// Figures behind the air say so where they begin; without the path they are those of a file that has none.
TEST_F(BudgetCommand, SensitivityBehindTheAirSaysSoAndTheBareSensorIsAnOptionAway) {
  sensor("");
  const std::string csv = scratch.run("mtf budget s.toml --format csv").out,
                    table = scratch.run("mtf budget s.toml").out,
                    curves = scratch.run("mtf budget s.toml --curves --format csv").out;
  EXPECT_FALSE(says(table, "behind the air"));
  const std::string air = "[atmosphere]\nmodel = \"us_standard_1976\"\nrange = \"5 km\"\n";
  const std::string by_pixel = "depth_channel = \"Z\"\n";
  for (const auto& [more, scene, name] :
       {std::tuple{std::string("[path]\ntransmission = 0.5\n"), "", "[path]"}, std::tuple{air, "", "[atmosphere]"},
        std::tuple{replaced(air, "range = \"5 km\"\n", ""), by_pixel.c_str(), ""}}) {
    sensor(more, "sample =", std::string(scene) + "sample =");
    const std::string behind = scratch.run("mtf budget s.toml").out;
    if (*name != '\0')
      expect_says(behind, {"behind the air of " + std::string(name) + "; --without-path"});
    else
      EXPECT_FALSE(says(behind, "behind the air"));
    EXPECT_EQ(scratch.run("mtf budget s.toml --without-path").out, table) << more;
    EXPECT_EQ(scratch.run("mtf budget s.toml --without-path --format csv").out, csv) << more;
    EXPECT_EQ(scratch.run("mtf budget s.toml --without-path --curves --format csv").out, curves) << more;
  }
}

// 16.1 x 1000 is 16100.000000000002 in doubles.
TEST_F(BudgetCommand, TheAirIsToldWithoutTheRoundingOfUnits) {
  sensor("[atmosphere]\nmodel = \"us_standard_1976\"\nrange = \"16.1 km\"\n");
  expect_says(scratch.run("mtf budget s.toml").out, {"range 16100 m;"});
}

// Light that no detector sees: the message is at the key that takes it away.
TEST_F(BudgetCommand, LightWithoutElectronsIsRefusedAtItsKey) {
  sensor("[path]\ntransmission = 0.0\n");
  expect_refused("mtf curve s.toml", {"s.toml:26:1: error: path.transmission: ", "multiply to 0 everywhere"});
  for (const char* cold : {"0 K", "1e-310 K"}) {
    sensor("", "sample =", std::string("source_temperature = \"") + cold + "\"\nsample =");
    expect_refused("mtf curve s.toml", {"s.toml:8:1: error: scene.source_temperature: a source of ", cold});
  }
}

// What radiometry refuses is told at the line of the key it is about.
TEST_F(BudgetCommand, RefusalsOfTheChainHaveTheirLine) {
  sensor("[blooming]\ndirection = \"columns\"\n", "full_well = \"10 Me-\"\n", "");
  for (const char* command :
       {"mtf budget s.toml", "mtf simulate s.toml t300.exr -o out.exr", "mtf config check s.toml"})
    expect_refused(command, {"s.toml:24:2: error: [blooming]: needs detector.full_well"});
  sensor("", "integration_time = \"10 ms\"\n", "");
  expect_refused("mtf budget s.toml", {"s.toml:3:2: error: frame.integration_time: missing"});
  sensor("[nonuniformity]\nresponsivity = \"small.exr\"\n");
  write_flat(scratch / "small.exr", 1.0F);
  expect_refused("mtf simulate s.toml t300.exr -o out.exr",
                 {"s.toml:26:1: error: nonuniformity.responsivity:", "64x48", "32x24"});
  sensor("[nonuniformity]\nresponsivity = \"below.exr\"\n");
  write_flat(scratch / "below.exr", -0.5F);
  expect_refused("mtf config check s.toml", {"responsivity: ", "below.exr has -0.5 at"});
  sensor("[nonuniformity]\nresponsivity = \"none.exr\"\n");
  expect_refused("mtf budget s.toml", {"s.toml:26:1: error: nonuniformity.responsivity: cannot read"}, 1);
}

}  // namespace
}  // namespace apps_test
