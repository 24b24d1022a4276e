// SPDX-License-Identifier: Apache-2.0

// Frames of the example scene of `mtf scene demo` (356,000 triangles) through a sensor: a camera that moves in every
// frame, two samples a pitch of four points each, air, and the sensor's chain with noise. Stage by
// stage, least and median time by the clock; as a floor the bare Embree rays of the same frames, in packets of 16, in
// turn with them. Arguments: sensor files (with [detector]); then, as a number, the threads (2). Temperatures are made
// up, as the heat balance is not what is timed. The bars, on two cores: 28 frames a second for the uncooled camera, 25
// for the cooled one.

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>

#include "apps/scene/fly/stage_times.h"
#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/outputs/mesh_files.h"
#include "apps/scene/outputs/npy_file.h"
#include "apps/scene/render/sensor_picture.h"
#include "apps/scene/scene_file/demo_scene_text.h"
#include "apps/scene/vehicle/vehicle.h"
#include "apps/simulate/sensor_run.h"
#include "mtf/io/scene.h"
#include "mtf/parallel.h"
#include "mtf/version.h"
#include "radiometry/scene/tracing/embree_scene.h"

namespace {

using namespace apps::scene;  // NOLINT: a benchmark program
namespace fs = std::filesystem;
namespace render = radiometry::render;

constexpr int kFrames = 15;

double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

fs::path demo_scene() {
  const fs::path folder = fs::temp_directory_path() / ("mtfkit_bench_render_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "scene.toml") << demo_scene_text();
  std::ofstream(folder / "weather.csv") << demo_weather_text();
  std::ofstream(folder / "engine.csv") << demo_engine_text();
  write_obj((folder / "vehicle.obj").string(), make_vehicle());
  write_obj((folder / "terrain.obj").string(), make_terrain());
  return folder;
}

/// One row for all time: warm where facets look up and to the south, with a pattern of some metres.
std::string made_temperatures(const fs::path& folder, const SceneFile& file) {
  ThermalScene scene = values_of(file);
  read_meshes(file, scene);
  std::vector<float> kelvin;
  for (const auto& facet : scene.facets.facet)
    kelvin.push_back(static_cast<float>(296.0 + 10.0 * facet.normal[2] - 6.0 * facet.normal[1] +
                                        2.0 * std::sin(2.0 * facet.centre[0]) * std::cos(3.0 * facet.centre[1])));
  const std::string path = (folder / "temperatures.npy").string();
  NpyFile table(path, kelvin.size());
  table.append(kelvin);
  table.commit();
  return path;
}

render::Camera camera_at(const PictureSensor& sensor, int frame) {
  const double turn = 0.004 * frame - 0.7;
  return picture_camera(sensor, {.position = {60.0 * std::cos(turn), 60.0 * std::sin(turn), 8.0}, .look_at = {0, 0, 1}},
                        2.0);
}

/// The rays of a frame and nothing else.
double bare_rays_ms(const radiometry::scene::Rays& rays, const render::Camera& camera, int threads) {
  const double begin = now_ms();
  const radiometry::scene::EmbreeScene& embree = rays.embree();
  const std::array<float, 3> origin = embree.single(camera.position, {0.0, 0.0, 1.0}).origin;
  const std::int64_t across = camera.width / 4;
  mtf::parallel_for(across * (camera.height / 4), 256, threads, [&](std::int64_t first, std::int64_t last) {
    std::array<radiometry::scene::SingleRay, radiometry::scene::kPacket> packet;
    std::array<std::uint32_t, radiometry::scene::kPacket> met{};
    for (std::int64_t tile = first; tile < last; ++tile) {
      for (std::size_t lane = 0; lane < packet.size(); ++lane) {
        const auto d =
            camera.direction(static_cast<double>(tile % across * 4 + static_cast<std::int64_t>(lane % 4)) + 0.5,
                             static_cast<double>(tile / across * 4 + static_cast<std::int64_t>(lane / 4)) + 0.5);
        packet[lane] = {origin, {static_cast<float>(d[0]), static_cast<float>(d[1]), static_cast<float>(d[2])}};
      }
      embree.first_triangles(packet, met);
    }
  });
  return now_ms() - begin;
}

void print(const StageTimes& times, std::size_t frames) {
  for (const StageTimes::Row& row : times.rows(frames))
    std::printf("  %-34s %8.2f %8.2f\n", row.name.c_str(), row.least, row.median);
}

void run(const SceneFile& file, const std::string& temperatures, const std::string& sensor_file, int threads) {
  const double begin = now_ms();
  const mtf::io::SensorConfig config = apps::read_sensor_file(sensor_file);
  const PictureSensor sensor = picture_sensor(config, PictureQuantity::weighted);
  const PictureScene scene = read_picture_scene(
      file, {.temperatures = temperatures, .utc_s = file.time.start_s + 17.0 * 3600.0, .sensor_air = sensor.air});
  render::Renderer renderer(scene.scene, {sensor.band}, {.threads = threads});
  render::RenderedFrame frame = renderer.render(camera_at(sensor, 0));
  std::printf("%s, %d threads: first frame after %.0f ms; tables within %.1e\n", config.system.name.c_str(), threads,
              now_ms() - begin, frame.promised.front());
  for (const auto& times : {scene.timing_ms, renderer.timing_ms(), frame.timing_ms})
    for (const auto& [name, ms] : times) std::printf("  %-34s %8.1f\n", name.c_str(), ms);

  const apps::SensorRun run(config, std::nullopt);
  const apps::RadiometricChain* radiometric = run.chain();
  const render::Camera camera = camera_at(sensor, 0);
  const mtf::Frame<double>& lens = config.system.frame;
  const mtf::SampleGrid grid{camera.width, camera.height, 0.5 * lens.pitch_x_um, 0.5 * lens.pitch_y_um};
  mtf::PlanOptions options;
  options.tolerance = 1e-3;
  options.border = config.scene.border;
  options.separate_readout = true;
  options.threads = threads;
  const mtf::SensorPlan plan = mtf::compile_sensor(radiometric->system, grid, options, run.samples_a_pitch());
  const radiometry::Chain chain(plan, radiometric->system, radiometric->loaded.sensor, {}, threads);
  chain.prepare(radiometric->stage, threads);

  StageTimes series;
  for (int i = 0; i <= kFrames; ++i) {
    const render::Camera here = camera_at(sensor, i);
    const double bare = bare_rays_ms(*scene.rays, here, threads);
    const double start = now_ms();
    frame = renderer.render(here);
    const double rendered = now_ms();
    radiometry::ChainFrame image =
        chain.run(std::move(frame.radiance.front()), static_cast<std::uint32_t>(i), radiometric->stage, 0.0, threads);
    const double done = now_ms();
    if (i == 0) continue;  // warms up
    for (const auto& [name, ms] : frame.timing_ms) series.add(name, ms);
    series.add("picture", rendered - start);
    series.add("OTF, sampling, chain", done - rendered);
    series.add("frame", done - start);
    series.add("floor: bare rays, one a sample", bare);
  }
  std::printf("%zu samples of more than one side, %zu shadow rays in the last frame; %zu sides seen\n  %-34s %8s %8s\n",
              frame.divided, frame.shadow_rays, frame.sides, "ms a frame", "least", "median");
  print(series, kFrames);
}

}  // namespace

int main(int argc, char** argv) {
  int threads = 2;
  std::vector<std::string> sensors;
  for (int i = 1; i < argc; ++i)
    if (std::atoi(argv[i]) > 0)
      threads = std::atoi(argv[i]);
    else
      sensors.emplace_back(argv[i]);
  if (sensors.empty())
    for (const char* name : {"lwir_uncooled.toml", "mwir_cooled.toml"})
      sensors.push_back(std::string(MTFKIT_SOURCE_DIR) + "/notebooks-data/studies/" + name);
  std::printf("bench_render, %s %s\n", mtf::version, mtf::git_commit);
  const fs::path folder = demo_scene();
  int status = 0;
  try {
    const SceneFile file = load_scene((folder / "scene.toml").string());
    const std::string temperatures = made_temperatures(folder, file);
    for (const std::string& sensor : sensors) run(file, temperatures, sensor, threads);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_render: %s\n", error.what());
    status = 1;
  }
  fs::remove_all(folder);
  return status;
}
