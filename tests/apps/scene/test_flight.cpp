// SPDX-License-Identifier: Apache-2.0
// Frames of a flight against the picture and the image that `mtf render` and `mtf simulate` make at that time.

#include "apps/scene/fly/flight.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "apps/simulate/simulate.h"
#include "mtf/error.h"
#include "mtf/io/config/schedule.h"
#include "tests/apps/plates_case.h"
#include "tests/replaced.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
namespace render = radiometry::render;

const std::string kScene =
    apps_test::place_and_weather("start = 2026-06-21T12:00:00Z\nend = 2026-06-21T14:00:00Z\nstep = \"1 h\"\n") +
    R"([[material]]
name = "paint"
solar_absorptance = 0.7
emissivity = 0.8
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "2 mm" }]
)" + apps_test::soil_and_target("material = \"paint\"\n", "temperature = \"warming.csv\"\nmaterial = \"paint\"\n") +
    R"([camera]
position = ["0 m", "-300 m", "40 m"]
look_at = ["0 m", "0 m", "1 m"]
)";
const std::string kAir = "[atmosphere]\nmodel = \"mid_latitude_summer\"\nhaze = \"rural\"\n";
const std::string kPlates =
    "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nv -2 0 0.2\nv 2 0 0.2\nv 2 0.5 3.2\nv -2 0.5 3.2\n"
    "g soil\nf 1 2 3 4\ng target\nf 5 6 7 8\n";
const std::string kSensor = R"(schema = 1
name = "cooled"
[frame]
focal_length = "100 mm"
pitch = "15 um"
format = [80, 64]
integration_time = "6 ms"
[optics]
f_number = 3.0
transmission = 0.85
[band]
wavelength = ["3.7 um", "4.8 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.9
[[presample]]
kind = "jitter"
rms = "20 urad"
[detector]
quantum_efficiency = 0.7
full_well = "7 Me-"
read_noise = "400 e-"
[adc]
bits = 14
[noise]
seed = 3
)";

class Flights : public testing::Test {
 protected:
  Flights() : folder_(fs::temp_directory_path() / ("mtfkit_flight_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    write("scene.toml", kScene + kAir);
    write("plates.obj", kPlates);
    write("warming.csv", "time (s),temperature (K)\n0,300\n100,310\n");
    write("sensor.toml", kSensor);
  }
  ~Flights() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  Flight::Sensor sensor(const std::string& text = kSensor) const {
    write("sensor.toml", text);
    return std::make_shared<const mtf::io::SensorConfig>(read_sensor_file(path("sensor.toml")));
  }
  /// What `mtf render` and `mtf simulate` make of it.
  mtf::Image alone(const SceneFile& file, const Flight::Sensor& of, const CameraPlace& place, double utc_s,
                   double light_utc_s, std::int64_t number) const {
    const PictureSensor with = picture_sensor(*of, PictureQuantity::weighted);
    PictureSource source(file, {});
    PictureScene scene = source.at(light_utc_s);
    const render::Camera camera = picture_camera(with, {.position = place.position_m, .look_at = place.look_at_m}, 2.0);
    const render::RenderOptions options;
    render::Renderer renderer(scene.scene, {with.band}, options);
    source.temperatures(utc_s, scene.scene.temperature_k);
    renderer.temperatures_changed();
    const render::RenderedFrame frame = renderer.render(camera);
    mtf::io::write_exr(path("one.exr"), picture_planes(frame),
                       picture_metadata(file, scene, with, camera, options, frame));
    SimulateResult result = simulate(*of, {.file = path("one.exr")}, {.frames = FrameRange{number, number, 1}});
    return std::move(result.images.front().planes.front());
  }

 private:
  fs::path folder_;
};

double largest_difference(const mtf::Image& a, const mtf::Image& b) {
  double worst = 0.0;
  for (std::int64_t i = 0; i < a.size(); ++i)
    worst = std::max(worst, std::abs(static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i])));
  return worst;
}

