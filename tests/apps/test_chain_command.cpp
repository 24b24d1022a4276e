// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"
#include "mtf/io/scene.h"
#include "tests/apps/chain_sensor.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

class ChainCommand : public ChainSensor {};

// The two examples that the literature notes give to three or four digits.
TEST_F(ChainCommand, BudgetsOfTwoCamerasAreAsPublished) {
  sensor("");
  Json terms = budget();
  EXPECT_NEAR(terms["scene"]["value"].get<double>(), 6.89e6, 5e3);
  EXPECT_NEAR(terms["signal_per_k"]["value"].get<double>(), 2.47e5, 5e2);
  EXPECT_NEAR(terms["shot_netd"]["value"].get<double>(), 10.6, 0.05);
  std::string text = kSensor;
  for (const auto& [from, to] : {std::pair{"\"10 ms\"", "\"200 us\""},
                                 {"\"10 Me-\"", "\"30 Me-\""},
                                 {"f_number = 2.5", "f_number = 2.0"},
                                 {"[\"3 um\", \"5 um\"]", "[\"8 um\", \"12 um\"]"},
                                 {"\"15 um\"", "\"24 um\""},
                                 {"width = \"14.25 um\"", "width = \"21.6 um\"\nheight = \"24 um\""},
                                 {"quantum_efficiency = 0.75", "quantum_efficiency = 0.65"}})
    text.replace(text.find(from), std::string(from).size(), to);
  write_file(scratch / "s.toml", text);
  terms = budget();
  EXPECT_NEAR(terms["scene"]["value"].get<double>(), 2.05e7, 5e4);
  EXPECT_NEAR(terms["signal_per_k"]["value"].get<double>(), 3.31e5, 5e2);
  EXPECT_NEAR(terms["shot_netd"]["value"].get<double>(), 13.7, 0.05);
}

TEST_F(ChainCommand, AFlatSceneComesOutAsTheBudgetSays) {
  sensor("");
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o out.exr").status, 0);
  const double expected = budget()["total"]["value"];
  const Image image = read(scratch / "out.exr");
  ASSERT_EQ(image.width(), 32);
  for (std::int64_t i = 0; i < image.size(); ++i)
    EXPECT_NEAR(static_cast<double>(image.data()[i]) / expected, 1.0, 1e-6);
  EXPECT_EQ(mtf::io::read_image((scratch / "out.exr").string(), {}).info.attributes.at("mtf:units"), "e-");
}

// The default is a tenth of a count. A hot pixel raises what float32 samples can keep above that; there is no warning
// while the error stays below that of the converter's rounding, 0.29 counts rms, whether of one image, in tiles or of a
// sequence.
TEST_F(ChainCommand, TheDefaultToleranceGivesWayWithoutAWarningBelowTheRounding) {
  sensor("[adc]\nbits = 14\n");
  const auto said = [&](float kelvin, const std::string& command) {
    Image image(64, 48);
    for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = i % 64 < 32 ? 300.0F : 302.0F;
    image.at(20, 20) = kelvin;
    mtf::io::Metadata metadata;
    metadata.text["mtf:quantity"] = "temperature";
    mtf::io::write_exr((scratch / "hot.0001.exr").string(), {{"Y", image.view()}}, metadata);
    const Result result = scratch.run("mtf simulate s.toml " + command);
    EXPECT_EQ(result.status, 0) << result.err;
    return result.err;
  };
  for (const std::string command : {"hot.0001.exr -o out.exr", "hot.0001.exr -o tiles.exr --memory 200MiB",
                                    "hot.%04d.exr -o out.%04d.exr --frames 1:1"}) {
    EXPECT_FALSE(says(said(620.0F, command), "default tolerance")) << command;
    EXPECT_TRUE(says(said(1000.0F, command), "default tolerance")) << command;
  }
}

