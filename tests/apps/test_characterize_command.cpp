// SPDX-License-Identifier: Apache-2.0

// `mtf characterize`: frames of a sensor file that `mtf simulate` draws, the sensor file that comes back, and refusals.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

#include "calib/characterize/pattern.h"
#include "mtf/io/image_io.h"
#include "tests/apps/characterize_page.h"
#include "tests/apps/command.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

using Json = nlohmann::json;

const std::string kSensor = R"(schema = 2
name = "camera"   # its author's words
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "1 ms"
[scene]
quantity = "photon_radiance"
sample = "15 um"
[optics]
f_number = 2.0
[band]
wavelength = ["3.8 um", "4.2 um"]
[[readout]]
kind = "crosstalk"
side = 0.015
[detector]
quantum_efficiency = 0.6
full_well = "50 ke-"
read_noise = "3 e-"
[nonlinearity]
a2 = -0.03
[nonuniformity]
prnu = 0.012
dsnu = "4 e-"
[noise]
seed = 1
row = "1.5 e-"
fixed_column = "2 e-"
[adc]
bits = 14
electrons_per_count = "2.5 e-"
offset = 100.3
)";

/// Integration times of the levels, in units of 4 ke-: frames 10 k to 10 k + 9 are of level k.
constexpr std::array kTimes{1e-6, 0.5, 1.0, 2.0, 4.0, 6.0, 8.0};
constexpr double kUnit_s = 0.128e-3;

/// A scratch folder with flat.exr, and the photons at a pixel in a unit of time.
class CharacterizeCommand : public testing::Test {
 protected:
  CharacterizeCommand() {
    mtf::Image flat(kSide, kSide);
    std::fill_n(flat.data(), flat.size(), 8e17F);
    mtf::io::write_exr((scratch / "flat.exr").string(), {{"Y", flat.view()}}, {});
    std::string still = replaced(kSensor, "quantum_efficiency = 0.6", "quantum_efficiency = 1.0");
    still = still.substr(0, still.find("[nonlinearity]"));
    write_file(scratch / "still.toml", replaced(still, "read_noise = \"3 e-\"", "") + "[noise]\nshot = false\n");
    const Result run = scratch.run("mtf simulate still.toml flat.exr -o e.exr --stage electrons");
    if (run.status != 0) throw std::runtime_error(run.err);
    photons_ =
        static_cast<double>(mtf::io::read_image((scratch / "e.exr").string()).planes.at(0).at(3, 3)) * kUnit_s / 1e-3;
  }

  /// The frames of a sensor file below `folder`, and the file that describes them.
  void simulate(const std::string& sensor, const std::string& folder, int seed, const std::string& more = "") {
    write_file(scratch / (folder + ".toml"), replaced(sensor, "seed = 1", "seed = " + std::to_string(seed)));
    std::string schedule = "frame,parameter,value\n", stacks = more;
    for (std::size_t k = 0; k < kTimes.size(); ++k) {
      schedule += std::to_string(std::max<std::size_t>(1, 10 * k)) + ",frame.integration_time," +
                  std::to_string(kTimes[k] * kUnit_s * 1e9) + " ns\n";
      stacks += "[[stack]]\nframes = \"" + folder + "/f." + std::to_string(k) + "?.png\"\n" +
                (k == 0 ? "light = false\n" : "photons = " + std::to_string(kTimes[k] * photons_) + "\n");
    }
    write_file(scratch / "schedule.csv", schedule);
    write_file(scratch / (folder + "_stacks.toml"), stacks);
    const Result run = scratch.run("mkdir " + folder + " && mtf simulate " + folder + ".toml flat.exr -o '" + folder +
                                   "/f.%02d.png' --schedule schedule.csv --frames 1:69 --quiet");
    ASSERT_EQ(run.status, 0) << run.err;
  }

  static std::map<std::string, Json> numbers(const std::string& text) {
    std::map<std::string, Json> all;
    const Json document = Json::parse(text);
    for (const Json& one : document.at("numbers")) all[one.at("name").get<std::string>()] = one;
    return all;
  }

  static constexpr std::int64_t kSide = 128;
  Scratch scratch;
  double photons_ = 0.0;
};

