// SPDX-License-Identifier: Apache-2.0
// `mtf render` and the line that it prints for `mtf simulate`.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "command.h"
#include "mtf/io/image_io.h"
#include "plates_case.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

const std::string kScene =
    place_and_weather("start = 2026-06-21T12:00:00Z\nend = 2026-06-22T12:00:00Z\nstep = \"2 h\"\n") +
    soil_and_target("", "temperature = \"310 K\"\n") +
    R"([camera]
position = ["3 m", "-40 m", "4 m"]
look_at = ["0 m", "0 m", "0.6 m"]
)";
const std::string kSensor = uncooled("[scene]\nquantity = \"temperature\"\n");
const std::string kAir = R"([atmosphere]
pressure = "1013 hPa"
temperature = "288 K"
relative_humidity = 0.5
range = "1 km"
)";

class RenderCommand : public testing::Test {
 protected:
  RenderCommand() {
    write_file(scratch_ / "scene.toml", kScene);
    write_file(scratch_ / "plates.obj", kGroundAndTarget);
    write_file(scratch_ / "sensor.toml", kSensor);
    write_file(scratch_ / "airy.toml", kSensor + kAir);
  }
  Scratch scratch_;
};

/// The command after "next: ".
std::string next(const std::string& text) {
  const auto from = text.find("next: ");
  return from == std::string::npos ? "false" : text.substr(from + 6);
}

TEST_F(RenderCommand, SaysACommandThatWorks) {
  for (const std::string sensor : {"sensor.toml", "airy.toml"}) {
    const Result made = scratch_.run("mtf render scene.toml " + sensor + " -o scene.exr");
    ASSERT_EQ(made.status, 0) << made.err;
    const Result then = scratch_.run(next(made.out));
    EXPECT_EQ(then.status, 0) << then.err;
    EXPECT_FALSE(says(then.err, "says quantity")) << then.err;
  }
  expect_error(scratch_.run("mtf simulate airy.toml scene.exr -o image.exr"), 2, {"--without-path"});
}

TEST_F(RenderCommand, SaysWhatItsSamplesLose) {
  const Result fine = scratch_.run("mtf render scene.toml sensor.toml --samples-per-pitch 4 -o scene.exr");
  expect_says(fine.out, {"the sensor's MTF is "});
  EXPECT_FALSE(says(fine.err, "false detail")) << fine.err;
  const Result coarse = scratch_.run("mtf render scene.toml sensor.toml --samples-per-pitch 1 -o scene.exr");
  expect_says(coarse.err, {"shows as false detail"});
}

// Pixels far apart pass detail that two samples a pitch do not hold: without an option there are as many as it takes.
TEST_F(RenderCommand, TakesTheSamplesThatTheSensorAsksFor) {
  write_file(scratch_ / "sparse.toml", replaced(replaced(kSensor, "12 um", "24 um"), "0.85", "0.3"));
  for (const auto& [sensor, samples] : {std::pair{"sensor", 2.0}, {"sparse", 3.0}}) {
    const std::string files = std::string("scene.toml ") + sensor + ".toml";
    const Result made = scratch_.run("mtf render " + files + " --format json -o scene.exr");
    ASSERT_EQ(made.status, 0) << made.err;
    EXPECT_FALSE(says(made.err, "false detail")) << made.err;
    EXPECT_EQ(nlohmann::json::parse(made.out).at("samples_per_pitch"), samples);
    EXPECT_EQ(mtf::io::read_info((scratch_ / "scene.exr").string()).width, 64 * static_cast<int>(samples));
    const Result flown = scratch_.run("mtf fly " + files + " --frames 0:0 --format json");
    ASSERT_EQ(flown.status, 0) << flown.err;
    EXPECT_EQ(nlohmann::json::parse(flown.out).at("samples_per_pitch"), samples);
  }
  expect_says(scratch_.run("mtf render scene.toml sparse.toml --samples-per-pitch 2 -o scene.exr").err,
              {"shows as false detail"});
}