TEST_F(ChainCommand, PhotonsAndWattsOfTheSameSceneGiveTheSameElectrons) {
  sensor("", "quantity = \"temperature\"", "source_temperature = \"300 K\"");
  // Band radiances of a blackbody at 300 K, 3 to 5 um (theory notes 4.1).
  write_flat(scratch / "w.exr", 1.8659562082F, "radiance");
  write_flat(scratch / "p.exr", 4.1831091268e19F, "photon_radiance");
  for (const char* scene : {"t300", "w", "p"})
    ASSERT_EQ(scratch.run(std::string("mtf simulate s.toml ") + scene + ".exr -o out_" + scene + ".exr").status, 0);
  const double t = read(scratch / "out_t300.exr").at(3, 3);
  EXPECT_NEAR(read(scratch / "out_w.exr").at(3, 3) / t, 1.0, 3e-7);  // what a float scene can say
  EXPECT_NEAR(read(scratch / "out_p.exr").at(3, 3) / t, 1.0, 3e-7);
}

TEST_F(ChainCommand, EveryTapIsWrittenAndNoisyFramesRepeat) {
  sensor("[noise]\nseed = 5\n[adc]\nbits = 12\n[agc]\n");
  for (const char* tap : {"radiance", "irradiance", "electrons", "dn", "display"})
    EXPECT_EQ(scratch.run(std::string("mtf simulate s.toml t300.exr -o ") + tap + ".exr --tap " + tap).status, 0);
  const Image counts = read(scratch / "dn.exr");
  for (std::int64_t i = 0; i < counts.size(); ++i) EXPECT_EQ(counts.data()[i], std::floor(counts.data()[i]));
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o dn1.exr --tap dn --threads 1").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o dn2.exr --tap dn --threads 2").status, 0);
  EXPECT_EQ(read_file(scratch / "dn1.exr"), read_file(scratch / "dn2.exr"));
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o dn.png --tap dn").status, 0);
  const Image png = read(scratch / "dn.png");
  for (std::int64_t i = 0; i < counts.size(); ++i) EXPECT_EQ(png.data()[i], counts.data()[i]);
}

TEST_F(ChainCommand, AStageMayBeNamedByEitherOption) {
  sensor("[noise]\nseed = 5\n[adc]\nbits = 12\n");
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o stage.exr --stage electrons").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o tap.exr --tap electrons").status, 0);
  EXPECT_EQ(read_file(scratch / "stage.exr"), read_file(scratch / "tap.exr"));
  expect_says(scratch.run("mtf simulate --help").out, {"--stage"});
  expect_error(scratch.run("mtf simulate s.toml t300.exr -o none.exr --stage photons"), 2, {"--stage", "electrons"});
}

// A file that holds 0 to 255 in 16 bits is black in every viewer.
TEST_F(ChainCommand, DisplayLevelsAreFilesThatLookLikeTheDisplay) {
  Image ramp(64, 48);
  for (std::int64_t y = 0; y < 48; ++y)
    for (std::int64_t x = 0; x < 64; ++x) ramp.at(x, y) = 290.0F + 0.3F * static_cast<float>(x);
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = "temperature";
  mtf::io::write_exr((scratch / "ramp.exr").string(), {{"Y", ramp.view()}}, metadata);
  struct Case {
    const char* most;
    double largest, gain;
    int bits;
  };
  for (const Case& c : {Case{"", 255.0, 1.0, 8},
                        {"most_level = 100", 100.0, 100.0 / 255.0, 8},
                        {"most_level = 1023", 1023.0, 1023.0 / 65535.0, 16}}) {
    sensor(std::string("[adc]\nbits = 12\n[agc]\n") + c.most + "\n");
    ASSERT_EQ(scratch.run("mtf simulate s.toml ramp.exr -o levels.exr").status, 0);
    const Image levels = read(scratch / "levels.exr");
    for (const std::string name : {"out.png", "out.tif", "f.0001.png"}) {
      const bool sequence = name.starts_with("f.");
      if (sequence) write_file(scratch / "plan.csv", "frame,parameter,value\n1,detector.read_noise,500 e-\n");
      const Result r = scratch.run("mtf simulate s.toml ramp.exr " +
                                   (sequence ? "-o f.%04d.png --schedule plan.csv --frames 1:1" : "-o " + name) +
                                   " --report r.json");
      ASSERT_EQ(r.status, 0) << r.err;
      const mtf::io::ImageFile file = mtf::io::read_image((scratch / name).string(), {});
      EXPECT_EQ(file.info.storage, std::to_string(c.bits) + "-bit") << name;
      EXPECT_EQ(file.info.attributes.at("mtf:units"), "levels");
      EXPECT_DOUBLE_EQ(std::stod(file.info.attributes.at("gain")), c.gain);
      EXPECT_EQ(file.info.attributes.at("offset"), "0");
      float most = 0.0F;
      for (std::int64_t i = 0; i < levels.size(); ++i) {
        most = std::max(most, file.planes.front().data()[i]);
        EXPECT_NEAR(c.gain * file.planes.front().data()[i], levels.data()[i], 0.5 * c.gain + 1e-4) << i;
      }
      EXPECT_EQ(most, c.bits == 8 ? 255.0F : 65535.0F) << "the largest level is white";
      if (sequence) continue;
      const Json output = Json::parse(read_file(scratch / "r.json"))["integer_output"];
      EXPECT_EQ(output.at("bits"), c.bits);
      EXPECT_DOUBLE_EQ(output["gain"].get<double>(), c.gain);
      EXPECT_EQ(output["clamped"], 0);
      expect_says(r.err, {std::to_string(c.bits) + "-bit output"});
      expect_says(scratch.run("mtf info " + name).out, {std::to_string(c.bits) + "-bit"});
    }
  }
  // Counts in front of the display are whole numbers of 16 bits as before.
  ASSERT_EQ(scratch.run("mtf simulate s.toml ramp.exr -o dn.png --tap dn").status, 0);
  EXPECT_EQ(mtf::io::read_info((scratch / "dn.png").string()).storage, "16-bit");
}

