// SPDX-License-Identifier: Apache-2.0
// From scene and sensor files to pictures, and from pictures to counts: what `mtf budget` says of a plate at 1 km is
// measured in rendered frames.

#include "apps/scene/render/sensor_picture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "apps/scene/outputs/npy_file.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/simulate/simulate.h"
#include "tests/apps/plates_case.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
namespace render = radiometry::render;

const std::string kScene = R"(schema = 1
[place]
latitude = "40 deg"
longitude = "0 deg"
altitude = "0 m"
[time]
start = 2026-06-21T00:00:00Z
end = 2026-06-22T00:00:00Z
step = "2 h"
[weather]
air_temperature = "295 K"
wind_speed = "2 m/s"
direct_normal = "0 W/m2"
diffuse_horizontal = "0 W/m2"
longwave_down = "320 W/m2"
[[mesh]]
name = "plates"
file = "plates.obj"
[[region]]
mesh = "plates"
group = "left"
temperature = "300 K"
[[region]]
mesh = "plates"
group = "right"
temperature = "300.1 K"
[camera]
position = ["0 m", "0 m", "20 m"]
look_at = ["1000 m", "0 m", "20 m"]
)";
// Two black walls at 1 km to the east, that face west; the left one is to the north.
const std::string kPlates =
    "v 1000 0 0\nv 1000 60 0\nv 1000 60 40\nv 1000 0 40\nv 1000 -60 0\nv 1000 -60 40\n"
    "g left\nf 1 4 3 2\ng right\nf 5 6 4 1\n";

const std::string kCooled = R"(schema = 1
name = "cooled"
[frame]
focal_length = "150 mm"
pitch = "15 um"
format = [128, 128]
integration_time = "8 ms"
[optics]
f_number = 4.0
transmission = 0.85
emissivity = 0.1
temperature = "293 K"
stop_temperature = "77 K"
[band]
wavelength = ["3.7 um", "4.8 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.9
[detector]
quantum_efficiency = "qe.csv"
full_well = "7 Me-"
read_noise = "400 e-"
[adc]
bits = 14
[noise]
seed = 1
)";
const std::string kUncooled =
    replaced(replaced(replaced(apps_test::uncooled(""), "12.5 mm", "150 mm"), "[64, 48]", "[128, 128]"),
             "f_number = 1.2", "f_number = 1.2\ntransmission = 0.85") +
    "[noise]\nseed = 1\n";
const std::string kAir = R"([atmosphere]
pressure = "1013 hPa"
temperature = "295 K"
relative_humidity = 0.5
range = "1 km"
)";