TEST_F(RenderCommand, ColdSidesAreWarnedOf) {
  std::string text = kScene;
  text = replaced(text, "310 K", "37 K");
  write_file(scratch_ / "scene.toml", text);
  const Result made = scratch_.run("mtf render scene.toml sensor.toml -o scene.exr");
  expect_says(made.err, {"37 K", "Celsius"});
}

TEST_F(RenderCommand, TheSceneExplainsTheSkyThatPicturesHave) {
  write_file(scratch_ / "scene.toml", kScene + "[atmosphere]\nmodel = \"mid_latitude_summer\"\n");
  const Result made = scratch_.run("mtf render scene.toml sensor.toml -o scene.exr --format json");
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string sky = nlohmann::json::parse(made.out).at("closures").at("sky");
  expect_says(sky, {"clear sky"});
  const Result explained = scratch_.run("mtf scene explain scene.toml");
  expect_says(explained.out, {"sky: " + sky});
}

// The air of a scene file is said to be beyond its model as that of a sensor file is.
TEST_F(RenderCommand, TheAirOfASceneSaysWhatItsModelIsNotGoodFor) {
  std::string text = kScene + "[atmosphere]\nmodel = \"mid_latitude_summer\"\n";
  write_file(scratch_ / "scene.toml", text);
  EXPECT_EQ(scratch_.run("mtf render scene.toml sensor.toml -o scene.exr").err, "");
  text.replace(text.find("288 K"), 5, "335 K").replace(text.find("10 hPa"), 6, "115 hPa");
  write_file(scratch_ / "scene.toml", text);
  for (const char* command :
       {"mtf render scene.toml sensor.toml -o hot.exr",
        "mtf fly scene.toml sensor.toml --time 2026-06-21T12:00:00Z --seconds 0.1 -o f.%04d.exr"}) {
    const Result hot = scratch_.run(command);
    EXPECT_EQ(hot.status, 0) << hot.err;
    expect_says(hot.err, {"[atmosphere]", "220 to 310 K", "335 K", "at 0 m", "45 g/m3"});
  }
}

TEST_F(RenderCommand, RefusesACameraBesideTheFacetsAndBelowThem) {
  expect_error(scratch_.run("mtf render scene.toml sensor.toml --position 3,-40,-4 -o scene.exr"), 2,
               {"below the ground"});
}

/// A cooled camera with the field of view of kSensor.
const std::string kCooled = R"(schema = 1
name = "cooled"
[frame]
focal_length = "25 mm"
pitch = "24 um"
format = [64, 48]
integration_time = "8 ms"
[optics]
f_number = 4.0
stop_temperature = "77 K"
[band]
wavelength = ["3.7 um", "4.8 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.85
[detector]
quantum_efficiency = 0.8
full_well = "7 Me-"
[adc]
bits = 14
)";

mtf::Image plane(const Scratch& scratch, const std::string& file, const std::string& name) {
  return std::move(mtf::io::read_image((scratch / file).string(), {name, {}, {}}).planes.front());
}
double largest_difference(const mtf::Image& a, const mtf::Image& b) {
  double most = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i)
    most = std::max(most, static_cast<double>(std::abs(a.data()[i] - b.data()[i])));
  return most;
}

TEST_F(RenderCommand, SensorsOfOneViewShareTheRaysAndHaveThePicturesThatTheyHaveAlone) {
  write_file(scratch_ / "cooled.toml", kCooled);
  const Result made = scratch_.run(
      "mtf render scene.toml sensor.toml cooled.toml --points 1 --layer surface --layer Z -o both --picture "
      "both/both.png");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(std::filesystem::exists(scratch_ / "both/both.png"));
  for (const std::string sensor : {"sensor", "cooled"}) {
    ASSERT_EQ(
        scratch_
            .run("mtf render scene.toml " + sensor + ".toml --points 1 --layer surface --layer Z -o " + sensor + ".exr")
            .status,
        0);
    const std::string alone = sensor + ".exr", together = "both/" + alone;
    for (const std::string name : {"Y", "surface", "Z"})
      EXPECT_EQ(largest_difference(plane(scratch_, together, name), plane(scratch_, alone, name)), 0.0)
          << sensor << " " << name;
  }
  std::string commands = made.out.substr(made.out.find("next: "));
  for (std::size_t at; (at = commands.find("next: ")) != std::string::npos;) commands.erase(at, 6);
  const Result then = scratch_.run("set -e\n" + commands);
  EXPECT_EQ(then.status, 0) << then.err;
  EXPECT_TRUE(std::filesystem::exists(scratch_ / "both/cooled_image.exr"));
}