TEST_F(ChainCommand, ALagThatIsCountedTwiceIsSaid) {
  const std::string bolometer = "[[presample]]\nkind = \"bolometer\"\n";
  const auto said = [&](const std::string& more) {
    sensor(more);
    const Result r = scratch.run("mtf config check s.toml");
    EXPECT_EQ(r.status, 0) << r.err;
    const Json json = Json::parse(scratch.run("mtf config check s.toml --format json").out);
    std::size_t found = 0;
    for (const Json& d : json["diagnostics"])
      if (d["path"] == "lag.time_constant") {
        EXPECT_EQ(d["severity"], "warning");
        ++found;
      }
    EXPECT_EQ(found, says(r.out, "both are the thermal") ? 1U : 0U) << r.out;
    return r.out;
  };
  const std::string moving = "time_constant = \"10 ms\"\nvelocity = \"0.5 mm/s\"\n";
  const std::string same = said(bolometer + moving + "[lag]\ntime_constant = \"0.01 s\"\n");
  expect_says(same, {"10 ms", "the same", "\"bolometer\" of [[presample]]"});
  expect_says(scratch.run("mtf simulate s.toml t300.exr -o out.exr").err, {"counts it twice"});
  const std::string two = said(bolometer + moving + "[lag]\ntime_constant = \"8 ms\"\n");
  expect_says(two, {"8 ms", "10 ms in \"bolometer\"", "one time constant"});
  for (const std::string& once :
       {bolometer + moving, std::string("[lag]\ntime_constant = \"8 ms\"\n"),
        bolometer + "time_constant = \"10 ms\"\nrate = \"0 mrad/s\"\n[lag]\ntime_constant = \"10 ms\"\n"})
    EXPECT_FALSE(says(said(once), "thermal lag")) << once;
}

TEST_F(ChainCommand, ASequenceHasNewNoiseAndAScheduleChangesTheDetector) {
  sensor("[noise]\nseed = 5\n[nonuniformity]\nprnu = 0.01\n");
  write_file(scratch / "plan.csv", "frame,parameter,value\n3,detector.read_noise,50 ke-\n");
  const Result r = scratch.run("mtf simulate s.toml t300.exr -o f.%02d.exr --schedule plan.csv --frames 1:4");
  ASSERT_EQ(r.status, 0) << r.err;
  const auto scatter = [&](const char* a, const char* b) {
    const Image one = read(scratch / a), two = read(scratch / b);
    double sum = 0.0;
    for (std::int64_t i = 0; i < one.size(); ++i) sum += std::pow(double{one.data()[i]} - double{two.data()[i]}, 2);
    return std::sqrt(0.5 * sum / static_cast<double>(one.size()));
  };
  const double shot = std::sqrt(budget()["total"]["value"].get<double>());
  EXPECT_NEAR(scatter("f.01.exr", "f.02.exr"), std::hypot(shot, 500.0), 0.1 * shot);  // the pattern cancels
  EXPECT_NEAR(scatter("f.03.exr", "f.04.exr"), std::hypot(shot, 5e4), 5e3);
}