class Picture : public testing::Test {
 protected:
  Picture() : folder_(fs::temp_directory_path() / ("mtfkit_picture_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    write("scene.toml", kScene);
    write("plates.obj", kPlates);
    write("qe.csv", "wavelength_um,quantum_efficiency\n3.5,0.6\n4.2,0.85\n5.0,0.5\n");
  }
  ~Picture() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  mtf::io::SensorConfig sensor(const std::string& text) const {
    write("sensor.toml", text);
    return read_sensor_file(path("sensor.toml"));
  }
  /// The picture of the scene with the air of the sensor file, as a file.
  std::string picture(const std::string& text, PictureQuantity quantity = PictureQuantity::weighted,
                      const std::string& name = "scene.exr") const {
    const SceneFile file = load_scene(path("scene.toml"));
    const PictureSensor with = picture_sensor(sensor(text), quantity);
    const PictureScene scene = read_picture_scene(file, {.sensor_air = with.air, .sensor_file = "sensor.toml"});
    const render::Camera camera = picture_camera(with, pose_of(file), 2.0);
    const render::RenderOptions options;
    render::Renderer renderer(scene.scene, {with.band}, options);
    const render::RenderedFrame frame = renderer.render(camera);
    mtf::io::write_exr(path(name), picture_planes(frame), picture_metadata(file, scene, with, camera, options, frame));
    return path(name);
  }

 private:
  fs::path folder_;
};

double mean_of(const mtf::Image& image, std::int64_t from, std::int64_t to) {
  double sum = 0.0;
  for (std::int64_t y = 8; y < image.height() - 8; ++y)
    for (std::int64_t x = from; x < to; ++x) sum += static_cast<double>(image.at(x, y));
  return sum / static_cast<double>((image.height() - 16) * (to - from));
}

class Cameras : public Picture, public testing::WithParamInterface<int> {
 protected:
  std::string camera() const { return GetParam() == 0 ? kCooled : kUncooled; }
};

TEST_P(Cameras, SeeTheDifferenceThatTheBudgetSays) {
  const std::string scene = picture(camera() + kAir);
  const mtf::io::SensorConfig with_air = sensor(camera() + kAir);
  const radiometry::Budget<double> budget = budget_of(with_air.system, load_chain(with_air).sensor, 300.0);
  std::string quiet = camera();
  quiet.erase(quiet.find("[noise]"));
  const SimulateResult result =
      simulate(sensor(quiet), {.file = scene},
               {.tolerance = 1e-3,
                .stage = GetParam() == 0 ? radiometry::OutputStage::electrons : radiometry::OutputStage::volts});
  const mtf::Image& image = result.images.front().planes.front();
  const double measured = mean_of(image, 76, 124) - mean_of(image, 4, 52);
  // The far tails of diffraction take 0.4 % of the difference across the edge.
  EXPECT_NEAR(measured / (0.1 * budget.signal_per_k), 1.0, 0.01);
}

TEST_P(Cameras, HaveTheNoiseThatTheBudgetSays) {
  const std::string scene = picture(camera() + kAir);
  const mtf::io::SensorConfig with_air = sensor(camera() + kAir);
  const LoadedSensor loaded = load_chain(with_air);
  const radiometry::Budget<double> budget = budget_of(with_air.system, loaded.sensor, 300.0);
  const SimulateResult result = simulate(sensor(camera()), {.file = scene}, {.frames = FrameRange{0, 1, 1}});
  const mtf::Image &a = result.images[0].planes.front(), &b = result.images[1].planes.front();
  double square = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i) square += std::pow(static_cast<double>(a.data()[i] - b.data()[i]), 2);
  const double counts = std::sqrt(0.5 * square / static_cast<double>(a.size()));
  const double netd_k = counts * adc_of(loaded.sensor).electrons_per_count / budget.signal_per_k;
  std::printf("NETD %.2f mK in frames, %.2f mK in the budget\n", 1e3 * netd_k, 1e3 * budget.netd_k);
  EXPECT_NEAR(netd_k / budget.netd_k, 1.0, 0.02);  // 16384 differences: 0.6 %
}
INSTANTIATE_TEST_SUITE_P(Kinds, Cameras, testing::Values(0, 1));

std::string refusal(const auto& action) { return message_of(action); }

TEST_F(Picture, BelongsToOneResponse) {
  const std::string scene = picture(kCooled + kAir);
  std::string other = kCooled;
  other = replaced(other, "3.7 um", "3.6 um");
  expect_says(refusal([&] { simulate(sensor(other), {.file = scene}); }), {"another response"});
  expect_says(refusal([&] { simulate(sensor(kUncooled), {.file = scene}); }), {"photon detectors"});
  // What is no curve may change.
  std::string faster = kCooled;
  faster = replaced(faster, "f_number = 4.0", "f_number = 3.0");
  EXPECT_EQ(refusal([&] { simulate(sensor(faster), {.file = scene}); }), "");
}

TEST_F(Picture, HasItsAirOnce) {
  const std::string scene = picture(kCooled + kAir);
  expect_says(refusal([&] { simulate(sensor(kCooled + kAir), {.file = scene}); }), {"count twice"});
  expect_says(refusal([&] { simulate(sensor(kCooled + "[path]\ntransmission = 0.7\n"), {.file = scene}); }),
              {"count twice"});
  write("scene.toml", kScene + "[atmosphere]\nmodel = \"mid_latitude_summer\"\n");
  expect_says(refusal([&] { picture(kCooled + kAir); }), {"both have [atmosphere]"});
  // Without air the sensor's own path is taken, once: the same light as with it in the picture.
  write("scene.toml", kScene);
  const std::string bare = picture(kCooled, PictureQuantity::weighted, "bare.exr");
  std::string quiet = kCooled;
  quiet.erase(quiet.find("[noise]"));
  const auto electrons = radiometry::OutputStage::electrons;
  const SimulateResult with = simulate(sensor(quiet), {.file = scene}, {.tolerance = 1e-3, .stage = electrons});
  const SimulateResult later = simulate(sensor(quiet + kAir), {.file = bare}, {.tolerance = 1e-3, .stage = electrons});
  EXPECT_NEAR(mean_of(with.images[0].planes[0], 4, 52) / mean_of(later.images[0].planes[0], 4, 52), 1.0, 2e-3);
}

