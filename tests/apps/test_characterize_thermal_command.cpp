// SPDX-License-Identifier: Apache-2.0

// `mtf characterize` of blackbodies: frames that `mtf simulate` draws of a known uncooled camera, its numbers back, the
// sensor file whose budget says the same, and refusals.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"
#include "tests/apps/characterize_page.h"
#include "tests/apps/command.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

/// The uncooled camera of `mtf demo`, without air.
const std::string kBolometer = R"(schema = 2
name = "uncooled"
[frame]
focal_length = "100 mm"
pitch = "15 um"
frame_time = "20 ms"
[scene]
quantity = "temperature"
sample = "15 um"
[optics]
f_number = 1.0
transmission = 0.9
emissivity = 0.1
temperature = "293 K"
stop_temperature = "293 K"
[band]
wavelength = ["8 um", "13 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "15 um"
[detector]
kind = "thermal"
absorptance = 0.8
responsivity = 1e5
shutter_temperature = "293 K"
netd = "50 mK"
netd_f_number = 1.0
netd_transmission = 1.0
netd_temperature = "300 K"
[nonuniformity]
dsnu = "0.2 uV"
prnu = 0.01
[noise]
seed = 1
row = "0.05 uV"
column = "0.1 uV"
fixed_column = "0.1 uV"
[adc]
bits = 14
volts_per_count = "0.1 uV"
offset = 4000
)";
/// Counts a kelvin at 298 K: pi/5 x 0.9 x (15 um)^2 x 1e5 V/W x dL/dT / 0.1 uV, the integral by scipy.
constexpr double kSitf = 92.63944108317762;
constexpr std::array kKelvin{298, 303, 308};