TEST_F(Flights, FramesAreThePicturesAndImagesOfTheirTime) {
  const SceneFile file = load_scene(path("scene.toml"));
  PictureSource source(file, {});
  const double begin_s = file.time.start_s;
  Flight flight(source, file, {}, {.begin_s = begin_s, .end_s = begin_s + 60.0});
  const Flight::Sensor camera = sensor();
  for (int i = 0; i < 4; ++i) {
    const CameraPlace place{{10.0 * i, -300.0 + 20.0 * i, 40.0 - 3.0 * i}, {0.0, 0.0, 1.0}};
    const double utc_s = begin_s + 15.0 * i;
    const FlightFrame frame = flight.frame(camera, place, utc_s, i);
    EXPECT_EQ(frame.new_light, i == 0);  // of 60 s
    const mtf::Image other = alone(file, camera, place, utc_s, begin_s + 30.0, i);
    // The same noise and the same scene within tables and filters: a count here and there.
    EXPECT_LE(largest_difference(frame.image.planes.front(), other), 1.0) << i;
  }
}

TEST_F(Flights, LightMadeBesideFramesIsThatMadeInThem) {
  const SceneFile file = load_scene(path("scene.toml"));
  const double begin_s = file.time.start_s;
  const Flight::Sensor before = sensor();
  std::string text = kSensor;
  text = replaced(text, "4.8 um", "4.6 um");
  const Flight::Sensor after = sensor(text);
  const FlightOptions options{.light_every_s = 20.0, .begin_s = begin_s, .end_s = begin_s + 60.0};
  const CameraPlace place{{0.0, -300.0, 40.0}, {0.0, 0.0, 1.0}};
  PictureSource source(file, {});
  Flight told(source, file, {}, options), untold(source, file, {}, options);
  for (int i = 0; i < 6; ++i) {
    const Flight::Sensor& now = i < 3 ? before : after;
    const FlightFrame one = told.frame(now, place, begin_s + 10.0 * i, i);
    told.prepare(i + 1 < 3 ? before : after, begin_s + 10.0 * (i + 1));
    const FlightFrame other = untold.frame(now, place, begin_s + 10.0 * i, i);
    EXPECT_EQ(one.new_light, other.new_light) << i;
    EXPECT_EQ(other.new_light, i == 0 || i == 2 || i == 3 || i == 4) << i;
    EXPECT_LE(largest_difference(one.image.planes.front(), other.image.planes.front()), 1.0) << i;
  }
}