TEST_F(ChainCommand, ExplainShowsTheChainAndTheReportItsTimes) {
  sensor("[noise]\n");
  const Result r = scratch.run("mtf config explain s.toml");
  expect_says(r.out, {"chain, in this order", "shot noise", "left out", "no [adc]"});
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o out.exr --report r.json").status, 0);
  const Json chain = Json::parse(read_file(scratch / "r.json"))["chain"];
  EXPECT_EQ(chain["tap"], "electrons");
  EXPECT_TRUE(chain["timing_ms"].contains("shot"));
  EXPECT_FALSE(chain["timing_ms"].contains("adc"));
}

TEST_F(ChainCommand, CurvesOfTheWavelengthTakeTheirPlace) {
  // Half of the band at twice the plain value is the same for light that is even in photons.
  sensor("", "quantity = \"temperature\"", "quantity = \"photon_radiance\"");
  write_flat(scratch / "p.exr", 1e19F, "photon_radiance");
  ASSERT_EQ(scratch.run("mtf simulate s.toml p.exr -o plain.exr").status, 0);
  sensor("", "quantum_efficiency = 0.75", "quantum_efficiency = \"qe.csv\"");
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n3,0.5\n5,1.0\n");
  ASSERT_EQ(scratch.run("mtf simulate s.toml p.exr -o curve.exr").status, 0);
  EXPECT_NEAR(read(scratch / "curve.exr").at(3, 3) / read(scratch / "plain.exr").at(3, 3), 1.0, 1e-6);
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n4,0.75\n");  // one sample: a constant
  ASSERT_EQ(scratch.run("mtf simulate s.toml p.exr -o single.exr").status, 0);
  EXPECT_NEAR(read(scratch / "single.exr").at(3, 3) / read(scratch / "plain.exr").at(3, 3), 1.0, 1e-6);
}

// Beyond its samples a curve counts as 0: the budget is that of the band as far as the curve goes, and every command
// that reads the sensor says so, once.
TEST_F(ChainCommand, ACurveThatStopsInsideTheBandIsTold) {
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n3,0.75\n4.2,0.75\n");
  write_file(scratch / "study.toml",
             "schema = 1\nsensor = \"s.toml\"\n[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"12 um\", \"15 um\"]\n"
             "[metrics]\nlist = [\"mtf_nyquist\"]\n");
  const auto times_told = [&](const std::string& command) {
    const Result r = scratch.run(command);
    EXPECT_EQ(r.status, 0) << r.err;
    const std::string all = r.err + r.out, sentence = "4.2 um to 5 um of the band counts as 0";
    int times = 0;
    for (std::size_t at = all.find(sentence); at != std::string::npos; at = all.find(sentence, at + 1)) ++times;
    EXPECT_EQ(says(all, "detector.quantum_efficiency"), times > 0) << all;
    return times;
  };
  const std::vector<std::string> commands{"mtf budget s.toml", "mtf config check s.toml",
                                          "mtf simulate s.toml t300.exr -o image.exr",
                                          "mtf sweep study.toml -o table --force"};
  sensor("", "quantum_efficiency = 0.75", "quantum_efficiency = \"qe.csv\"");
  for (const std::string& command : commands) EXPECT_EQ(times_told(command), 1) << command;
  const double stopped = budget()["scene"]["value"].get<double>();
  sensor("", "[\"3 um\", \"5 um\"]", "[\"3 um\", \"4.2 um\"]");
  EXPECT_NEAR(budget()["scene"]["value"].get<double>() / stopped, 1.0, 1e-12);
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n3,0.75\n4.2,0.75\n4.21,0.005\n");
  sensor("", "quantum_efficiency = 0.75", "quantum_efficiency = \"qe.csv\"");
  for (const std::string& command : commands) EXPECT_EQ(times_told(command), 0) << command;
}