TEST_F(Picture, OfPlainRadianceSuitsAnySensor) {
  const std::string scene = picture(kCooled + kAir, PictureQuantity::radiance);
  const mtf::io::FileInfo info = mtf::io::read_info(scene);
  EXPECT_EQ(info.attributes.at("mtf:quantity"), "radiance");
  EXPECT_FALSE(info.attributes.contains("mtf:response"));
  EXPECT_EQ(refusal([&] { simulate(sensor(kCooled), {.file = scene}); }), "");
}

TEST_F(Picture, SaysWhichRegionsHaveNoTemperature) {
  std::string text = kScene;
  for (const std::string line : {"temperature = \"300 K\"\n", "temperature = \"300.1 K\"\n"})
    text.replace(text.find(line), line.size(), "material = \"steel\"\n");
  text += R"([[material]]
name = "steel"
solar_absorptance = 0.7
emissivity = 0.9
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "5 mm" }]
)";
  write("scene.toml", text);
  const SceneFile file = load_scene(path("scene.toml"));
  const std::string said = refusal([&] { read_picture_scene(file, {}); });
  expect_says(said, {"'left', 'right'"});

  // A folder as `mtf heat` writes it.
  fs::create_directories(path("out"));
  write("out/times.csv", "output,time,time_s\n0,2026-06-21T00:00:00Z,0\n1,2026-06-21T02:00:00Z,7200\n");
  NpyFile table(path("out") + "/temperatures.npy", 2);
  table.append(std::vector<float>{300.0F, 310.0F});
  table.append(std::vector<float>{304.0F, 318.0F});
  table.commit();
  const double start = file.time.start_s;
  const PictureScene scene = read_picture_scene(file, {.temperatures = path("out"), .utc_s = start + 1800.0});
  EXPECT_FLOAT_EQ(scene.scene.temperature_k[0], 301.0F);
  EXPECT_FLOAT_EQ(scene.scene.temperature_k[2], 312.0F);
  EXPECT_EQ(read_picture_scene(file, {.temperatures = path("out")}).utc_s, start + 7200.0);
  const std::string late =
      refusal([&] { read_picture_scene(file, {.temperatures = path("out"), .utc_s = start + 7201.0}); });
  expect_says(late, {"outside of the temperatures"});
  NpyFile three(path("out") + "/temperatures.npy", 3);
  three.append(std::vector<float>{300.0F, 310.0F, 320.0F});
  three.append(std::vector<float>{300.0F, 310.0F, 320.0F});
  three.commit();
  expect_says(refusal([&] { read_picture_scene(file, {.temperatures = path("out")}); }), {"3 facets, the scene 2"});
}

// From a folder, from its table, and from a region that names the table: the lines between the rows about each time,
// whichever was asked for before; nothing beyond.
TEST_F(Picture, HasTheTemperaturesOfItsTime) {
  fs::create_directories(path("out"));
  std::string times = "output,time,time_s\n";
  NpyFile table(path("out") + "/temperatures.npy", 2);
  const auto left_k = [](double hours) { return 300.0 + 10.0 * hours * hours; };
  for (int hour = 0; hour < 6; ++hour) {
    times += std::to_string(hour) + ",2026-06-21T0" + std::to_string(hour) + ":00:00Z,0\n";
    table.append(std::vector{static_cast<float>(left_k(hour)), 290.0F});
  }
  table.commit();
  write("out/times.csv", times);
  const std::string given = "temperature = \"300 K\"";
  for (const std::string& from : {path("out"), path("out/temperatures.npy"), std::string()}) {
    std::string text = kScene;
    if (from.empty()) text = replaced(text, given, "temperature = \"out/temperatures.npy\"");
    write("scene.toml", text);
    const SceneFile file = load_scene(path("scene.toml"));
    const double start = file.time.start_s;
    PictureSource source(file, {.temperatures = from});
    EXPECT_TRUE(source.temperatures_change());
    EXPECT_EQ(source.temperatures_span_utc_s(), (std::array{start, start + 5.0 * 3600.0}));
    std::vector<float> kelvin;
    for (const double hour : {4.75, 0.0, 5.0, 1.5, 2.0, 4.75}) {
      source.temperatures(start + 3600.0 * hour, kelvin);
      const double before = std::min(std::floor(hour), 4.0);
      EXPECT_NEAR(kelvin[0], std::lerp(left_k(before), left_k(before + 1.0), hour - before), 3e-5) << from << hour;
      EXPECT_EQ(kelvin[1], kelvin[0]);
    }
    for (const double late_s : {-1.0, 5.0 * 3600.0 + 1.0}) {
      const std::initializer_list<std::string_view> parts = {"out", "2026-06-21T05:00:00Z", "choose a time"};
      expect_refused(parts, [&] { source.require_temperatures_at(start + late_s); });
      expect_refused(parts, [&] { source.temperatures(start + late_s, kelvin); });
    }
  }
}