TEST_F(Flights, LightMayLagUntilItIsThere) {
  const SceneFile file = load_scene(path("scene.toml"));
  const double begin_s = file.time.start_s;
  const Flight::Sensor camera = sensor();
  std::string text = kSensor;
  text = replaced(text, "4.8 um", "4.6 um");
  const Flight::Sensor other_band = sensor(text);
  const CameraPlace place{{0.0, -300.0, 40.0}, {0.0, 0.0, 1.0}};
  PictureSource source(file, {});
  Flight flight(source, file, {},
                {.light_every_s = 1.0, .begin_s = begin_s, .end_s = begin_s + 90.0, .keep_radiance = true});
  const FrameChoice lag{.light_may_lag = true};
  EXPECT_FALSE(flight.frame(camera, place, begin_s, 0, lag).light_lags);  // there is none before it
  // At once the old light under temperatures of now; once it is there, that of now.
  const FlightFrame first = flight.frame(camera, place, begin_s + 80.5, 1, lag);
  EXPECT_TRUE(first.light_lags);
  ASSERT_TRUE(first.radiance);
  EXPECT_LE(
      largest_difference(first.image.planes.front(), alone(file, camera, place, begin_s + 80.5, begin_s + 0.5, 1)),
      1.0);
  FlightFrame later = flight.frame(camera, place, begin_s + 80.5, 1, lag);
  for (int i = 0; i < 1000 && later.light_lags; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    later = flight.frame(camera, place, begin_s + 80.5, 1, lag);
  }
  EXPECT_FALSE(later.light_lags);
  const mtf::Image alone_then = alone(file, camera, place, begin_s + 80.5, begin_s + 80.5, 1);
  EXPECT_LE(largest_difference(later.image.planes.front(), alone_then), 1.0);
  // Light of another band is no light for this one.
  EXPECT_FALSE(flight.frame(other_band, place, begin_s + 80.5, 1, lag).light_lags);
  // Fewer samples are another picture; the plans of both stay.
  flight.frame(camera, place, begin_s + 80.5, 1, {.samples_per_pitch = 1.0});
  const int compiled = flight.plans_compiled();
  const FlightFrame again = flight.frame(camera, place, begin_s + 80.5, 1);
  EXPECT_EQ(again.radiance->planes.front().width(), 160);
  EXPECT_EQ(flight.frame(camera, place, begin_s + 80.5, 1, {.samples_per_pitch = 1.0}).radiance->planes.front().width(),
            80);
  EXPECT_EQ(flight.plans_compiled(), compiled);
  EXPECT_LE(largest_difference(again.image.planes.front(), alone_then), 1.0);
  // A sensor that changes while the view does not takes the radiance again; the image is its own.
  flight.frame(other_band, place, begin_s + 80.5, 1);
  std::string shaking_text = kSensor;
  shaking_text = replaced(shaking_text, "20 urad", "90 urad");
  const Flight::Sensor shaking = sensor(shaking_text);
  flight.frame(camera, place, begin_s + 80.5, 1);
  const FlightFrame shaken = flight.frame(shaking, place, begin_s + 80.5, 1);
  EXPECT_LE(largest_difference(shaken.radiance->planes.front(), again.radiance->planes.front()),
            1e-4 * static_cast<double>(again.radiance->planes.front().at(80, 64)));
  EXPECT_LE(
      largest_difference(shaken.image.planes.front(), alone(file, shaking, place, begin_s + 80.5, begin_s + 80.5, 1)),
      1.0);
  EXPECT_GT(largest_difference(shaken.image.planes.front(), again.image.planes.front()), 10.0);
  // Fewer points are those of a flight that has no more; the radiance of the others is not taken for theirs.
  Flight coarse(source, file, {},
                {.render = {.points = 1},
                 .light_every_s = 1.0,
                 .begin_s = begin_s,
                 .end_s = begin_s + 90.0,
                 .keep_radiance = true});
  const mtf::Image four = flight.frame(camera, place, begin_s + 80.5, 1).image.planes.front().clone();
  const mtf::Image one = flight.frame(camera, place, begin_s + 80.5, 1, {.points = 1}).image.planes.front().clone();
  EXPECT_GT(largest_difference(one, four), 0.0);
  EXPECT_LE(largest_difference(one, coarse.frame(camera, place, begin_s + 80.5, 1).image.planes.front()), 1.0);
}