// A camera that sees its warm stop, with its quantum efficiency as a number and as the same curve, wider than the band.
TEST_F(ChainCommand, AFlatCurveGivesTheBudgetOfItsNumber) {
  const auto both = [&](const std::string& optics, const std::string& detector) {
    sensor("[nonuniformity]\nprnu = 0.01\n[correction]\n", "f_number = 2.5", "f_number = 2.5\n" + optics);
    std::string text = read_file(scratch / "s.toml");
    text = replaced(text, "quantum_efficiency = 0.75", "quantum_efficiency = " + detector);
    write_file(scratch / "s.toml", text);
  };
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n1,0.75\n5.5,0.75\n");
  both("stop_temperature = \"200 K\"", "0.75");
  const Json number = budget();
  both("stop_temperature = \"200 K\"", "\"qe.csv\"");
  const Json curve = budget();
  ASSERT_EQ(number.size(), curve.size());
  EXPECT_GT(number["stop"]["value"].get<double>(), 1e4);
  for (const auto& [name, term] : number.items()) {
    const double value = term["value"].get<double>();
    EXPECT_NEAR(curve[name]["value"].get<double>(), value, 1e-13 * value) << name;
  }
  both("stop_temperature = \"200 K\"\nstop_band = \"response\"", "\"qe.csv\"");
  EXPECT_GT(budget()["stop"]["value"].get<double>(), 1.5 * number["stop"]["value"].get<double>());
  const std::string told = scratch.run("mtf config explain s.toml").out;
  expect_says(told, {"1 um", "5.5 um"});
  both("stop_temperature = \"200 K\"\nstop_band = \"response\"", "0.75");
  expect_refused("mtf budget s.toml", {"optics.stop_band", "CSV"});
  both("cone = \"sine\"", "0.75");
  EXPECT_NEAR(budget()["scene"]["value"].get<double>() / number["scene"]["value"].get<double>(), 26.0 / 25.0, 1e-14);
  sensor("", "f_number = 2.5", "f_number = 0.45\ncone = \"sine\"");
  for (const char* command :
       {"mtf budget s.toml", "mtf config check s.toml", "mtf simulate s.toml t300.exr -o out.exr"})
    expect_refused(command, {"optics.cone", "0.45", "0.5 or above"});
}

TEST_F(ChainCommand, ABudgetSaysWhySpatialNoiseHasNoNumber) {
  sensor("[correction]\nlow = 0.0\n[nonuniformity]\nprnu = 0.01\n", "read_noise",
         "dark_current = \"1 Me-/s\"\nread_noise");
  const Result r = scratch.run("mtf budget s.toml --format json");
  EXPECT_EQ(r.status, 0);
  expect_says(r.err, {"flat frame at 0", "full well"});
  const Json terms = Json::parse(r.out)["terms"];
  for (const char* name : {"prnu", "spatial", "spatial_netd"}) EXPECT_TRUE(terms[name]["value"].is_null()) << name;
  EXPECT_TRUE(terms["netd"]["value"].is_number());
}

