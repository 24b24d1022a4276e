// SPDX-License-Identifier: Apache-2.0

// `mtf range`, and the curves of `mtf budget --curves`.

#include <cmath>

#include <nlohmann/json.hpp>

#include "tests/apps/command.h"
#include "tests/apps/study/range_camera.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

class RangeCommand : public testing::Test {
 protected:
  void SetUp() override { write_file(scratch / "camera.toml", study_test::camera("")); }
  Result run(const std::string& options) const { return scratch.run("mtf range camera.toml " + options); }

  Scratch scratch;
};

TEST_F(RangeCommand, SaysTargetContrastAirAndObserverBesideTheRanges) {
  const Result r = run("--target nato --display-height '200 mm' --viewing-distance '600 mm'");
  ASSERT_EQ(r.status, 0) << r.err;
  expect_says(r.out, {"target: 2.3 m, 2 K", "300 K", "magnification 6.51", "V50 2, 7.5, 13", "N50 0.75, 3, 6",
                      "air: none", "vacuum", "Johnson's ranges end at the Nyquist frequency", "neither counts aliasing",
                      "limited by the Nyquist", "no standard deviation"});
  EXPECT_EQ(run("--target-size '230 cm' --contrast '2000 mK' --display-height '20 cm' --viewing-distance '60 cm'").out,
            r.out);
  EXPECT_NE(run("--target nato --contrast '1 K' --display-height '20 cm' --viewing-distance '60 cm'").out, r.out);
}

TEST_F(RangeCommand, TablesForProgramsAreComplete) {
  const std::string options =
      "--target nato --magnification 5 --frame-rate '60 Hz' --extinction 0.2 --ranges '1,2.5,5 km' ";
  const Json json = Json::parse(run(options + "--format json").out);
  EXPECT_EQ(json["ranges"].size(), 6u);
  EXPECT_TRUE(json["ranges"]["johnson_range_detect"]["at_nyquist"]);
  EXPECT_TRUE(json["ranges"]["ttp_range_detect"]["sd"].is_null());
  EXPECT_EQ(json["conditions"]["contrast"]["value"], 2.0);
  const Json& probability = json["probability"];
  EXPECT_EQ(probability["range_m"], Json({1000.0, 2500.0, 5000.0}));
  const Result csv = run(options + "--format csv");
  EXPECT_TRUE(csv.out.starts_with("range_m,ttp_detect,ttp_detect_error,ttp_detect_sd,ttp_recognise,"));
  EXPECT_EQ(lines(csv.out), 4u);
  expect_says(csv.err, {"target: 2.3 m", "0.2 per km"});
  const Result figure = run(options + "--plot p.svg -o out.txt");
  ASSERT_EQ(figure.status, 0) << figure.err;
  EXPECT_TRUE(fs::exists(scratch / "p.svg.csv"));
}

// What a target at a range is takes the defocus there: no number is better than that of another range. The distance
// that the message gives is that of the range: F^2 (1/r - 1/f) = 22500 mm^2 (1/2000 m - 1/20 m) = -1113.75 um.
TEST_F(RangeCommand, ATargetIsOutOfFocusByItsRange) {
  write_file(scratch / "camera.toml", replaced(study_test::camera(""), "kind = \"diffraction\"",
                                               "kind = \"defocus\"\ndistance = \"range\"\nfocus = \"20 m\""));
  expect_error(run("--target nato --magnification 5"), 2, {"presample[0].focus", "distance = ", "1/range"});
  write_file(
      scratch / "study.toml",
      "schema = 1\nsensor = \"camera.toml\"\n[[axis]]\nparameter = \"defocus.focus\"\nvalues = [\"5 m\", \"20 m\"]\n" +
          study_test::kConditions + "range = \"2 km\"\n[metrics]\nlist = [\"ttp_range_detect\", \"niirs_giqe4\", " +
          "\"johnson_range_detect\", \"gsd\", \"snr\", \"ttp\"]\n");
  const Result sweep = scratch.run("mtf sweep study.toml -o out");
  ASSERT_EQ(sweep.status, 0) << sweep.err;
  expect_says(sweep.out + sweep.err, {"presample[0].focus", "2000 m", " um\""});
  std::istringstream csv(read_file(scratch / "out/designs.csv"));
  const auto cells = [&] {
    std::vector<std::string> found;
    std::string line, cell;
    do std::getline(csv, line);
    while (line.starts_with("#"));
    for (std::istringstream row(line); std::getline(row, cell, ',');) found.push_back(cell);
    return found;
  };
  const std::vector<std::string> names = cells(), first = cells();
  for (std::size_t c = 0; c < std::min(names.size(), first.size()); ++c) {
    const bool at_a_range = names[c].find("_range_") != std::string::npos || names[c].starts_with("niirs");
    EXPECT_EQ(first[c].empty(), at_a_range && names[c] != "pareto") << names[c];
  }
}