// Sensor file -> frames -> sensor file -> frames: the numbers are those of the first file within their errors, and
// those of the second set of frames are the same within both.
TEST_F(CharacterizeCommand, ClosesTheLoop) {
  simulate(kSensor, "truth", 11, "nominal = \"nominal.toml\"\n[options]\nnonlinearity = 1\n");
  std::string nominal = replaced(kSensor, "2.5 e-", "2.2 e-");
  nominal = replaced(nominal, "prnu = 0.012", "prnu = 0.02");
  write_file(scratch / "nominal.toml", replaced(nominal, "side = 0.015", "side = 0.0"));
  const Result found = scratch.run("mtf characterize truth_stacks.toml -o camera --format json");
  ASSERT_EQ(found.status, 0) << found.err << found.out;
  std::map<std::string, Json> first = numbers(found.out);
  const std::map<std::string, double> truth{{"electrons_per_count", 2.5},
                                            {"read_noise", 3.0},
                                            {"a2", -0.03},
                                            {"rate", 0.6},
                                            {"prnu", 0.012},
                                            {"dsnu", 4.0},
                                            {"row_noise", 1.5},
                                            {"fixed_column", 2.0},
                                            {"crosstalk_side", 0.015},
                                            {"offset", 100.3}};
  for (const auto& [name, value] : truth) {
    ASSERT_TRUE(first.contains(name)) << name << "\n" << found.out;
    const double sd = first.at(name).at("sd").get<double>();
    // The offset, and the rate by the mean responsivity, are those of an array whose patterns have a mean.
    const double more = name == "offset" ? 0.4 * std::hypot(4.0 / kSide, 2.0 / std::sqrt(kSide))
                        : name == "rate" ? 0.6 * 0.012 / kSide
                                         : 0.0;
    EXPECT_NEAR(first.at(name).at("value").get<double>(), value, 4.0 * std::hypot(sd, more)) << name;
    EXPECT_LT(sd, 0.12 * std::abs(value)) << name;
  }
  EXPECT_EQ(first.at("transmission").at("verdict"), "not determined");
  EXPECT_TRUE(first.at("transmission").at("value").is_null());

  const std::string sensor = read_file(scratch / "camera/sensor.toml");
  expect_says(sensor, {"its author's words", "stderr = ", "kept from the nominal: optics.f_number",
                       "left out: detector.dark_current", "optics.transmission", "interval = [\"0 e-\", "});
  EXPECT_EQ(Json::parse(read_file(scratch / "camera/result.json")), Json::parse(found.out));
  EXPECT_EQ(lines(read_file(scratch / "camera/levels.csv")), kTimes.size() + 1);
  EXPECT_EQ(scratch.run("mtf config check camera/sensor.toml").status, 0);
  EXPECT_EQ(scratch.run("mtf budget camera/sensor.toml").status, 0);

  simulate(sensor, "twin", 12, "nominal = \"camera/sensor.toml\"\n[options]\nnonlinearity = 1\n");
  const Result again = scratch.run("mtf characterize twin_stacks.toml --format json");
  ASSERT_EQ(again.status, 0) << again.err;
  for (const auto& [name, one] : numbers(again.out)) {
    ASSERT_TRUE(first.contains(name)) << name;
    const Json& before = first.at(name);
    const auto is_known = [](const Json& j) { return j.at("verdict") == "determined" && j.at("sd").is_number(); };
    if (!is_known(one) || !is_known(before) || name == "offset") continue;
    const double sd = std::hypot(one.at("sd").get<double>(), before.at("sd").get<double>());
    EXPECT_NEAR(one.at("value").get<double>(), before.at("value").get<double>(), 4.0 * sd) << name;
  }
  write_file(scratch / "flicker.toml", kSensor + "[flicker]\nwhite = \"3 e-\"\ncorner = 0.01\n");
  const Result twice = scratch.run("mtf characterize truth_stacks.toml --nominal flicker.toml");
  expect_says(twice.out, {"[flicker] of the nominal is noise beside the components measured here"});
}