class CharacterizeBlackbodies : public testing::Test {
 protected:
  /// 16 frames of each of the temperatures.
  void simulate(const std::string& sensor, const std::string& folder) const {
    write_file(scratch / (folder + ".toml"), sensor);
    write_file(scratch / "schedule.csv", "frame,parameter,value\n1,optics.f_number,1\n");
    std::string command = "mkdir " + folder;
    for (const int kelvin : kKelvin) {
      const std::string k = std::to_string(kelvin);
      mtf::Image flat(kSide, kSide);
      std::fill_n(flat.data(), flat.size(), static_cast<float>(kelvin));
      mtf::io::write_exr((scratch / (k + ".exr")).string(), {{"Y", flat.view()}}, {});
      command += " && mtf simulate " + folder + ".toml " + k + ".exr -o '" + folder + "/" + k +
                 ".%04d.png' --schedule schedule.csv --quiet --frames " + k + "1:" + std::to_string(10 * kelvin + 16);
    }
    const Result run = scratch.run(command);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  static std::string stacks(const std::string& folder, const std::vector<int>& kelvin, const std::string& head = "") {
    std::string text = "nominal = \"" + folder + ".toml\"\n" + head;
    for (const int k : kelvin)
      text += "[[stack]]\nframes = \"" + folder + "/" + std::to_string(k) + ".*.png\"\ntemperature = \"" +
              std::to_string(k) + " K\"\n";
    return text;
  }
  Result characterize(const std::string& text, const std::string& more = "--format json") const {
    write_file(scratch / "stacks.toml", text);
    return scratch.run("mtf characterize stacks.toml " + more);
  }
  static std::map<std::string, Json> numbers(const std::string& text) {
    std::map<std::string, Json> all;
    const Json document = Json::parse(text);
    for (const Json& one : document.at("numbers")) all[one.at("name").get<std::string>()] = one;
    return all;
  }
  static double value(const Json& one) { return one.at("value").get<double>(); }
  static double sd(const Json& one) { return one.at("sd").get<double>(); }
  /// What rounding to two digits beyond the error leaves, at most: half a hundredth of that, whose interval is four.
  static double rounding(const Json& one) {
    const Json& interval = one.at("interval95");
    return 0.005 * 0.5 * (interval[1].get<double>() - interval[0].get<double>());
  }

  static constexpr std::int64_t kSide = 64;
  Scratch scratch;
};

// Hot, dead and blinking pixels and the lag, of frames and of the frames of the twin, whose counts are volts of their
// own.
TEST_F(CharacterizeBlackbodies, DefectsAndLagAreInTheTwin) {
  const std::string still = kBolometer +
                            "[defects]\nhot_fraction = 0.01\nhot = \"10 uV\"\ndead_fraction = 0.004\n"
                            "[blinking]\nfraction = 0.01\nexcess = \"12 uV\"\ndwell = 3\n";
  simulate(still, "truth");
  write_file(scratch / "nominal.toml", kBolometer);
  for (int t = 1; t <= 50; ++t) {
    mtf::Image flat(kSide, kSide);
    std::fill_n(flat.data(), flat.size(), t <= 12 ? 308.0F : 298.0F);
    mtf::io::write_exr((scratch / ("scene." + std::to_string(1000 + t) + ".exr")).string(), {{"Y", flat.view()}}, {});
  }
  write_file(scratch / "lagging.toml", still + "[lag]\ntime_constant = \"12 ms\"\n");
  const Result run = scratch.run("mkdir step && mtf simulate lagging.toml scene.%04d.exr -o 'step/f.%04d.png' --quiet");
  ASSERT_EQ(run.status, 0) << run.err;
  const auto stacks_of = [](const std::string& folder, const std::string& nominal) {
    return replaced(stacks(folder, {298, 308}), "\"" + folder + ".toml\"", "\"" + nominal + "\"");
  };
  const Result found =
      characterize(stacks_of("truth", "nominal.toml") + "[[stack]]\nframes = \"step/*.png\"\nstep = \"20 ms\"\n",
                   "-o camera --format json");
  ASSERT_EQ(found.status, 0) << found.err << found.out;
  std::map<std::string, Json> first = numbers(found.out);
  const double mk_per_uv = 1e4 / kSitf;
  const std::map<std::string, double> truth{
      {"hot_fraction", 0.01},      {"hot_excess", 10.0 * mk_per_uv},      {"dead_fraction", 0.004},
      {"blinking_fraction", 0.01}, {"blinking_excess", 12.0 * mk_per_uv}, {"blinking_dwell", 3.0},
      {"lag_time_constant", 0.012}};
  for (const auto& [name, number] : truth) {
    ASSERT_EQ(first.at(name).at("verdict"), "determined") << name << first.at(name);
    EXPECT_NEAR(value(first.at(name)), number, 4.0 * sd(first.at(name))) << name;
  }
  const std::string twin = read_file(scratch / "camera/sensor.toml");
  expect_says(twin,
              {"[lag]\ntime_constant = { value = ", "hot_fraction = { value = ", "[blinking]\nfraction = { value = "});
  expect_says(read_file(scratch / "camera/defects.csv"), {"temporal noise,"});
  const std::string still_twin = twin.substr(0, twin.find("[lag]"));
  simulate(replaced(still_twin, "seed = 1", "seed = 9"), "twin");
  const Result again = characterize(stacks_of("twin", "twin.toml"));
  ASSERT_EQ(again.status, 0) << again.err << again.out;
  std::map<std::string, Json> second = numbers(again.out);
  for (const char* const name : {"hot_fraction", "hot_excess", "dead_fraction", "blinking_fraction", "blinking_excess",
                                 "blinking_dwell", "netd"})
    EXPECT_NEAR(value(second.at(name)), value(first.at(name)),
                4.0 * std::hypot(sd(second.at(name)), sd(first.at(name))))
        << name;
}

TEST_F(CharacterizeBlackbodies, ClosesTheLoop) {
  simulate(kBolometer, "truth");
  const std::string reference = "[options]\nreference_temperature = \"298 K\"\n";
  std::string nominal = replaced(kBolometer, "responsivity = 1e5", "responsivity = 2e5");
  for (const auto& kelvin : {std::vector{298, 308}, std::vector{298, 303, 308}}) {
    write_file(scratch / "truth.toml", replaced(nominal, "netd = \"50 mK\"", "netd = \"80 mK\""));
    const Result found = characterize(stacks("truth", kelvin, reference), "--format json --force -o camera");
    ASSERT_EQ(found.status, 0) << found.err << found.out;
    std::map<std::string, Json> all = numbers(found.out);
    // Of the white noise 50 mK are those of f/1 and a lens that lets all through at 300 K; 0.1 uV is a count.
    const double budget_mk = 50.0 / 0.9 * 1.0;
    for (const auto& [name, truth, more] :
         {std::tuple{"sitf", kSitf, kSitf * 0.01 / kSide}, std::tuple{"netd", budget_mk, 0.02 * budget_mk},
          std::tuple{"noise_tv", 500.0 / kSitf, 0.0}, std::tuple{"noise_th", 1000.0 / kSitf, 0.0},
          std::tuple{"noise_h", 1000.0 / kSitf, 0.0}, std::tuple{"prnu", 0.01, 0.0},
          std::tuple{"offset", 4000.0, 0.3}}) {
      EXPECT_NEAR(value(all.at(name)), truth, 4.0 * std::hypot(sd(all.at(name)), more)) << name;
      EXPECT_LT(sd(all.at(name)), 0.15 * truth) << name;
    }
    EXPECT_EQ(all.at("mrtd").at("verdict"), "predicted");

    // The page: counts over radiance, with residuals where the line has any; MRTD and MDTD; spectra of two patterns;
    // three in time; profiles of rows and columns; two histograms of each pattern; bars.
    const std::string page = read_file(scratch / "camera/report.html");
    expect_whole_page(page);
    EXPECT_EQ(count_of(page, "<svg "), (kelvin.size() > 2 ? 2U : 1U) + 2U + 2U + 3U + 2U + 4U + 1U);
    for (const char* const name : {"sitf", "netd", "noise_h", "mrtd"}) {
      const std::string row = page.substr(page.find(">" + std::string(name) + "</code>"), 2000);
      EXPECT_TRUE(says(row, "<data value=\"" + all.at(name).at("value").dump() + "\"")) << name;
    }
    expect_says(page, {"Temperature (K)", "mK rms, with 95 % intervals", "of the fixed pattern", "MDTD [mK]"});

    // The budget of the written file has the numbers that were found, to two digits beyond their errors.
    const Result budget = scratch.run("mtf budget camera/sensor.toml --temperature '298 K' --format json");
    ASSERT_EQ(budget.status, 0) << budget.err;
    const Json terms = Json::parse(budget.out)["terms"];
    EXPECT_NEAR(value(terms["signal_per_k"]) / 1e-6, value(all.at("sitf")), rounding(all.at("sitf")));
    double temporal = 0.0, rounded = 0.0;
    for (const char* const name : {"netd", "noise_t", "noise_tv", "noise_th"}) {
      temporal += std::pow(value(all.at(name)), 2);
      rounded += rounding(all.at(name));
    }
    EXPECT_NEAR(value(terms["netd"]), std::sqrt(temporal), rounded);
    EXPECT_NEAR(value(terms["mrtd"]), value(all.at("mrtd")), 1e-9);
    EXPECT_NEAR(value(terms["mdtd"]), value(all.at("mdtd")), 1e-9);
  }

  // Frames of the written file with another seed: the same numbers within both errors, of two arrays.
  const std::map<std::string, Json> first = numbers(read_file(scratch / "camera/result.json"));
  simulate(replaced(read_file(scratch / "camera/sensor.toml"), "seed = 1", "seed = 2"), "twin");
  const Result again = characterize(stacks("twin", {298, 303, 308}, reference));
  ASSERT_EQ(again.status, 0) << again.err;
  for (const auto& [name, one] : numbers(again.out)) {
    const Json& before = first.at(name);
    if (one.at("verdict") != "determined" || before.at("verdict") != "determined") continue;
    const double more = name == "sitf" ? kSitf * 0.01 / kSide : name == "offset" ? 0.3 : 0.0;
    EXPECT_NEAR(value(one), value(before), 4.0 * std::hypot(sd(one), sd(before), 2.0 * more)) << name;
  }
}

// Hot pixels are defects and no part of the pattern: 0.2 uV of it are two counts.
TEST_F(CharacterizeBlackbodies, DefectsAreNoPartOfDsnu) {
  simulate(kBolometer + "[defects]\nhot_fraction = 0.004\nhot = \"20 uV\"\n", "truth");
  const Result found = characterize(stacks("truth", {298, 308}));
  ASSERT_EQ(found.status, 0) << found.err;
  const Json dsnu = numbers(found.out).at("dsnu");
  EXPECT_NEAR(value(dsnu), 2000.0 / kSitf, 4.5 * sd(dsnu));
  EXPECT_LT(sd(dsnu), 0.15 * value(dsnu));
  EXPECT_NEAR(Json::parse(found.out).at("defect_count").get<double>(), 0.004 * kSide * kSide, 10.0);
  EXPECT_TRUE(
      says(characterize(stacks("truth", {298, 308}), "-o camera").out, "which noise_vh counts and dsnu leaves out"));
  const std::string page = read_file(scratch / "camera/report.html");
  expect_whole_page(page);
  expect_says(page, {"id=\"defect-1\""});
  EXPECT_EQ(count_of(read_file(scratch / "camera/defects.csv"), "fixed pattern,"),
            Json::parse(found.out).at("defect_count"));
}

TEST_F(CharacterizeBlackbodies, RadiancesPhotonDetectorsAndRefusals) {
  simulate(kBolometer, "truth");
  const std::string both = stacks("truth", {298, 308});
  const Result kelvin = characterize(both + "[light]\ntemperature_sd = \"20 mK\"\n", "");
  ASSERT_EQ(kelvin.status, 0) << kelvin.err;
  expect_says(characterize(both + "[options]\nreference_temperature = \"350 K\"\n", "").out,
              {"far from the blackbodies"});
  expect_says(kelvin.out, {"(random)", "(blackbodies)", "predicted", "300 K", "netd_temperature of"});
  // W m^-2 sr^-1 of 298 and of 308 K in 8 to 13 um, by scipy.
  std::string text = replaced(both, "temperature = \"298 K\"", "radiance = 45.628435587757856");
  text = replaced(text, "temperature = \"308 K\"", "radiance = 53.26336543095506");
  const Result radiance = characterize(text);
  ASSERT_EQ(radiance.status, 0) << radiance.err;
  EXPECT_NEAR(value(numbers(radiance.out).at("sitf")) / value(numbers(characterize(both).out).at("sitf")), 1.0, 1e-9);

  // A photon detector has SiTF and noise in kelvin, and no sensor file.
  const std::size_t detector = kBolometer.find("[detector]");
  std::string photons = kBolometer.substr(0, detector) +
                        "[detector]\nquantum_efficiency = 0.7\nfull_well = \"1000 Me-\"\n" + "[adc]\nbits = 14\n";
  write_file(scratch / "truth.toml", replaced(photons, "frame_time", "integration_time"));
  const Result other = characterize(both, "--format json -o photons");
  ASSERT_EQ(other.status, 0) << other.err;
  EXPECT_TRUE(numbers(other.out).contains("netd"));
  EXPECT_FALSE(fs::exists(scratch / "photons/sensor.toml"));
  expect_whole_page(read_file(scratch / "photons/report.html"));

  write_file(scratch / "truth.toml", kBolometer);
  expect_error(characterize(stacks("truth", {298})), 2, {"1 usable stack", "two temperatures"});
  expect_error(characterize(replaced(both, "\"308 K\"", "\"298 K\"")), 2, {"one radiance"});
  expect_error(characterize(replaced(both, "\"308 K\"", "\"24 degC\"")), 2, {"lower mean", "paired wrongly"});
  expect_error(characterize(replaced(both, "temperature = \"308 K\"", "photons = 5")), 2,
               {"temperature", "in one way"});
  expect_error(characterize(replaced(both, "nominal = \"truth.toml\"", "[camera]\nbits = 14")), 2,
               {"temperature", "nominal sensor"});
  expect_error(characterize(replaced(both, "temperature = \"308 K\"", "light = false")), 2, {"give all temperatures"});
  expect_error(characterize(both + "[light]\nrepeatability = 0.1\n"), 2, {"repeatability", "temperature_sd"});
  expect_error(characterize(text + "[light]\nemissivity = 0.9\n"), 2, {"emissivity", "stacks by temperature"});
  std::string lamps = replaced(both, "temperature = \"298 K\"", "photons = 5");
  expect_error(characterize(replaced(lamps, "temperature = \"308 K\"", "photons = 6")), 2,
               {"thermal detector", "temperature = "});
}

}  // namespace
}  // namespace apps_test
