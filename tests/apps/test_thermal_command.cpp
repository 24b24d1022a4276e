// SPDX-License-Identifier: Apache-2.0

// An uncooled camera through the commands: stages and units, budget, sequences, what is refused and warned about.

#include <cmath>

#include "tests/apps/thermal_sensor.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

class ThermalCommand : public ThermalSensor {};

TEST_F(ThermalCommand, StagesHaveTheirUnitsAndTheValuesOfTheBudget) {
  camera(kConverter);
  const Json terms = budget();
  for (const auto& [stage, unit, quantity, value] :
       {std::tuple{"watts", "W", "power", terms["absorbed"]["value"].get<double>()},
        std::tuple{"volts", "V", "voltage", terms["total"]["value"].get<double>()},
        std::tuple{"dn", "counts", "counts", std::round(4000.0 + terms["total"]["value"].get<double>() / 0.5e-6)}}) {
    const Result r = scratch.run(std::string("mtf simulate s.toml t300.exr -o out.exr --stage ") + stage);
    ASSERT_EQ(r.status, 0) << r.err;
    const mtf::io::ImageFile image = mtf::io::read_image((scratch / "out.exr").string(), {});
    EXPECT_EQ(image.info.attributes.at("mtf:units"), unit);
    EXPECT_EQ(image.info.attributes.at("mtf:quantity"), quantity);
    EXPECT_NEAR(static_cast<double>(image.planes.front().at(30, 20)) / value, 1.0, 1e-4) << stage;
    fs::remove(scratch / "out.exr");
  }
  expect_refused("mtf simulate s.toml t300.exr -o out.exr --stage electrons", {"stage electrons", "watts or volts"});
  sensor("");
  expect_refused("mtf simulate s.toml t300.exr -o out.exr --stage volts", {"stage volts", "take electrons"});
}

TEST_F(ThermalCommand, TheBudgetNamesItsTerms) {
  camera("");
  Json terms = budget();
  EXPECT_NEAR(terms["netd"]["value"].get<double>(), 50.0 / 0.9, 1e-9);  // the optics let 0.9 through
  EXPECT_EQ(terms["detector"]["unit"], "V");
  EXPECT_EQ(terms["dstar"]["reason"], "no detector.noise_bandwidth");
  expect_says(terms["detector"]["doc"].get<std::string>(), {"by its NETD"});
  EXPECT_FALSE(terms.contains("scene_shot"));
  const std::string spec = kUncooled.substr(kUncooled.find("responsivity"));
  camera("", spec,
         "shutter_temperature = \"295 K\"\nnoise_bandwidth = \"8 kHz\"\nheat_capacity = 3e-10\nconductance = 3e-8\n"
         "temperature = \"300 K\"\nresistance = 1e5\ntcr = -0.02\nbias = \"2 V\"\ncorner = \"1 kHz\"\n"
         "lowest_frequency = \"0.01 Hz\"\n");
  terms = budget();
  for (const char* name : {"thermal_fluctuation", "johnson", "flicker", "readout", "largest", "nep", "dstar", "netd"})
    EXPECT_TRUE(terms[name]["value"].is_number()) << name;
  expect_says(terms["largest"]["doc"].get<std::string>(), {"is flicker"});
}

// 4 N^2 + 1 for a cold stop, 4 N^2 for an aplanat: 6.5 % of the NETD between f/1 and f/1.2.
TEST_F(ThermalCommand, AnNetdAtAnotherFNumberSaysByWhichCone) {
  for (const auto& [cone, law, factor] :
       {std::tuple{"tangent", "4 N^2 + 1", 6.76 / 5.0}, std::tuple{"sine", "4 N^2", 1.44}}) {
    camera("");
    const double here = budget()["netd"]["value"].get<double>();
    std::string text = read_file(scratch / "s.toml");
    text = replaced(text, "f_number = 1.0", "f_number = 1.2\ncone = \"" + std::string(cone) + "\"");
    write_file(scratch / "s.toml", text);
    const Json terms = budget();
    expect_says(
        terms["detector"]["doc"].get<std::string>(),
        {"by its NETD", "f/1,", "f/1.2,", "to " + std::string(law) + " as", "cone = \"" + std::string(cone) + "\""});
    EXPECT_NEAR(terms["netd"]["value"].get<double>() / here, factor, 1e-9);
  }
}