// Blinking pixels, and the lag of frames across a step from light to dark, none of which the nominal has: the twin's
// frames after a step are the camera's own, and so are its blinking pixels.
TEST_F(CharacterizeCommand, LagAndBlinkingAreInTheTwin) {
  const std::string still = kSensor + "[blinking]\nfraction = 0.02\nexcess = \"300 e-\"\ndwell = 3\n";
  const std::string step = "[[stack]]\nframes = \"step/f.*.png\"\nstep = \"2 ms\"\n";
  simulate(still, "truth", 17, "nominal = \"nominal.toml\"\n[options]\nnonlinearity = 1\n" + step);
  write_file(scratch / "nominal.toml", kSensor);
  write_file(scratch / "step.csv",
             "frame,parameter,value\n1,frame.integration_time,1 ms\n21,frame.integration_time,1 ns\n");
  const auto frames_after_step = [&](const std::string& sensor, const std::string& folder) {
    write_file(scratch / (folder + ".toml"), sensor);
    const Result run = scratch.run("mkdir " + folder + " && mtf simulate " + folder + ".toml flat.exr -o '" + folder +
                                   "/f.%02d.png' --schedule step.csv --frames 1:70 --quiet");
    EXPECT_EQ(run.status, 0) << run.err;
    std::vector<double> means;
    for (int t = 21; t < 25; ++t) {
      const mtf::Image frame =
          mtf::io::read_image((scratch / (folder + "/f." + std::to_string(t) + ".png")).string()).planes.at(0).clone();
      double sum = 0.0;
      for (std::int64_t i = 0; i < frame.size(); ++i) sum += static_cast<double>(frame.data()[i]);
      means.push_back(sum / static_cast<double>(frame.size()));
    }
    return means;
  };
  const std::string lagging = replaced(still, "pitch = \"15 um\"", "pitch = \"15 um\"\nframe_time = \"2 ms\"") +
                              "[lag]\ntime_constant = \"1 ms\"\n";
  const std::vector<double> own = frames_after_step(lagging, "step");
  // The names count without leading zeros, as many cameras do: f.10 is after f.9, not after f.1.
  ASSERT_EQ(scratch.run("for f in truth/f.0?.png step/f.0?.png; do mv $f ${f%.0*}.${f#*.0}; done").status, 0);
  std::string counted = replaced(read_file(scratch / "truth_stacks.toml"), "truth/f.0?.png", "truth/f.?.png");
  write_file(scratch / "truth_stacks.toml", counted);
  const Result found = scratch.run("mtf characterize truth_stacks.toml -o camera --format json");
  ASSERT_EQ(found.status, 0) << found.err << found.out;
  std::map<std::string, Json> all = numbers(found.out);
  for (const auto& [name, truth] :
       {std::pair{"lag_time_constant", 1e-3}, std::pair{"lag_share", std::exp(-2.0)}, std::pair{"read_noise", 3.0},
        std::pair{"blinking_fraction", 0.02}, std::pair{"blinking_excess", 300.0}, std::pair{"blinking_dwell", 3.0},
        std::pair{"electrons_per_count", 2.5}}) {
    ASSERT_TRUE(all.contains(name)) << name << found.out;
    ASSERT_EQ(all.at(name).at("verdict"), "determined") << name << all.at(name);
    EXPECT_NEAR(all.at(name).at("value").get<double>(), truth, 4.0 * all.at(name).at("sd").get<double>()) << name;
  }
  EXPECT_EQ(Json::parse(found.out).at("warnings"), Json::array()) << found.out;
  const std::string twin = read_file(scratch / "camera/sensor.toml");
  expect_says(twin,
              {"[lag]\ntime_constant = { value = ", "frame_time = \"0.002 s\"", "[blinking]\nfraction = { value = "});
  EXPECT_EQ(scratch.run("mtf config check camera/sensor.toml").status, 0);
  const std::vector<double> its = frames_after_step(replaced(twin, "seed = 1", "seed = 5"), "twin_step");
  const double signal = own[0] - own[3], sd = all.at("lag_share").at("sd").get<double>() / std::exp(-2.0);
  // Beside the error of what is kept that of the light, from the error of the gain, and of the array's mean offset.
  for (std::size_t t = 0; t < 3; ++t)
    EXPECT_NEAR(its[t] - its[3], own[t] - own[3], (5.0 * sd * static_cast<double>(t + 1) + 0.02) * signal) << t;
  EXPECT_GT(signal, 50.0);

  // Without a lag the nominal's goes.
  write_file(scratch / "nominal.toml", lagging);
  frames_after_step(kSensor, "none");
  write_file(scratch / "none_stacks.toml", replaced(read_file(scratch / "truth_stacks.toml"), "step/f", "none/f"));
  const Result none = scratch.run("mtf characterize none_stacks.toml -o none_camera --format json");
  ASSERT_EQ(none.status, 0) << none.err << none.out;
  EXPECT_EQ(numbers(none.out).at("lag_share").at("verdict"), "upper limit");
  EXPECT_EQ(read_file(scratch / "none_camera/sensor.toml").find("[lag]"), std::string::npos);
}

// Without a nominal the file has placeholders, which are named; a response that is left out is found, files are
// written.
TEST_F(CharacterizeCommand, AMisfitWritesItsFilesAndSaysSo) {
  simulate(kSensor, "truth", 13, "[camera]\nbits = 14\n");
  const Result found = scratch.run("mtf characterize truth_stacks.toml -o camera");
  expect_error(found, 3, {"exit code 3", "--allow-misfit"});
  expect_says(found.out, {"does not describe", "nonlinearity", "frame.pitch"});
  EXPECT_EQ(Json::parse(read_file(scratch / "camera/result.json")).at("status"), "model_wrong");
  EXPECT_EQ(scratch.run("mtf config check camera/sensor.toml").status, 0);
  EXPECT_EQ(scratch.run("mtf characterize truth_stacks.toml --allow-misfit").status, 0);
  expect_error(scratch.run("mtf characterize truth_stacks.toml -o camera"), 2, {"not empty", "--force"});
}

/// Python: every element is closed in its place.
constexpr const char* kWellFormed = R"(import html.parser, sys
class Page(html.parser.HTMLParser):
    open = []
    def handle_starttag(self, tag, attributes):
        if tag not in ('meta', 'br', 'img'): self.open.append(tag)
    def handle_startendtag(self, tag, attributes): pass
    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag: sys.exit('/%s at %s' % (tag, self.getpos()))
page = Page()
page.feed(open(sys.argv[1], encoding='utf-8').read())
page.close()
sys.exit(' '.join(page.open) or 0)
)";