TEST_F(RangeCommand, RefusesWithTheOptionToGive) {
  const std::string seen = " --magnification 5";
  expect_error(run("--contrast '0 K' --target-size '2 m'" + seen), 2, {"--contrast", "as warm as", "'2 K'"});
  expect_error(run("--contrast '-1 K' --target-size '2 m'" + seen), 2, {"--contrast", "above 0"});
  expect_error(run("--contrast '2 K'" + seen), 2, {"--target-size", "--target nato"});
  expect_error(run("--target-size '2 m'" + seen), 2, {"--contrast '2 K'"});
  expect_error(run("--target tank"), 2, {"--target", "nato"});
  expect_error(run("--target nato --contrast 2"), 2, {"--contrast", "unit"});
  expect_error(run("--target nato --probability 1" + seen), 2, {": --probability"});
  expect_error(run("--target-size '-1 m' --contrast '1 K'" + seen), 2, {": --target-size = -1 m"});
  expect_error(run("--target nato --display-height '1 m'"), 2, {"--viewing-distance"});
  expect_error(run("--target nato --ranges 1,2" + seen), 2, {"--ranges", "unit"});
  expect_error(run("--target nato --ranges '2,1 km'" + seen), 2, {"--ranges", "rise"});
  const Result blind = run("--target nato");
  EXPECT_EQ(blind.status, 0);
  expect_says(blind.out, {"no range for TTP detect", "--magnification", "--display-height"});
  expect_error(run("--target nato --ranges '1:10:100000 km'" + seen), 2, {"--ranges", "10000"});
  const Result words = run("--target nato --plot ascii" + seen);
  expect_error(words, 2, {"ascii: ", ".svg"});
  EXPECT_FALSE(says(words.err, "word"));
  write_file(scratch / "camera.toml", study_test::camera("[path]\ntransmission = 0.8\n"));
  expect_error(run("--target nato" + seen), 2, {"one range", "[atmosphere]"});
  write_file(scratch / "camera.toml", study_test::camera(study_test::kFog + "range = \"1 km\"\n"));
  expect_error(run("--target nato --extinction 0.2" + seen), 2, {": --extinction", "remove"});
}

// One message for all that a new file lacks, with what to write for each; a part that is there is not asked for.
TEST_F(RangeCommand, NamesAllThatIsMissingAtOnce) {
  const std::string bare =
      "schema = 2\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n[atmosphere]\nmodel = \"tropical\"\n";
  write_file(scratch / "camera.toml", bare);
  const std::vector<std::string_view> of_file{
      "integration_time =", "f_number =", "wavelength =", "quantum_efficiency =", "[atmosphere] range ="};
  const auto told = [&](const std::string& options) {
    const Result refused = run(options);
    expect_error(refused, 2, {"camera.toml"});
    return refused.err.substr(refused.err.find("mtf: error: "));  // behind the notes about the file
  };
  const auto parts = [](const std::string& text) { return 1 + std::count(text.begin(), text.end(), ';'); };
  const std::string all = told("");
  expect_says(all, {"--contrast '2 K'", "--target-size '2.3 m'"});
  for (const std::string_view part : of_file) expect_says(all, {part});
  EXPECT_EQ(parts(all), 2 + std::ssize(of_file)) << all;
  EXPECT_EQ(parts(told("--target nato")), std::ssize(of_file));
  write_file(scratch / "camera.toml", replaced(bare, "\"tropical\"\n", "\"tropical\"\nrange = \"1 km\"\n"));
  EXPECT_EQ(parts(told("--target nato")), std::ssize(of_file) - 1);
  write_file(scratch / "camera.toml",
             study_test::camera("[atmosphere]\nmodel = \"tropical\"\ntarget_altitude = \"0 m\"\n"));
  const std::string air = told("--target nato");
  expect_says(air, {"say: [atmosphere] range = \"2 km\"\n"});
}