TEST_F(RenderCommand, SensorsOfOnePictureHaveOneView) {
  std::string wide = kCooled;
  wide = replaced(wide, "25 mm", "26 mm");
  write_file(scratch_ / "wide.toml", wide);
  expect_error(scratch_.run("mtf render scene.toml sensor.toml wide.toml -o both"), 2, {"same field of view"});
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "both"));
  const Result airy = scratch_.run("mtf render scene.toml sensor.toml airy.toml -o both");
  expect_says(airy.err, {"see through one air"});
  const Result file = scratch_.run("mtf render scene.toml sensor.toml wide.toml -o both.exr");
  expect_says(file.err, {"folder"});
}

TEST_F(RenderCommand, SolvesTheTemperaturesThatTheHeatBalanceHas) {
  std::string text = kScene;
  for (const std::string line : {"temperature = \"290 K\"\n", "temperature = \"310 K\"\n"})
    text.replace(text.find(line), line.size(), "material = \"steel\"\n");
  write_file(scratch_ / "scene.toml", text + R"([[material]]
name = "steel"
solar_absorptance = 0.7
emissivity = 0.9
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "5 mm" }]
)");
  const std::string rest = " --time 2026-06-21T15:00:00Z --layer temperature -o ";
  ASSERT_EQ(scratch_.run("mtf heat scene.toml -o heat").status, 0);
  ASSERT_EQ(scratch_.run("mtf render scene.toml sensor.toml --temperatures heat" + rest + "a.exr").status, 0);
  const Result solved = scratch_.run("mtf render scene.toml sensor.toml --heat" + rest + "b.exr");
  ASSERT_EQ(solved.status, 0) << solved.err;
  const mtf::Image a = plane(scratch_, "a.exr", "temperature"), b = plane(scratch_, "b.exr", "temperature");
  for (const auto& [x, y] : {std::pair{64, 60}, {64, 45}}) {
    const float k = a.at(x, y);
    EXPECT_GT(k, 280.0F);
    // The weather is constant but for the sun's height; runs of other lengths choose other steps within 1 K.
    EXPECT_NEAR(b.at(x, y), k, 0.3F);
  }
  const Result late = scratch_.run("mtf render scene.toml sensor.toml --heat --time 2026-06-29T00:00:00Z -o c.exr");
  expect_says(late.err, {"outside of the run"});
}