// The page needs nothing else, has the numbers of result.json with all their digits, and its figures; a second run
// makes the same bytes.
TEST_F(CharacterizeCommand, ThePageHasTheNumbersAndTheFigures) {
  simulate(kSensor + "[defects]\nhot_fraction = 0.001\nhot = \"300 e-\"\n", "truth", 14,
           "nominal = \"nominal.toml\"\n[options]\nnonlinearity = 1\n");
  write_file(scratch / "nominal.toml", replaced(kSensor, "camera\"", "<b>&camera\""));
  const std::string command = "mtf characterize truth_stacks.toml -o camera";
  ASSERT_EQ(scratch.run(command).status, 0);
  const std::string page = read_file(scratch / "camera/report.html");
  write_file(scratch / "well_formed.py", kWellFormed);
  const Result parsed = scratch.run(MTFKIT_PYTHON " well_formed.py camera/report.html");
  EXPECT_EQ(parsed.status, 0) << parsed.err;
  for (const char* const foreign : {"http:", "https:", "<script", "<link", "src=", "url(", "<b>"})
    EXPECT_FALSE(says(page, foreign)) << foreign;
  std::size_t last = 0;
  for (const char* const id : {"summary", "transfer", "response", "snr", "spectra", "time", "profiles", "histograms",
                               "components", "defects", "notes", "provenance"}) {
    const std::size_t at = page.find("<section id=\"" + std::string(id) + "\"");
    ASSERT_NE(at, std::string::npos) << id;
    EXPECT_GT(at, last) << id;
    last = at;
  }
  EXPECT_EQ(count_of(page, "<svg "), 2U + 2U + 1U + 2U + 6U + 4U + 4U + 2U + 1U);
  expect_whole_page(page);
  expect_says(page, {command, "&lt;b&gt;&amp;camera", "flat frames do not tell it"});
  const std::string json = read_file(scratch / "camera/result.json");
  expect_says(page, {Json::parse(json).at("provenance").at("sha256").get<std::string>()});
  EXPECT_EQ(count_of(read_file(scratch / "camera/defects.csv"), "dark signal,"), Json::parse(json).at("defect_count"));
  for (const auto& [name, one] : numbers(json)) {
    const std::size_t row = page.find(">" + name + "</code>"), end = page.find("</tr>", row);
    ASSERT_NE(row, std::string::npos) << name;
    if (one.at("value").is_null()) continue;
    std::vector<double> shown;
    const std::string cells = page.substr(row, end - row);
    const std::regex data("<data value=\"([^\"]*)\"");
    for (auto it = std::sregex_iterator(cells.begin(), cells.end(), data); it != std::sregex_iterator(); ++it)
      shown.push_back(std::stod((*it)[1]));
    std::vector<double> stated{one.at("value").get<double>()};
    if (one.at("sd").is_number()) stated.push_back(one.at("sd").get<double>());
    for (const Json& end95 : one.at("interval95")) stated.push_back(end95.get<double>());
    EXPECT_EQ(shown, stated) << name;
  }
  ASSERT_EQ(scratch.run(command + " --force").status, 0);
  EXPECT_EQ(read_file(scratch / "camera/report.html"), page);
  expect_error(scratch.run("mtf characterize truth_stacks.toml --maps"), 2, {"--maps", "-o FOLDER"});
  EXPECT_FALSE(fs::exists(scratch / "camera/offset.exr"));
}

// With the maps the twin is this very array: frames of it without temporal noise have the pattern of the camera's own.
// Of the variance P, and N left of temporal noise, the correlation is sqrt(P / (P + N)): in the dark, of P = 16 e-^2
// and N = (9 + 2.5^2 / 12) / 9, 0.968; of the response, of 1.2 % and 65 counts of shot noise in 10 frames at 11 000,
// 0.98. The rms is that which was found; the twin's row and column noise is apart.
TEST_F(CharacterizeCommand, MapsMakeTheTwinThisArray) {
  simulate(kSensor, "truth", 15, "nominal = \"nominal.toml\"\n[options]\nnonlinearity = 1\n");
  write_file(scratch / "nominal.toml", kSensor);
  ASSERT_EQ(scratch.run("mtf characterize truth_stacks.toml -o camera --maps").status, 0);
  const std::string twin = read_file(scratch / "camera/sensor.toml");
  expect_says(twin, {"offset = \"offset.exr\"", "responsivity = \"responsivity.exr\""});
  EXPECT_FALSE(says(twin, "prnu") || says(twin, "dsnu") || says(twin, "fixed_column ="));
  EXPECT_EQ(scratch.run("mtf config check camera/sensor.toml").status, 0);
  std::map<std::string, Json> found = numbers(read_file(scratch / "camera/result.json"));
  const auto frame = [&](std::string text, const std::string& name, const std::string& time) {
    for (const auto& [key, line] :
         std::map<std::string, std::string>{{"read_noise", ""},
                                            {"row", "shot = false"},
                                            {"integration_time", "integration_time = \"" + time + "\""},
                                            {"electrons_per_count", "electrons_per_count = \"0.5 e-\""},
                                            {"bits", "bits = 18"}})
      text = std::regex_replace(text, std::regex("\n" + key + " = [^\n]*"), "\n" + line);
    write_file(scratch / (name + ".toml"), text);
    const Result run = scratch.run("mtf simulate " + name + ".toml flat.exr -o frame.exr --quiet");
    EXPECT_EQ(run.status, 0) << run.err;
    return std::move(mtf::io::read_image((scratch / "frame.exr").string()).planes.at(0));
  };
  for (const auto& [name, time, least] : {std::tuple{"dsnu", "0.1 ns", 0.96}, std::tuple{"prnu", "1.02 ms", 0.97}}) {
    const mtf::Image a = frame(read_file(scratch / "truth.toml"), "still", time), b = frame(twin, "camera/still", time);
    const calib::PlaneSquares of_a = calib::plane_squares(a.view()), of_b = calib::plane_squares(b.view());
    double product = 0.0;
    for (std::int64_t y = 0; y < kSide; ++y)
      for (std::int64_t x = 0; x < kSide; ++x)
        product += of_a.deviation(a.view(), x, y) * of_b.deviation(b.view(), x, y) / of_a.pixel_dof;
    EXPECT_GT(product / std::sqrt(of_a.pixel * of_b.pixel), least) << name;
    if (std::string(name) != "dsnu") continue;
    EXPECT_GT(0.5 * std::sqrt(of_b.pixel), found.at(name).at("interval95").at(0).get<double>());
    EXPECT_LT(0.5 * std::sqrt(of_b.pixel), found.at(name).at("interval95").at(1).get<double>());
  }
}