class PictureWarnings : public Picture {
 protected:
  /// Of the scene at noon with a change, in the band from 8 to 12 um.
  PictureScene scene(const std::string& from, const std::string& to, const std::string& more = "") const {
    write("scene.toml", replaced(kScene, from, to) + more);
    const SceneFile file = load_scene(path("scene.toml"));
    PictureScene made = read_picture_scene(file, {.utc_s = file.time.start_s + 43200.0});
    add_band_limits(file, {8.0, 12.0}, made);
    return made;
  }
  static std::string all(const PictureScene& of) {
    std::string text;
    for (const std::string& one : of.warnings) text += one;
    return text;
  }
};

TEST_F(PictureWarnings, ValuesThatAreHeld) {
  const std::string given = "temperature = \"300 K\"";
  write("day.csv", "time,left (K)\n2025-06-21T06:00:00Z,300\n2025-06-21T07:00:00Z,310\n");
  expect_says(all(scene(given, "temperature = \"day.csv\"")), {"day.csv: beyond its samples", "2026-06-21T12:00:00Z"});
  const std::string paint =
      "[[material]]\nname = \"paint\"\nsolar_absorptance = 0.5\nemissivity = \"paint.csv\"\n"
      "layers = [{ conductivity = \"1 W/m/K\", density = \"1 g/cm3\", heat_capacity = \"1 kJ/kg/K\", thickness = "
      "\"1 mm\" }]\n";
  write("paint.csv", "wavelength_um,emissivity\n3,0.1\n5,0.2\n");
  expect_says(all(scene(given, given + "\nmaterial = \"paint\"", paint)),
              {"paint.csv: the emissivity ends inside the band", "3 um to 5 um, the band is 8 um to 12 um"});
  write("paint.csv", "wavelength_um,emissivity\n8,0.1\n12,0.2\n");
  EXPECT_EQ(all(scene(given, given + "\nmaterial = \"paint\"", paint)), "");
}

// A beam of 800 W/m2 and fog that lets one see 200 m: at the zenith angle of 17 deg and 1 km of fog its optical depth
// is 19 in the visible, so that at most what the sun has beyond 3 um comes through, 2 % of 1361 W/m2. In haze of 23 km
// such a beam is what it is.
TEST_F(PictureWarnings, SunThatTheAirDoesNotLetThrough) {
  const auto with = [&](const std::string& haze) {
    return scene("direct_normal = \"0 W/m2\"", "direct_normal = \"800 W/m2\"\nvapour_pressure = \"10 hPa\"",
                 "[atmosphere]\nmodel = \"mid_latitude_summer\"\n" + haze);
  };
  const PictureScene fog = with("haze = \"radiation_fog\"\nvisibility = \"200 m\"\n");
  expect_says(all(fog), {"the sun: direct_normal", "lets through", "it is 800 W/m2"});
  EXPECT_LT(fog.scene.sun->direct_w_m2, 27.0);
  const PictureScene clear = with("haze = \"rural\"\n");
  EXPECT_FALSE(says(all(clear), "the sun"));
  EXPECT_EQ(clear.scene.sun->direct_w_m2, 800.0);
}

TEST_F(Picture, RowsOfAnotherSceneAreRefused) {
  const SceneFile file = load_scene(path("scene.toml"));
  TemperatureRows rows{.source = "three", .facets = 3, .front_k = {300.0F, 300.0F, 300.0F}};
  expect_refused({"scene.toml", "3 temperatures", "2 facets"}, [&] { PictureSource(file, {}, rows); });
}

TEST_F(Picture, RefusesACameraBelowTheGround) {
  write("plates.obj",
        "v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nv 50 50 20\ng left\nf 1 2 3 4\ng right\nf 2 3 5\n");
  const PictureScene scene = read_picture_scene(load_scene(path("scene.toml")), {});
  expect_says(refusal([&] { require_above_ground(scene, {3.0, 1.0, -2.0}); }), {"below the ground"});
  EXPECT_EQ(refusal([&] { require_above_ground(scene, {3.0, 1.0, 2.0}); }), "");
  // Beside the facets too, where the ground is a plane as low as the lowest of them.
  expect_says(refusal([&] { require_above_ground(scene, {3.0, -90.0, -4.0}); }), {"below the ground"});
  EXPECT_EQ(refusal([&] { require_above_ground(scene, {3.0, -90.0, 4.0}); }), "");
}

}  // namespace
}  // namespace apps::scene