TEST_F(Flights, WhatIsSeenAheadIsKnownAndChangesNoPicture) {
  const SceneFile file = load_scene(path("scene.toml"));
  const double begin_s = file.time.start_s;
  const Flight::Sensor camera = sensor();
  const CameraPlace front{{0.0, -300.0, 40.0}, {0.0, 0.0, 1.0}}, behind{{0.0, 300.0, 40.0}, {0.0, 0.0, 1.0}};
  const std::vector<CameraPlace> ahead{{{0.0, -300.0, -4.0}, {0.0, 0.0, 1.0}},      // below the ground
                                       {{0.0, -300.0, 40.0}, {0.0, -600.0, 40.0}},  // sees no facet
                                       {{0.0, 0.0, 40.0}, {0.0, 0.0, 1.0}},         // looks along `up`
                                       behind};
  PictureSource source(file, {});
  const FlightOptions options{.light_every_s = 1.0, .begin_s = begin_s, .end_s = begin_s + 90.0, .keep_radiance = true};
  Flight flight(source, file, {}, options), other(source, file, {}, options);
  const auto same = [](const FlightFrame& a, const FlightFrame& b) {
    return largest_difference(a.radiance->planes.front(), b.radiance->planes.front()) == 0.0 &&
           largest_difference(a.image.planes.front(), b.image.planes.front()) == 0.0;
  };
  flight.look_ahead(ahead);  // no light yet
  const std::size_t seen = flight.frame(camera, front, begin_s, 0).sides;
  FlightFrame again;
  for (int i = 0; i < 1000 && again.sides <= seen; ++i) {
    flight.look_ahead(ahead);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    again = flight.frame(camera, front, begin_s, 0);
    EXPECT_FALSE(again.new_light);
    // The same radiance would be taken again, and `sides` with it: another view in between.
    flight.frame(camera, {{5.0, -300.0, 40.0}, {0.0, 0.0, 1.0}}, begin_s, 0);
  }
  EXPECT_EQ(again.sides, seen + 1);  // the other side of the target
  EXPECT_TRUE(same(again, other.frame(camera, front, begin_s, 0)));
  const FlightFrame turned = flight.frame(camera, behind, begin_s, 0);
  EXPECT_EQ(turned.sides, seen + 1);
  EXPECT_TRUE(same(turned, other.frame(camera, behind, begin_s, 0)));
  // The light of another time comes, though a view ahead is asked for after every frame.
  FlightFrame later;
  for (int i = 0; i < 1000 && (i == 0 || later.light_lags); ++i) {
    later = flight.frame(camera, front, begin_s + 80.5, 0, {.light_may_lag = true});
    flight.look_ahead(std::vector<CameraPlace>{{{200.0 + i, 200.0, 40.0}, {0.0, 0.0, 1.0}}});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_FALSE(later.light_lags);
  flight.look_ahead(std::vector<CameraPlace>{{{-200.0, 200.0, 40.0}, {0.0, 0.0, 1.0}}});  // and ends in the midst of it
}

TEST_F(Flights, SensorsMayChangeInEveryFrame) {
  const SceneFile file = load_scene(path("scene.toml"));
  const double begin_s = file.time.start_s;
  const Flight::Sensor first = sensor();
  mtf::io::ScheduledSensor changing(
      *first, mtf::io::parse_schedule("frame,parameter,value\n1,jitter.rms,60 urad\n2,frame.focal_length,140 mm\n"
                                      "3,optics.f_number,4\n",
                                      "schedule", *first));
  const CameraPlace place{{0.0, -300.0, 40.0}, {0.0, 0.0, 1.0}};
  PictureSource source(file, {});
  Flight flight(source, file, {}, {.begin_s = begin_s, .end_s = begin_s});
  Flight::Sensor now;
  for (int i = 0; i < 4; ++i) {
    if (changing.advance(i) || !now) now = std::make_shared<const mtf::io::SensorConfig>(changing.sensor());
    const FlightFrame frame = flight.frame(now, place, begin_s, i);
    EXPECT_EQ(frame.new_light, i == 0);
    EXPECT_LE(largest_difference(frame.image.planes.front(), alone(file, now, place, begin_s, begin_s, i)), 1.0) << i;
  }
}

TEST_F(Flights, RefuseWhatIsNoPicture) {
  const SceneFile file = load_scene(path("scene.toml"));
  const double begin_s = file.time.start_s;
  PictureSource source(file, {});
  EXPECT_THROW(Flight(source, file, {}, {.light_every_s = 0.0}), mtf::UsageError);
  Flight flight(source, file, {}, {.begin_s = begin_s, .end_s = begin_s});
  EXPECT_THROW(flight.closures(), mtf::UsageError);
  EXPECT_THROW(flight.frame(sensor(), {{0, -300, -4}, {0, 0, 1}}, begin_s, 0), mtf::UsageError);
  EXPECT_THROW(flight.frame(sensor(), {{0, -300, 40}, {0, -600, 40}}, begin_s, 0), mtf::UsageError);  // no facet
  EXPECT_NO_THROW(flight.frame(sensor(), {{0, -300, 40}, {0, 0, 1}}, begin_s, 0));
}

}  // namespace
}  // namespace apps::scene