// Edges after the frames: blur and crosstalk are those of the sensor that drew both, weighted by the noise that the
// frames have, which the edges show as well; edges that fail leave what the frames have told.
TEST_F(CharacterizeCommand, EdgesAreFittedByWhatTheFramesTell) {
  simulate(kSensor, "truth", 17, "nominal = \"nominal.toml\"\n[options]\nnonlinearity = 1\n");
  const std::string optics =
      replaced(kSensor, "sample = \"15 um\"", "sample = \"3.75 um\"\naperture = \"box\"") +
      "[[presample]]\nkind = \"footprint\"\nwidth = \"15 um\"\n[[presample]]\nkind = \"jitter\"\nrms = ";
  write_file(scratch / "optics.toml", optics + "\"6 um\"\n");
  write_file(scratch / "nominal.toml", optics + "{ value = \"4 um\", fit = true, min = \"0 um\", max = \"20 um\" }\n");
  for (const bool across : {false, true}) {
    mtf::Image scene(4 * kSide, 4 * kSide);
    for (std::int64_t y = 0; y < scene.height(); ++y)
      for (std::int64_t x = 0; x < scene.width(); ++x) {
        const auto u = static_cast<double>(across ? y : x) - 2.0 * kSide,
                   v = static_cast<double>(across ? x : y) - 2.0 * kSide;
        const double distance = u * std::cos(0.09) + v * std::sin(0.09);
        scene.at(x, y) = static_cast<float>(2e17 + 6e17 * std::clamp(distance + 0.5, 0.0, 1.0));
      }
    mtf::io::write_exr((scratch / "scene.exr").string(), {{"Y", scene.view()}}, {});
    const Result run =
        scratch.run(std::string("mtf simulate optics.toml scene.exr -o ") + (across ? "b.png" : "a.png"));
    ASSERT_EQ(run.status, 0) << run.err;
  }
  const std::string command = "mtf characterize truth_stacks.toml -o camera --force ";
  const Result found = scratch.run(command + "--edges a.png --edges b.png");
  ASSERT_EQ(found.status, 0) << found.err << found.out;
  expect_says(found.err, {"written to camera: sensor.toml, ", "mtf simulate camera/sensor.toml"});
  expect_says(found.out, {"electrons_per_count", "jitter.rms", "shared", "weights the edges"});
  const Json report = Json::parse(read_file(scratch / "camera/result.json")), edges = report.at("edges");
  EXPECT_EQ(edges.at("status"), "converged");
  EXPECT_EQ(edges.at("provenance").at("data").size(), 2U);
  EXPECT_EQ(report.at("provenance").at("nominal"), "nominal.toml");
  const auto near = [](const Json& number, const char* sd, double truth) {
    EXPECT_NEAR(number.at("value").get<double>(), truth, 4.0 * number.at(sd).get<double>()) << number;
    EXPECT_LT(number.at(sd).get<double>(), 0.2 * truth) << number;
  };
  near(edges.at("parameters")[0], "stderr", 6.0);
  near(edges.at("parameters")[1], "stderr", 0.015);
  std::map<std::string, Json> shared;
  for (const Json& one : edges.at("shared")) shared[one.at("name").get<std::string>()] = one;
  const Json& noise = shared.at("noise half way up");
  EXPECT_NEAR(noise.at("edges").at("value").get<double>() / noise.at("frames").at("value").get<double>(), 1.0, 0.06);
  near(shared.at("crosstalk_side").at("frames"), "sd", 0.015);
  const std::string sensor = read_file(scratch / "camera/sensor.toml");
  expect_says(sensor, {"its author's words", "fit = true", "prnu = { value", "kept from the nominal", "nominal.toml"});
  expect_says(read_file(scratch / "camera/report.html"), {"noise half way up", "--edges a.png"});
  EXPECT_EQ(scratch.run("mtf config check camera/sensor.toml").status, 0);

  expect_error(scratch.run(command + "--edges scene.exr"), 2,
               {"scene.exr", "a count of", "numbers of the frames are whole"});
  const Json frames_alone = Json::parse(read_file(scratch / "camera/result.json"));
  EXPECT_FALSE(frames_alone.contains("edges"));
  EXPECT_EQ(frames_alone.at("numbers"), report.at("numbers"));
  write_file(scratch / "nominal.toml", optics + "\"6 um\"\n");
  expect_error(scratch.run(command + "--edges a.png"), 2, {"nothing to fit", "fit = true"});
}