TEST_F(ChainCommand, SpectralScenesAndRangesOfPixelsAgreeWithPlainNumbers) {
  const auto electrons = [&](const std::string& scene, const std::string& name) {
    const Result r = scratch.run("mtf simulate s.toml " + scene + " -o " + name + ".exr");
    EXPECT_EQ(r.status, 0) << r.err;
    return static_cast<double>(read(scratch / (name + ".exr")).at(3, 3));
  };
  // 1 W m-2 sr-1 um-1 from 3 to 5 um is the integral of lambda / (h c), 8 um^2 / 1.98644586e-19 J um, in photons.
  sensor("", "quantity = \"temperature\"", "negative = \"clamp\"");
  Image plane(64, 48), range(64, 48);
  std::fill_n(plane.data(), plane.size(), 1e-3F);  // per nm
  mtf::io::Metadata units;
  units.text["emissiveUnits"] = "W.m^-2.sr^-1";
  mtf::io::write_exr((scratch / "spectrum.exr").string(),
                     {{"S0.3000,000000nm", plane.view()}, {"S0.5000,000000nm", plane.view()}}, units);
  write_flat(scratch / "p.exr", static_cast<float>(8.0 / 1.98644586e-19), "photon_radiance");
  EXPECT_NEAR(electrons("spectrum.exr", "a") / electrons("p.exr", "b"), 1.0, 1e-6);

  sensor("[path]\ntransmission = 0.8\nradiance = 0.01\n");
  const double plain = electrons("t300.exr", "c");
  sensor("[path]\ntable = \"path.csv\"\n", "[scene]", "[scene]\ndepth_channel = \"Z\"");
  write_file(scratch / "path.csv",
             "range_m,wavelength_um,transmission,radiance_w_m2_sr_um\n1000,3,0.8,0.01\n1000,5,0.8,0.01\n");
  std::fill_n(plane.data(), plane.size(), 300.0F);
  std::fill_n(range.data(), range.size(), 1000.0F);
  mtf::io::write_exr((scratch / "depth.exr").string(), {{"T", plane.view()}, {"Z", range.view()}}, {});
  EXPECT_NEAR(electrons("depth.exr --channel T", "d") / plain, 1.0, 1e-6);
  range.at(5, 7) = 0.0F;
  mtf::io::write_exr((scratch / "depth.exr").string(), {{"T", plane.view()}, {"Z", range.view()}}, {});
  expect_refused("mtf simulate s.toml depth.exr --channel T -o out.exr", {"column 5, row 7"});

  sensor("[microscan]\nsteps = 2\n");
  electrons("t300.exr", "fine");
  EXPECT_EQ(read(scratch / "fine.exr").width(), 64);
  EXPECT_EQ(mtf::io::stated_pitch_um(mtf::io::read_info((scratch / "fine.exr").string())), (std::array{7.5, 7.5}));
}

TEST_F(ChainCommand, TheAirOfARadianceIsTakenOnce) {
  sensor("[path]\ntransmission = 0.5\n");
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o once.exr --stage radiance --roi 1,2,30,20").status, 0);
  EXPECT_TRUE(
      mtf::io::read_info((scratch / "once.exr").string()).attributes.at("mtf:region").starts_with("1 2 30 20 "));
  expect_refused("mtf simulate s.toml once.exr -o out.exr", {"once.exr", "the air is in it already", "[path]"});
}

// What lies beyond the border has filled well and converter as the pixels have.
TEST_F(ChainCommand, AConstantBorderIsHeldAtTheEndsOfTheRange) {
  for (const std::string more :
       {"[blooming]\n[adc]\nbits = 14\n", "[adc]\nbits = 14\nelectrons_per_count = \"500 e-\"\n"}) {
    sensor(more + "[[postsample]]\nkind = \"fir\"\ntaps = [[0.25, 0.5, 0.25]]\n", "quantity = \"temperature\"",
           "quantity = \"temperature\"\nborder = \"constant\"\nborder_value = 330.0");
    for (const char* stage : {"dn", "display"})
      ASSERT_EQ(scratch.run(std::string("mtf simulate s.toml t300.exr -o ") + stage + ".exr --stage " + stage).status,
                0);
    const Image counts = read(scratch / "dn.exr"), filtered = read(scratch / "display.exr");
    EXPECT_LT(counts.at(20, 12), 15000.0F);
    EXPECT_NEAR(filtered.at(0, 12), 0.25F * 16383.0F + 0.5F * counts.at(0, 12) + 0.25F * counts.at(1, 12), 0.5F)
        << more;
  }
}

TEST_F(ChainCommand, WellsThatSpilledChargeFillsAreCounted) {
  Image hot(64, 48);
  std::fill_n(hot.data(), hot.size(), 280.0F);
  hot.at(20, 20) = hot.at(21, 20) = hot.at(20, 21) = hot.at(21, 21) = 700.0F;
  mtf::io::write_exr((scratch / "hot.exr").string(), {{"Y", hot.view()}}, {});
  sensor("[blooming]\n");
  ASSERT_EQ(scratch.run("mtf simulate s.toml hot.exr -o hot_e.exr --report r.json").status, 0);
  const Image electrons = read(scratch / "hot_e.exr");
  const auto full = std::count(electrons.data(), electrons.data() + electrons.size(), 1e7F);
  EXPECT_GT(full, 20);  // the column of the hot pixel at least
  EXPECT_EQ(Json::parse(read_file(scratch / "r.json"))["chain"]["saturation"]["at_full_well"], full);
}