/// Of our own layers, black surfaces have the radiance again that they were rendered with.
TEST_F(RenderCommand, LayersOfItsOwnGiveTheSamePicture) {
  std::string text = kScene;
  for (const std::string name : {"soil", "target"}) {
    const std::string line = "group = \"" + name + "\"\n";
    text.insert(text.find(line) + line.size(), "material = \"" + name + "\"\n");
    text += "[[material]]\nname = \"" + name + "\"\n" + R"(solar_absorptance = 1.0
emissivity = 1.0
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "5 mm" }]
)";
  }
  write_file(scratch_ / "scene.toml", text + "[atmosphere]\nmodel = \"mid_latitude_summer\"\n");
  ASSERT_EQ(
      scratch_
          .run("mtf render scene.toml sensor.toml --points 1 --layer Z --layer material --layer temperature -o a.exr")
          .status,
      0);
  const Result again = scratch_.run("mtf render scene.toml sensor.toml --from a.exr -o b.exr");
  ASSERT_EQ(again.status, 0) << again.err;
  const mtf::Image a = plane(scratch_, "a.exr", "Y"), b = plane(scratch_, "b.exr", "Y");
  for (std::int64_t i = 0; i < a.size(); ++i) ASSERT_NEAR(b.data()[i] / a.data()[i], 1.0F, 1e-5F) << i;
  EXPECT_EQ(scratch_.run(next(again.out)).status, 0);
  const Result other = scratch_.run("mtf render scene.toml sensor.toml --from a.exr --channel depth=Depth -o c.exr");
  expect_says(other.err, {"no such channel"});
  expect_error(scratch_.run("mtf render scene.toml sensor.toml --depth planar -o c.exr"), 2, {"--depth"});
  write_file(scratch_ / "scene.toml", replaced(text, "emissivity = 1.0\n", "emissivity = 1.0\ngloss = 0.5\n"));
  expect_says(scratch_.run("mtf render scene.toml sensor.toml --from a.exr -o c.exr").err,
              {"a.exr has no normals", "drawn matt", "add the channels normal.X"});
}

/// The layers of the script are those of a ball in closed form: its silhouette and its warm top.
TEST_F(RenderCommand, TakesLayersOfOtherRenderers) {
  ASSERT_EQ(
      scratch_
          .run(MTFKIT_PYTHON " '" MTFKIT_SOURCE_DIR
                             "/notebooks-data/layers/make_layers.py' ball.exr --width 128 --height 96 --step 4.8e-4")
          .status,
      0);
  const std::string scene = kScene + R"([[material]]
name = "paint"
solar_absorptance = 0.7
emissivity = 0.9
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "5 mm" }]
)";
  write_file(scratch_ / "scene.toml", scene);
  write_file(scratch_ / "materials.csv", "index,material,temperature_K\n1,paint,285\n2,paint,\n");
  const std::string command =
      "mtf render scene.toml sensor.toml --from ball.exr --materials materials.csv --position 0,-40,6 --look-at 0,0,1 "
      "-o ";
  const Result made = scratch_.run(command + "a.exr");
  ASSERT_EQ(made.status, 0) << made.err;
  const mtf::Image image = plane(scratch_, "a.exr", "Y");
  std::int64_t warm = 0;
  for (std::int64_t i = 0; i < image.size(); ++i) warm += image.data()[i] > image.at(64, 94) * 1.02F ? 1 : 0;
  EXPECT_GT(warm, 3000);  // a ball of 1 m at 40.3 m: pi (1 / (40.3 x 4.8e-4))^2 = 8395 samples, most of them warmer
  EXPECT_LT(warm, 8500);
  EXPECT_EQ(scratch_.run(next(made.out)).status, 0);
  EXPECT_FALSE(says(made.err, "glossy")) << made.err;
  write_file(scratch_ / "scene.toml", replaced(scene, "emissivity = 0.9\n", "emissivity = 0.9\ngloss = 0.5\n"));
  expect_says(scratch_.run(command + "b.exr").err, {"glossy materials, which mirror sky and ground alone"});
  write_file(scratch_ / "materials.csv", "index,material\n1,paint\n2,wood\n");
  expect_says(scratch_.run(command + "b.exr").err, {"has no [[material]]"});
  write_file(scratch_ / "materials.csv", "index,material,temperature_K\n1,paint,285\n");
  expect_says(scratch_.run(command + "b.exr").err, {"is not in materials.csv"});
}