/// A cube of Poisson counts about a mean, which grows by `drift` a frame, as numpy.save writes it.
void write_cube(const fs::path& path, double mean, int frames, unsigned seed, unsigned factor = 1, double drift = 0.0) {
  std::mt19937 engine(seed);
  std::string head = "{'descr': '>u2', 'fortran_order': False, 'shape': (" + std::to_string(frames) + ", 24, 32), }";
  head.resize(117, ' ');
  std::string text = std::string("\x93NUMPY\x01\0", 8) + char(118) + '\0' + head + '\n';
  for (int i = 0; i < frames * 24 * 32; ++i) {
    std::poisson_distribution<int> counts(mean * (1.0 + drift * (i / (24 * 32))));
    const unsigned value = factor * static_cast<unsigned>(std::min(counts(engine), 4095));
    text += static_cast<char>(value >> 8);
    text += static_cast<char>(value & 255U);
  }
  write_file(path, text);
}

TEST(CharacterizeRefusals, BadDescriptorsAndFrames) {
  const Scratch scratch;
  for (unsigned k = 0; k < 4; ++k) write_cube(scratch / ("c" + std::to_string(k) + ".npy"), 100.0 + 300.0 * k, 4, k);
  const auto stack = [](const std::string& file, const std::string& light) {
    return "[[stack]]\nframes = \"" + file + "\"\n" + light + "\n";
  };
  const std::string camera = "[camera]\nbits = 12\n", dark = stack("c0.npy", "light = false"),
                    rest = stack("c1.npy", "relative = 1") + stack("c2.npy", "relative = 2");
  const auto run = [&](const std::string& text) {
    write_file(scratch / "stacks.toml", text);
    return scratch.run("mtf characterize stacks.toml --allow-misfit");
  };
  EXPECT_EQ(run(camera + dark + rest).status, 0);
  expect_error(run(dark + rest), 2, {"bits = 12", "[camera]"});
  expect_error(run(camera), 2, {"stacks.toml", "[[stack]]"});
  expect_error(run(camera + "bitz = 3\n" + dark), 2, {"stacks.toml:3", "bitz"});
  expect_error(run(camera + dark + stack("none/*.png", "relative = 1")), 2, {"stacks.toml:7", "no file"});
  expect_error(run(camera + dark + rest + stack("c1.npy", "relative = 5")), 2, {"c1.npy", "two stacks"});
  expect_error(run(camera + dark + rest + stack("c3.npy", "photons = 5")), 2, {"relative", "in one way"});
  expect_error(run(camera + dark + stack("c1.npy", "")), 2, {"how much light", "photons"});
  expect_error(run(camera + dark + rest + stack("c3.npy", "relative = 0.5")), 2, {"lower mean", "paired wrongly"});
  expect_error(run("[camera]\nbits = 8\n" + dark + rest), 2, {"255", "correct bits"});
  expect_error(run(camera + dark + stack("c1.npy", "relative = 1")), 2, {"2 usable levels", "more exposures"});
  EXPECT_TRUE(says(run("[camera]\nbits = 16\n" + dark + rest).out, "if the converter has fewer"));
  fs::copy_file(scratch / "c1.npy", scratch / "copy.npy");
  expect_error(run(camera + dark + rest + stack("copy.npy", "relative = 3")), 2,
               {"copy.npy", "same frame as", "c1.npy"});
  write_cube(scratch / "full.npy", 4080.0, 24, 8);
  expect_error(run(camera + dark + rest + stack("full.npy", "step = \"20 ms\"")), 2,
               {"error: full.npy: 4", "upper end", "less light"});  // named once
  // One level of several, which von Neumann's ratio of all does not show: without a name it is a misfit.
  write_cube(scratch / "drift.npy", 1000.0, 12, 9, 1, 0.01);
  const std::string drifting =
      camera + dark + rest + stack("c3.npy", "relative = 3") + stack("drift.npy", "relative = 4");
  expect_error(run(drifting), 2, {"drift.npy", "drifts, by 1", "p = ", "warm up", "leave it out"});
  EXPECT_EQ(run("[light]\nrepeatability = 0.05\n" + drifting).status, 0);
  write_cube(scratch / "one.npy", 900.0, 1, 9);
  expect_error(run(camera + dark + rest + stack("one.npy", "relative = 3")), 2, {"one.npy", "two frames"});
  write_cube(scratch / "shifted.npy", 900.0, 4, 9, 16);
  expect_error(run("[camera]\nbits = 16\n" + stack("shifted.npy", "relative = 3")), 2,
               {"multiples of 16", "step = 16"});
  // Two counts as one of 32 bits, from 2^24 to 2^25, where floats are 2 apart.
  write_file(scratch / "high.npy", replaced(replaced(read_file(scratch / "c1.npy"), ">u2", ">u4"), "(4,", "(2,"));
  expect_error(run("[camera]\nbits = 26\n" + stack("high.npy", "relative = 3")), 2,
               {"high.npy", "multiples of 2", "2^24", "subtract a constant"});
  EXPECT_EQ(run("[camera]\nbits = 12\nstep = 16\n" + stack("shifted.npy", "relative = 3")).status, 2);
  const std::string cut = read_file(scratch / "c3.npy");
  write_file(scratch / "cut.npy", cut.substr(0, cut.size() / 2));
  expect_error(run(camera + dark + stack("cut.npy", "relative = 1")), 2, {"cut.npy", "cut off"});
  mtf::Image plane(32, 24), small(8, 8);
  for (std::int64_t i = 0; i < plane.size(); ++i) plane.data()[i] = static_cast<float>(i % 200);
  for (std::int64_t i = 0; i < small.size(); ++i) small.data()[i] = static_cast<float>(i % 9);
  const auto write = [&](const std::string& name, const mtf::Image& image) {
    mtf::io::write_integer((scratch / name).string(), {{"Y", image.view()}}, {1.0, 0.0, 16}, {});
  };
  fs::create_directory(scratch / "mixed");
  write("mixed/a.tif", plane);
  write("mixed/b.tif", small);
  expect_error(run(camera + stack("mixed/*.tif", "relative = 1")), 2, {"mixed/b.tif", "one size"});
  write_file(scratch / "set.txt", "v 3.1\nn 12.7 32 24\n");
  expect_error(scratch.run("mtf characterize set.txt"), 2, {"set.txt:2", "a whole number"});
}