/// Integral of sinc^2(w f) over |f| <= band, by a plain sum.
double averaged(double w, double band) {
  constexpr int kSteps = 200000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = M_PI * w * band * (i + 0.5) / kSteps, sinc = std::sin(x) / x;
    sum += sinc * sinc;
  }
  return 2.0 * band * sum / kSteps;
}

// FLIR92's formula from the NETDs of `mtf budget` and the MTF of `mtf curve`; MRTD of no row is taken from the curves.
TEST_F(RangeCommand, CurvesOfMinimumTemperaturesAreFlir92) {
  const Json terms = Json::parse(scratch.run("mtf budget camera.toml --format json").out)["terms"];
  const Json curves = Json::parse(scratch.run("mtf budget camera.toml --curves --format json").out)["curves"];
  const std::size_t half = 7;  // 8/16 of Nyquist
  EXPECT_NEAR(curves["frequency_cy_mrad"][half], 2.5, 1e-12);
  EXPECT_NEAR(curves["mrtd_mK"][half].get<double>() / terms["mrtd"]["value"].get<double>(), 1.0, 1e-12);
  EXPECT_NEAR(curves["mdtd_mK"][half].get<double>() / terms["mdtd"]["value"].get<double>(), 1.0, 1e-12);
  EXPECT_TRUE(curves["mrtd_mK"][16].is_null());  // beyond Nyquist
  EXPECT_TRUE(curves["mdtd_mK"][16].is_number());
  const double tvh = terms["netd"]["value"], vh = terms["spatial_netd"]["value"];
  const double spacing = 0.1, frames = 0.1 / 5e-3;  // 15 um / 150 mm; eye time / frame time
  for (const std::size_t row : {0U, 7U, 15U})
    for (const char* axis : {"x", "y"}) {
      const double f = curves["frequency_cy_mrad"][row], w = 0.5 / f;
      const Json otf = Json::parse(scratch
                                       .run("mtf curve camera.toml --unit cy/mrad --freq " + mtf::format_double(f) +
                                            " --angle " + (*axis == 'x' ? "0" : "90") + " --format json")
                                       .out)["system"];
      const double mtf = std::hypot(otf["re"][0].get<double>(), otf["im"][0].get<double>());
      const double averages = spacing * averaged(w, 5.0) * spacing * averaged(7.0 * w, 5.0);
      const double mrtd = M_PI * M_PI / 8.0 * 2.5 * std::sqrt((tvh * tvh / frames + vh * vh) * averages) / mtf;
      EXPECT_NEAR(curves[std::string("mrtd_") + axis + "_mK"][row].get<double>() / mrtd, 1.0, 1e-5) << f << axis;
    }
  expect_error(scratch.run("mtf budget camera.toml --plot x.svg"), 2, {"--plot", "--curves"});
  const Result table = scratch.run("mtf budget camera.toml --curves");
  expect_says(table.out, {"MRTD x [mK]", "observer of bars", "numerical error"});
}

// Without anything that ends the MTF a square has no number: its light goes on for ever.
TEST_F(RangeCommand, CurvesLeaveOutWhatHasNoKnownError) {
  const std::string text = study_test::camera("");
  write_file(scratch / "camera.toml", text.substr(0, text.find("[[presample]]")));
  const Json all = Json::parse(scratch.run("mtf budget camera.toml --curves --format json").out);
  for (const auto& mdtd : all["curves"]["mdtd_mK"]) EXPECT_TRUE(mdtd.is_null());
  EXPECT_FALSE(says(scratch.run("mtf budget camera.toml --curves").out, "inf"));
}

}  // namespace
}  // namespace apps_test