/// More points bring samples nearer to the mean over them, tables keep what they promise.
TEST_F(RenderCommand, TheBenchSaysErrorAgainstTime) {
  write_file(scratch_ / "scene.toml", kScene + "[atmosphere]\nmodel = \"mid_latitude_summer\"\n");
  const Result made = scratch_.run("mtf bench scene.toml sensor.toml --rounds 1 -o bench --format json");
  ASSERT_EQ(made.status, 0) << made.err;
  const auto rows = nlohmann::json::parse(made.out).at("rows");
  ASSERT_EQ(rows.size(), 7U);
  double one = 0.0, four = 0.0, sixteen = 0.0;
  for (const auto& row : rows) {
    EXPECT_LE(row.at("tables_error"), row.at("promised"));
    EXPECT_GT(row.at("promised"), 0.0);
    EXPECT_GT(row.at("time_ms_min"), 0.0);
    (row.at("points_a_sample") == 1 ? one : row.at("points_a_sample") == 4 ? four : sixteen) = row.at("sampling_rms");
  }
  EXPECT_LT(four, 0.8 * one);
  EXPECT_LT(sixteen, 0.75 * four);
  EXPECT_TRUE(read_file(scratch_ / "bench/render_bench.csv").starts_with("points_a_sample,tolerance,promised"));
  EXPECT_EQ(scratch_.run("mtf bench sensor.toml scene.exr --position 1,2,3 -o other").status, 2);
}

#if MTFKIT_HAVE_CALIB
// The blur that samples have from their points is what mtf:aperture says and mtf simulate takes off: the MTF of the
// edge of a plate is that of the sensor. At an edge a sample is one of 1, 5 or 17 values, which counts as noise; the
// last bar is two of the deviations that the measurement states, which allow for light that is scattered far.
TEST_F(RenderCommand, TheEdgeOfAPlateHasTheMtfOfTheSensor) {
  const double slope = std::tan(5.0 * std::numbers::pi / 180.0);
  std::ostringstream plates;
  plates << "v -20 2 -20\nv 20 2 -20\nv 20 2 20\nv -20 2 20\nv -20 0 -20\nv " << -20.0 * slope << " 0 -20\nv "
         << 20.0 * slope << " 0 20\nv -20 0 20\ng soil\nf 1 2 3 4\ng target\nf 5 6 7 8\n";
  write_file(scratch_ / "plates.obj", plates.str());
  write_file(scratch_ / "scene.toml", kScene.substr(0, kScene.find("[camera]")) +
                                          "[camera]\nposition = [\"0 m\", \"-100 m\", \"0 m\"]\n"
                                          "look_at = [\"0 m\", \"0 m\", \"0 m\"]\n");
  std::string sensor = kSensor.substr(0, kSensor.find("[adc]"));
  sensor = replaced(sensor, "format = [64, 48]", "format = [128, 128]");
  sensor = replaced(sensor, "12.5 mm", "50 mm");
  write_file(scratch_ / "sensor.toml", sensor);
  const Result curve = scratch_.run("mtf curve sensor.toml --unit cy/px --freq 0.1,0.25,0.5 --angle 5 --format json");
  ASSERT_EQ(curve.status, 0) << curve.err;
  const nlohmann::json system = nlohmann::json::parse(curve.out).at("system");
  for (const auto& [points, most] : {std::pair{1, 0.004}, {4, 0.008}, {16, 0.003}}) {
    const Result made =
        scratch_.run("mtf render scene.toml sensor.toml --points " + std::to_string(points) +
                     " -o scene.exr && mtf simulate sensor.toml scene.exr --tolerance 1e-5 -o image.exr");
    ASSERT_EQ(made.status, 0) << made.err;
    const auto mtf =
        nlohmann::json::parse(scratch_.run("mtf measure image.exr --format json").out).at("edges")[0].at("mtf");
    const std::vector<double> frequency = mtf.at("frequency"), value = mtf.at("value");
    std::size_t k = 0;
    for (const double wanted : {0.1, 0.25, 0.5}) {
      const auto at = std::find(frequency.begin(), frequency.end(), wanted) - frequency.begin();
      ASSERT_LT(at, std::ssize(value));
      EXPECT_NEAR(value[static_cast<std::size_t>(at)], system.at("re")[k++].get<double>(), most)
          << points << " " << wanted;
    }
  }
}
#endif

}  // namespace
}  // namespace apps_test