/// The counts of a cube of write_cube() without its header, rows of 32 counts filled up to `columns`.
std::string raw_of(const std::string& cube, std::size_t header, std::size_t columns, bool little) {
  std::string text(header, 'h');
  for (std::size_t at = 128; at < cube.size(); at += 64) {
    for (std::size_t i = at; i < at + 64; i += 2) {
      text += cube[little ? i + 1 : i];
      text += cube[little ? i : i + 1];
    }
    text.append(2 * (columns - 32), '\xff');
  }
  return text;
}

// A dark of one value is no sign of shifted bits; light that gives more electrons than photons is said.
TEST_F(CharacterizeCommand, AConstantDarkAndTooManyElectrons) {
  simulate(replaced(replaced(kSensor, "electrons_per_count = \"2.5 e-\"", "electrons_per_count = \"200 e-\""),
                    "offset = 100.3", "offset = 4.0"),
           "truth", 15, "[camera]\nbits = 14\n");
  const Result dark = scratch.run("mtf characterize truth_stacks.toml --allow-misfit");
  EXPECT_FALSE(says(dark.out + dark.err, "multiples")) << dark.out << dark.err;
  simulate(kSensor, "other", 16, "[camera]\nbits = 14\n");
  const std::string few = read_file(scratch / "other_stacks.toml");
  write_file(scratch / "few.toml", std::regex_replace(few, std::regex("photons = ([0-9.]+)"), "photons = $1e-1"));
  const Result found = scratch.run("mtf characterize few.toml --allow-misfit");
  expect_says(found.out, {"electrons a photon, more than 1"});
}