TEST_F(ThermalCommand, ASequenceShorterThanTheTimeConstantIsWarnedAbout) {
  camera("[lag]\ntime_constant = \"50 ms\"\n");
  for (int n = 0; n < 4; ++n) write_flat(scratch / ("s." + std::to_string(n) + ".exr"), 300.0F);
  const std::string run = "mtf simulate s.toml s.%d.exr -o o.%d.exr --stage volts --frames ";
  const Result two = scratch.run(run + "0:1");
  EXPECT_EQ(two.status, 0) << two.err;
  expect_says(two.err, {"0.05 s", "0.02 s"});
  EXPECT_FALSE(says(scratch.run(run + "0:3").err, "longer than"));
}

TEST_F(ThermalCommand, AScenePastTheRangeIsSaidInTheWordsOfTheFile) {
  camera("[noise]\nseed = 1\n" + kConverter, "295 K\"\nnetd", "200 K\"\nnetd");
  const Result r = scratch.run("mtf simulate s.toml t300.exr -o out.exr");
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_FALSE(says(r.err, "saturated")) << r.err;
  camera("[noise]\nseed = 1\n[adc]\nbits = 8\nvolts_per_count = \"0.5 uV\"\n", "295 K\"\nnetd", "200 K\"\nnetd");
  const Result hot = scratch.run("mtf simulate s.toml t300.exr -o hot.exr");
  expect_says(hot.err, {"adc.volts_per_count", "adc.bits", "lower adc.offset"});
  EXPECT_FALSE(says(hot.err, "integration")) << hot.err;
}

TEST_F(ThermalCommand, AFigureFarBeyondTheBandwidthOfThePixelsIsWarnedAbout) {
  const std::string netd = kUncooled.substr(kUncooled.find("netd = "));
  const std::string dstar = "dstar = 1e9\nnoise_bandwidth = \"8 kHz\"\n";
  camera("", netd, dstar);
  EXPECT_FALSE(says(scratch.run("mtf budget s.toml").err, "1/(4 tau)"));  // nobody knows tau
  camera("[lag]\ntime_constant = \"10 ms\"\n", netd, dstar);
  for (const std::string command : {"config check s.toml", "budget s.toml"}) {
    const Result r = scratch.run("mtf " + command);
    EXPECT_EQ(r.status, 0) << r.err;
    const std::string said = r.out + r.err;
    expect_says(said, {"detector.noise_bandwidth", "1 Hz", "8e+03 Hz", "1/(4 tau)", "= 25 Hz"});
  }
}

TEST_F(ThermalCommand, KeysThatContradictEachOtherAreWarnedAbout) {
  const auto checked = [&] {
    const Result r = scratch.run("mtf config check s.toml");
    EXPECT_EQ(r.status, 0) << r.err;
    return r.out + r.err;
  };
  camera("", "absorptance = 0.8", "absorptance = 0.8\nfill_factor = 1.0");
  EXPECT_FALSE(says(checked(), "fill_factor:")) << checked();
  camera("", "absorptance = 0.8", "absorptance = 0.8\nfill_factor = 0.7");
  expect_says(checked(), {"detector.fill_factor", "0.7", "1 in \"footprint\""});
  const std::string counts = "[adc]\nbits = 14\noffset = 4000\n";
  camera(counts, "responsivity = 1e5", "counts_per_kelvin = 30.0");
  EXPECT_FALSE(says(checked(), "calls it 1 uV")) << checked();
  camera(counts + "[nonuniformity]\ndsnu = \"2 mV\"\n[noise]\ncolumn = \"5 uV\"\n", "responsivity = 1e5",
         "counts_per_kelvin = 30.0\nreadout_noise = \"3 uV\"");
  for (const std::string path : {"detector.readout_noise", "nonuniformity.dsnu", "noise.column"})
    expect_says(checked(), {path + ": in volts beside detector.counts_per_kelvin"});
  expect_says(checked(), {"taken for 2e+03 counts"});
}

TEST_F(ThermalCommand, FlatFramesAreThoseOfTwoBlackbodies) {
  camera("[nonuniformity]\nprnu = 0.02\ndsnu = \"5 uV\"\n[noise]\nseed = 2\n" + kConverter +
         "[correction]\ncold = \"10 degC\"\nhot = \"40 degC\"\nframes = 32\n");
  const Json terms = budget();
  EXPECT_EQ(terms["prnu"]["value"], 0.0);
  EXPECT_GT(terms["correction"]["value"].get<double>(), 0.0);
  EXPECT_GT(terms["hottest_scene"]["value"].get<double>(), 313.15);
  expect_says(scratch.run("mtf config explain s.toml").out, {"two points", "283.15 K", "313.15 K"});
  ASSERT_EQ(scratch.run("mtf simulate s.toml t300.exr -o out.exr").status, 0);
  const Image image = read(scratch / "out.exr");
  double sum = 0.0, squares = 0.0;
  for (std::int64_t i = 0; i < image.size(); ++i) sum += static_cast<double>(image.data()[i]);
  const double n = static_cast<double>(image.size()), mean = sum / n;
  for (std::int64_t i = 0; i < image.size(); ++i) squares += std::pow(static_cast<double>(image.data()[i]) - mean, 2);
  const double rms_v = 0.5e-6 * std::sqrt(squares / n);
  const double expected = std::hypot(terms["temporal"]["value"].get<double>(), terms["spatial"]["value"].get<double>());
  EXPECT_NEAR(rms_v / expected, 1.0, 0.05);  // a standard error of 1.3 % with 3072 pixels
}