TEST_F(ChainCommand, BadPixelsAreNotFollowedWhereLightMoves) {
  Image bad(64, 48);
  std::fill_n(bad.data(), bad.size(), 300.0F);
  bad.at(5, 7) = std::nanf("");
  mtf::io::write_exr((scratch / "bad.exr").string(), {{"Y", bad.view()}}, {});
  for (const std::string table : {"[distortion]\nk1 = -0.02\n", "[ghost]\nfraction = 0.1\n"}) {
    sensor(table);
    expect_refused("mtf simulate s.toml bad.exr -o out.exr --nan propagate", {table.substr(0, 6), "--nan fill"});
  }
}

TEST_F(ChainCommand, WhatThePromisedErrorLeavesOutIsSaid) {
  sensor("[distortion]\nk1 = -0.02\n[adc]\nbits = 32\n");
  // Keys' kernel halfway between samples at a quarter cycle a sample: (9/8 + 1/8) cos(pi/4).
  expect_says(
      scratch.run("mtf simulate s.toml t300.exr -o a.exr").err,
      {"warning: [distortion]", "0.884, which is not in the promised error", "warning: [adc] bits = 32", "2^24"});
  sensor("[vignetting]\n", "[scene]", "format = [640, 512]\n[scene]");
  expect_says(scratch.run("mtf simulate s.toml t300.exr -o a.exr").err,
              {"32 x 24 pixels from the upper left of 640x512"});
  Image plane(64, 48);
  std::fill_n(plane.data(), plane.size(), 1e-3F);
  mtf::io::Metadata units;
  units.text["emissiveUnits"] = "W.m^-2.sr^-1";
  mtf::io::write_exr((scratch / "spectrum.exr").string(),
                     {{"S0.3500,000000nm", plane.view()}, {"S0.4500,000000nm", plane.view()}}, units);
  // At 33.3 cy/mm and F/2.5 diffraction passes 0.634 at 3.5 um and 0.534 at 4.5 um, 0.584 on the mean from 3 to 5 um,
  // the footprint 2/pi.
  sensor("", "quantity = \"temperature\"", "quantity = \"spectral_radiance\"");
  expect_says(scratch.run("mtf simulate s.toml spectrum.exr -o b.exr").err,
              {"3.5 um to 4.5 um", "counts as 0", "at 3.5 um and 4.5 um", "by up to 0.032"});
  std::string linear = kSensor.substr(0, kSensor.find("[detector]"));
  for (const std::string_view line : {"integration_time = \"10 ms\"\n", "transmission = 0.85\n"})
    linear.erase(linear.find(line), line.size());
  write_file(scratch / "linear.toml", linear);
  for (const char* more : {"", " --roi 0,0,8,8"})
    expect_says(scratch.run(std::string("mtf simulate linear.toml spectrum.exr -o c.exr") + more).err,
                {"by up to 0.032"});
}

// A band of 3 to 5 um whose light the sensor file calls temperature is averaged for a body of 300 K, most of which is
// beyond 4 um; of a scene that states radiance, for an even spectrum.
TEST_F(ChainCommand, ASceneOfAnotherLightThanTheSensorFileStatesIsTold) {
  sensor("");
  write_flat(scratch / "photons.exr", 1e19F, "photon_radiance");
  const Result told = scratch.run("mtf simulate s.toml photons.exr -o a.exr");
  EXPECT_EQ(told.status, 0) << told.err;
  expect_says(told.err, {"for light of a blackbody of 300 K", "of an even spectrum", "\"photon_radiance\" there"});
  sensor("", "quantity = \"temperature\"", "quantity = \"photon_radiance\"");
  EXPECT_FALSE(says(scratch.run("mtf simulate s.toml photons.exr -o b.exr --force").err, "of an even spectrum"));
}