TEST(CharacterizeRaw, IsReadAsItIsDescribed) {
  const Scratch scratch;
  std::string npy = "[camera]\nbits = 12\n", raw = npy;
  const std::string size = "width = 32, height = 24, type = ";
  for (unsigned k = 0; k < 4; ++k) {
    const std::string name = "c" + std::to_string(k),
                      light = k == 0 ? "light = false\n" : "relative = " + std::to_string(k) + "\n";
    write_cube(scratch / (name + ".npy"), 100.0 + 300.0 * k, 4, k);
    npy += "[[stack]]\nname = \"" + name + "\"\nframes = \"" + name + ".npy\"\n" + light;
    const std::string cube = read_file(scratch / (name + ".npy"));
    std::string frames = name + ".raw",
                layout = size + (k % 2 == 0 ? "'uint16le'" : "'uint16be', header = 7, stride = 70");
    if (k == 2) {  // a file for each frame
      frames = name + "/*.raw";
      fs::create_directory(scratch / name);
      for (std::size_t t = 0; t < 4; ++t)
        write_file(scratch / (name + "/" + std::to_string(t) + ".raw"),
                   raw_of(cube, 0, 32, true).substr(t * 24 * 64, 24 * 64));
    } else {
      write_file(scratch / frames, k == 0 ? raw_of(cube, 0, 32, true) : raw_of(cube, 7, 35, false));
    }
    raw += "[[stack]]\nname = \"" + name + "\"\nframes = \"" + frames + "\"\nraw = { " + layout + " }\n" + light;
  }
  write_file(scratch / "npy.toml", npy);
  write_file(scratch / "raw.toml", raw);
  const Result expected = scratch.run("mtf characterize npy.toml --format json --allow-misfit --threads 1");
  const Result found = scratch.run("mtf characterize raw.toml --format json --allow-misfit --threads 3");
  ASSERT_EQ(found.status, 0) << found.err;
  EXPECT_EQ(Json::parse(found.out).at("numbers"), Json::parse(expected.out).at("numbers"));

  const auto refused = [&](const std::string& from, const std::string& to,
                           std::initializer_list<std::string_view> words) {
    write_file(scratch / "bad.toml", replaced(raw, from, to));
    expect_error(scratch.run("mtf characterize bad.toml"), 2, words);
  };
  refused("'uint16le'", "'uint16be'", {"c0.raw frame 1", "neighbours", "write type", "uint16le"});
  refused("height = 24", "height = 23", {"c0.raw", "6144 bytes", "5888 or 7360", "header = 256"});
  refused("header = 7", "header = 9", {"c1.raw", "no whole number of frames", "header = 7"});
  refused("stride = 70", "stride = 62", {"bad.toml:11", "stride", "take 64"});
  refused("'uint16le'", "'float'", {"bad.toml:6", "float", "uint16be"});
  refused("width = 32, ", "", {"bad.toml:6", "width = 640"});
  refused("width", "wide", {"bad.toml:6", "wide", "width"});
}

TEST(CharacterizeCheck, SaysWhatTheStacksCanDetermine) {
  const Scratch scratch;
  std::string text = "[camera]\nbits = 12\n";
  for (unsigned k = 0; k < 3; ++k) {
    const std::string name = "c" + std::to_string(k);
    write_cube(scratch / (name + ".npy"), 100.0 + 300.0 * k, 3 + static_cast<int>(k), k);
    text += "[[stack]]\nframes = \"" + name + ".npy\"\n" +
            (k == 0 ? "light = false\n" : "relative = " + std::to_string(k) + "\n");
  }
  const auto check = [&](const std::string& stacks, const std::string& more = "") {
    write_file(scratch / "stacks.toml", stacks);
    return scratch.run("mtf characterize check stacks.toml" + more);
  };
  const Result good = check(text);
  ASSERT_EQ(good.status, 0) << good.err;
  expect_says(good.out, {"32 x 24", "dark", "uint16", "0 to 4095", "yes", "two exposures"});
  const Json json = Json::parse(check(text, " --format json").out);
  EXPECT_EQ(json.at("stacks").at(2).at("frames"), 5);
  for (const Json& one : json.at("numbers"))
    EXPECT_EQ(one.at("possible").get<bool>(), one.at("name") != "dark current" && one.at("name") != "lag")
        << one.dump();
  const Result fewer = check(text + "[options]\nnonlinearity = 1\n");
  expect_says(fewer.out, {"3 usable levels of light", "4 are needed", "more exposures"});
  EXPECT_EQ(fewer.status, 2);
  // What a check refuses a run refuses, in the same words.
  const auto refused_by_both = [&](const std::string& stacks, std::initializer_list<std::string_view> words) {
    const Result checked = check(stacks), ran = scratch.run("mtf characterize stacks.toml");
    expect_error(checked, 2, words);
    EXPECT_EQ(ran.status, 2);
    EXPECT_EQ(ran.err, checked.err);
  };
  refused_by_both(text + "[options]\nnonlinearity = 1\n", {"3 usable levels", "nonlinearity = 1"});
  refused_by_both(replaced(text, "bits = 12", "bits = 12\nstep = 32"), {"12 bits", "uint16", "correct bits"});
  mtf::Image small(8, 8);
  std::fill_n(small.data(), small.size(), 3.0F);
  mtf::io::write_integer((scratch / "small.tif").string(), {{"Y", small.view()}}, {1.0, 0.0, 16}, {});
  refused_by_both(replaced(text, "c2.npy", "small.tif"), {"small.tif", "8 x 8", "32 x 24"});
  const std::string raw = "c2.raw\"\nraw = { width = 32, height = 24, type = \"uint8\" }";
  write_file(scratch / "c2.raw", std::string(4 * 32 * 24, 'x'));
  refused_by_both(replaced(text, "c2.npy\"", raw), {"c2.raw", "of uint8", "of uint16"});
  refused_by_both("[camera]\nbits = 12\n[[stack]]\nlight = false\nframes = \"" + raw + "\n",
                  {"12 bits", "uint8", "correct bits"});
  write_cube(scratch / "c1.npy", 100.0, 1, 9);
  refused_by_both(text, {"c1.npy", "single frame"});
  expect_error(scratch.run("mtf characterize check none.toml"), 1, {"none.toml"});
  expect_error(scratch.run("mtf characterize"), 2, {"file that describes the stacks"});
}

}  // namespace
}  // namespace apps_test