TEST_F(ThermalCommand, ErrorsHaveTheirPlace) {
  camera("", "absorptance = 0.8", "quantum_efficiency = 0.8");
  expect_refused("mtf config check s.toml", {"s.toml:23:22: error: detector.quantum_efficiency", "write absorptance"});
  camera("", "netd_temperature = \"300 K\"\n", "");
  for (const std::string command : {"config check s.toml", "budget s.toml", "simulate s.toml t300.exr -o out.exr"})
    expect_refused("mtf " + command, {"s.toml:26:", "detector.netd: given without netd_temperature"});
  camera("[lag]\n");
  expect_refused("mtf config check s.toml", {"s.toml:30:", "[lag]: time_constant is missing"});
  camera(kConverter, "responsivity = 1e5", "counts_per_kelvin = 30.0");
  expect_refused("mtf config check s.toml",
                 {"s.toml:24:", "detector.counts_per_kelvin: given beside adc.volts_per_count"});
  camera("[adc]\nbits = 14\n");
  expect_refused("mtf config check s.toml", {"s.toml:30:", "adc.volts_per_count: missing"});
  camera("[correction]\n");
  expect_refused("mtf config check s.toml", {"s.toml:30:", "[correction]: its flat frames"});
}

#ifdef MTFKIT_HAVE_STUDY
TEST_F(ThermalCommand, StudiesHaveItsNetdAndNep) {
  camera("[[presample]]\nkind = \"diffraction\"\n");
  const std::string study =
      "schema = 1\nsensor = \"s.toml\"\n[[axis]]\nparameter = \"detector.netd\"\nvalues = [\"25 mK\", \"50 mK\"]\n"
      "[metrics]\nlist = [\"netd\", \"nep\", \"mrtd\", \"mdtd\"";
  write_file(scratch / "study.toml", study + "]\n");
  const Result r = scratch.run("mtf sweep study.toml -o sweep");
  ASSERT_EQ(r.status, 0) << r.err;
  std::istringstream rows(read_file(scratch / "sweep" / "designs.csv"));
  std::string head, first, second;
  std::getline(rows, head), std::getline(rows, first), std::getline(rows, second);
  expect_says(head, {"netd,nep"});
  const auto number = [](const std::string& row, int column) {
    std::istringstream text(row);
    std::string cell;
    for (int i = 0; i <= column; ++i) std::getline(text, cell, ',');
    return std::stod(cell);
  };
  EXPECT_NEAR(number(first, 2), 25.0 / 0.9, 1e-6);
  EXPECT_NEAR(number(second, 2), 50.0 / 0.9, 1e-6);
  // pi/5 x 0.83782128952792565 W m^-2 sr^-1 K^-1 x (17 um)^2 x 50 mK, in pW.
  EXPECT_NEAR(number(second, 3), 7.6067493717, 1e-6);
  const Json terms = budget();  // of 50 mK, the second design
  EXPECT_NEAR(terms["mrtd"]["value"].get<double>() / number(second, 4), 1.0, 1e-4);
  EXPECT_NEAR(terms["mdtd"]["value"].get<double>() / number(second, 5), 1.0, 1e-4);
  for (const int column : {4, 5}) {  // MRTD and MDTD follow the NETD of a camera without spatial noise
    EXPECT_GT(number(first, column), 0.0);
    EXPECT_NEAR(number(second, column) / number(first, column), 2.0, 1e-9);
  }
  write_file(scratch / "study.toml", study.substr(0, study.find("list = [")) + "list = [\"signal\"]\n");
  const Result wrong = scratch.run("mtf sweep study.toml -o wrong");
  expect_says(wrong.err + wrong.out, {"thermal detector", "electrons"});
}
#endif

}  // namespace
}  // namespace apps_test