// Of a normal responsivity with 3 % rms, 4.0 % of the pixels are full at 0.95 of the well, in half of the flat frames;
// 50 % differ by more than 2 %.
TEST_F(ChainCommand, WhatSpoilsACorrectionIsSaid) {
  const auto corrected = [&](const std::string& more) {
    sensor("[nonuniformity]\nprnu = 0.03\n[noise]\n[adc]\nbits = 14\n[correction]\nframes = 4\n" + more);
    const Result r = scratch.run("mtf simulate s.toml t300.exr -o out.exr --report r.json");
    EXPECT_EQ(r.status, 0) << r.err;
    return std::pair{r.err, Json::parse(read_file(scratch / "r.json"))["chain"]["correction"]};
  };
  EXPECT_FALSE(says(corrected("").first, "[correction]"));
  const auto [full, flats] = corrected("high = 0.95\n");
  expect_says(full, {"warning: [correction]", "flat frames are saturated", "at the full well"});
  EXPECT_NEAR(flats["flat_frames"]["at_full_well"].get<double>() / flats["flat_frames"]["pixels"].get<double>(), 0.0199,
              0.0105);  // 3 standard deviations of 768 pixels
  const auto [bad, many] = corrected("limit = 0.02\n");
  expect_says(bad, {"warning: [correction]", "of 768 pixels count as bad", "correction.limit"});
  EXPECT_NEAR(many["bad_pixels"].get<double>() / 768.0, 0.505, 0.054);
}

TEST_F(ChainCommand, BadInputSaysWhereAndWhat) {
  sensor("", "\"10 Me-\"", "\"10 mm\"");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr", {"detector.full_well", "does not fit"});
  sensor("", "quantum_efficiency = 0.75", "quantum_efficiency = \"qe.csv\"");
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n8,0.5\n12,0.6\n");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr", {"8 um to 12 um", "3 um to 5 um"});
  write_file(scratch / "qe.csv", "wavelength_um,quantum_efficiency\n3,0.5\n5,1.6\n");
  expect_refused("mtf config check s.toml", {"detector.quantum_efficiency", "1.6"});
  sensor("[defects]\ndead_fraction = 0.7\nhot_fraction = 0.6\nhot = \"10 e-\"\n");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr", {"dead"});
  sensor("");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr --tap dn", {"dn", "electrons"});
  sensor("[agc]\n");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr --memory 1GiB", {"--memory", "agc", "--stage electrons"});
  sensor("");
  write_flat(scratch / "cold.exr", -3.0F);
  expect_refused("mtf simulate s.toml cold.exr -o out.exr", {"3072"});
  sensor("", "[scene]", "[scene]\ndepth_channel = \"Z\"");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr", {"depth_channel", "path.table"});
  sensor("[path]\ntable = \"path.csv\"\n", "[scene]", "[scene]\ndepth_channel = \"Z\"");
  write_file(scratch / "path.csv",
             "range_m,wavelength_um,transmission,radiance_w_m2_sr_um\n1000,3,0.8,0.01\n1000,5,0.8,0.01\n");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr", {"depth_channel", "Z"});
  sensor("", "\n[detector]", "\n[adc]\nbits = 8\n[detectors]");
  expect_refused("mtf config check s.toml", {"detectors"});
}

// Frames of one image have the noise of their numbers, as the frames of a sequence have.
TEST_F(ChainCommand, SeveralFramesOfOneImage) {
  sensor("[noise]\nseed = 3\n");
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o n.%d.exr --frames 3").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o alone.exr").status, 0);
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o alone.%d.exr --frames 2:2").status, 0);
  const auto same = [&](const char* a, const char* b) {
    const Image one = read(scratch / a), other = read(scratch / b);
    return std::equal(one.data(), one.data() + one.size(), other.data());
  };
  EXPECT_TRUE(same("n.0.exr", "alone.exr"));
  EXPECT_TRUE(same("n.2.exr", "alone.2.exr"));
  EXPECT_FALSE(same("n.1.exr", "n.2.exr"));
  EXPECT_FALSE(fs::exists(scratch / "n.3.exr"));
}

}  // namespace
}  // namespace apps_test
