// SPDX-License-Identifier: Apache-2.0
#include "apps/live/space/space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "apps/live/edits.h"
#include "apps/live/space/scene_rows.h"
#include "apps/live/space/solved_scenes.h"
#include "apps/scene/command/read_scene.h"
#include "apps/scene/fly/flight.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_tree.h"
#include "mtf/work/stop.h"

namespace apps::live {
namespace {

using namespace scene;
namespace cfg = mtf::io::cfg;

/// As the page sends places, so that its first request is that of the picture that is made at the start.
std::array<double, 3> to_millimetres(std::array<double, 3> place_m) {
  for (double& part : place_m) part = 1e-3 * std::round(1e3 * part);
  return place_m;
}

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSamples = 2.0, kSamplesMoving = 1.0;  ///< a pitch
constexpr int kPoints = 2, kPointsMoving = 1;           ///< n x n of a sample
constexpr double kLightEvery_s = 1.0;                   ///< pictures at rest have the light of their own second

/// Places around what the camera looks at, as far from it and as high as the camera is: first every fourth of 64 on a
/// circle, then those halfway between them, then the rest; in each group the nearest to the camera first. They stay the
/// same when the camera turns.
std::vector<CameraPlace> places_around(const Viewpoint& from) {
  constexpr int kPlaces = 64;
  constexpr double kStep = 2.0 * std::numbers::pi / kPlaces;
  const auto& [x, y, z] = from.look_at_m;
  const double east = from.position_m[0] - x, north = from.position_m[1] - y, range = std::hypot(east, north);
  std::array<int, kPlaces> turns;
  std::iota(turns.begin(), turns.end(), 1 - kPlaces / 2);
  std::ranges::stable_sort(turns, {},
                           [](int turn) { return std::tuple(turn % 4 != 0, turn % 2 != 0, std::abs(turn)); });
  const double here = std::round(std::atan2(north, east) / kStep);
  std::vector<CameraPlace> places;
  for (const int turn : turns) {
    const double angle = kStep * (here + turn);
    places.push_back({{x + range * std::cos(angle), y + range * std::sin(angle), from.position_m[2]}, from.look_at_m});
  }
  return places;
}

/// What all flights of the view share, and what it was started with.
struct Shared {
  double begin_s = 0.0, end_s = 0.0;
  int threads = 0;
  mtf::DeviceChoice device{};
  std::unique_ptr<SolvedScenes> scenes{};
};

/// A flight over a scene, and the sensor and options of its last frame.
struct Drawing {
  std::shared_ptr<Shared> shared;
  std::shared_ptr<SolvedScene> scene{};
  std::string tab{};  ///< page of the last frame
  std::unique_ptr<Flight> flight{};
  std::optional<double> tolerance{};
  std::optional<radiometry::OutputStage> stage{};

  KeptFrame frame(const Sensor& sensor, const FrameRequest& request) {
    const SimulateOptions image{
        .tolerance = request.tolerance, .stage = request.stage, .device = shared->device, .threads = shared->threads};
    const SolvedScenes::Found found = shared->scenes->find(request.scene, request.tab);
    // Until it is there the page has the scene that it had before.
    const bool own = scene && tab == request.tab;
    const std::shared_ptr<SolvedScene> wanted = found.scene ? found.scene : own ? scene : shared->scenes->start();
    tab = request.tab;
    if (wanted != scene) {
      flight.reset();  // before its source may go
      scene = wanted;
    }
    if (!flight)
      make_flight(image);
    else if (request.tolerance != tolerance || request.stage != stage)
      flight->set_image(image);
    tolerance = request.tolerance, stage = request.stage;
    const std::string memory = memory_words(*sensor, kSamples, kLiveBytes);
    const FrameChoice choice{.samples_per_pitch = request.preview ? kSamplesMoving : kSamples,
                             .points = request.preview ? kPointsMoving : kPoints,
                             .light_may_lag = request.may_lag,
                             .correction = request.correction(),
                             .stop_image = mtf::stop_flag()};
    const Viewpoint& from = request.from.value();
    FlightFrame made = flight->frame(sensor, {from.position_m, from.look_at_m}, from.utc_s, request.number, choice);
    KeptFrame kept;
    kept.names = flight->names();
    kept.image = std::move(made.image);
    kept.range = flight->integer_range();
    kept.plan = std::make_shared<const mtf::SensorPlan>(flight->plan());
    kept.scene = std::make_shared<const mtf::io::Scene>(std::move(*made.radiance));
    kept.light_lags = made.light_lags;
    kept.correction_lags = made.correction_lags;
    kept.solving = found.waiting;
    kept.passing = request.preview || made.light_lags || !kept.solving.empty();
    kept.radiance_promised = made.promised;
    kept.stages_ms = std::move(made.timing_ms);
    for (const auto& [name, words] : flight->closures()) kept.closures.emplace_back(name, words);
    // Of a picture that is for the moment nobody has to be warned.
    if (!request.preview) {
      kept.warnings = std::move(made.warnings);
      const PictureSensor picture = picture_sensor(*sensor, PictureQuantity::weighted);
      if (std::string text = sampling_warning(picture, kSamples); !text.empty())
        kept.warnings.push_back(std::move(text));
      if (!memory.empty()) kept.warnings.push_back(memory);
      if (const std::string failed = device_words(shared->device); !failed.empty()) kept.warnings.push_back(failed);
      flight->look_ahead(places_around(from));  // the camera will turn
    }
    return kept;
  }
  void make_flight(const SimulateOptions& image) {
    // Half a second before the first time: seconds are the middles of the intervals of light.
    const FlightOptions how{.samples_per_pitch = kSamples,
                            .render = {.points = kPoints, .threads = shared->threads},
                            .image = image,
                            .light_every_s = kLightEvery_s,
                            .begin_s = shared->begin_s - 0.5 * kLightEvery_s,
                            .end_s = shared->end_s + 0.5 * kLightEvery_s,
                            .keep_radiance = true};
    flight = std::make_unique<Flight>(*scene->source, scene->file, scene->air, how);
  }
};

std::string metres(double value) { return mtf::format_double(value) + " m"; }

std::string point_text(const std::array<double, 3>& point) {
  std::string text = "[";
  for (std::size_t i = 0; i < 3; ++i) text += (i > 0 ? ", \"" : "\"") + metres(point[i]) + "\"";
  return text + "]";
}

/// Where the camera begins: [camera], or an oblique look at all of it.
CameraPlace place_of(const SceneFile& file, const radiometry::scene::Facets& facets) {
  if (file.camera) return {file.camera->position_m, file.camera->look_at_m};
  const auto& [x, y, z] = facets.middle;
  const double size = facets.half_extent_m;
  return {{x + size, y - size, z + 0.7 * size}, facets.middle};
}

TemperatureRows rows_of(const SceneFile& file, int threads, const HeatProgress& progress) {
  return solved_rows(file, file.time.start_s, file.time.end_s, {.threads = threads}, progress);
}

/// The scene of an edited text: temperatures that `--temperatures` names are those of the start alone.
std::shared_ptr<SolvedScene> solved_scene(const std::string& text, const std::string& path, const PictureOptions& air,
                                          int threads, const SolveProgress& progress) {
  auto scene = std::make_shared<SolvedScene>(SolvedScene{.file = parse_scene(text, path).scene, .air = air});
  std::optional<TemperatureRows> rows;
  if (!regions_to_solve(scene->file).empty()) {
    scene->air.temperatures.clear();
    rows = rows_of(scene->file, threads, progress);
  }
  progress("picture", 0.0);
  scene->source = std::make_unique<PictureSource>(scene->file, scene->air, std::move(rows));
  return scene;
}

/// The text of a scene file whose [camera] is there, without a path; comments and all else stay.
std::string with_camera(const std::string& text, const Viewpoint& from) {
  const std::string position = point_text(from.position_m), look_at = point_text(from.look_at_m);
  const cfg::Tree tree = cfg::read_tree(text);
  const cfg::Node* camera = tree.root.find("camera");
  if (camera == nullptr) return with_block(text, "[camera]\nposition = " + position + "\nlook_at = " + look_at + "\n");
  std::vector<cfg::Edit> edits;
  const auto put = [&](const char* key, const std::string& value) {
    const cfg::Node* old = camera->find(key);
    if (old == nullptr) return false;
    const std::size_t begin = cfg::offset_of(text, old->position);
    edits.push_back({begin, cfg::end_of_value(text, begin), value});
    return true;
  };
  if (const cfg::Node* path = camera->find("path")) {
    // Its line gives way to the two of a camera that stands still; a comment behind it was about the path.
    const std::size_t value = cfg::offset_of(text, path->position);
    const std::size_t begin = text.rfind('\n', value) == std::string::npos ? 0 : text.rfind('\n', value) + 1;
    const std::size_t end = std::min(text.find('\n', value), text.size());
    edits.push_back({begin, end, "position = " + position + "\nlook_at = " + look_at});
  } else {
    put("position", position);
    put("look_at", look_at);
  }
  return cfg::edited(text, std::move(edits));
}

}  // namespace

Space open_space(const SceneViewOptions& options, const Global& global) {
  const auto tell = [&](const std::string& words) {
    if (options.tell) options.tell(words);
  };
  tell("The scene is being read.");
  const auto asked = instant_of("--time", options.time);
  const PictureOptions air{.temperatures = options.temperatures, .utc_s = asked, .air = !options.no_air};
  const auto start = std::make_shared<SolvedScene>(SolvedScene{.file = read_scene(options.scene, global), .air = air});
  const SceneFile& file = start->file;
  const bool solved = options.temperatures.empty() && !regions_to_solve(file).empty();
  std::optional<TemperatureRows> rows;
  if (solved) {
    note(global, "the heat balance is worked out first; mtf heat keeps it for --temperatures");
    ProgressLine progress(global);
    rows = rows_of(file, global.threads, [&](const std::string& step, double share) {
      progress.update(step, share);
      tell("The heat balance is worked out first: " + stage_words(step, share) +
           ". mtf heat keeps it in a folder, for --temperatures.");
    });
  }
  start->source = std::make_unique<PictureSource>(file, air, std::move(rows));
  const auto shared = std::make_shared<Shared>();
  shared->threads = global.threads;
  shared->device = options.device;
  shared->begin_s = file.time.start_s, shared->end_s = file.time.end_s;
  if (const auto span = start->source->temperatures_span_utc_s())
    shared->begin_s = std::max(shared->begin_s, (*span)[0]), shared->end_s = std::min(shared->end_s, (*span)[1]);
  if (asked && !(*asked >= shared->begin_s && *asked <= shared->end_s))
    throw mtf::UsageError("--time: temperatures and weather go from " +
                          radiometry::heat::instant_text(shared->begin_s) + " to " +
                          radiometry::heat::instant_text(shared->end_s));
  shared->scenes = std::make_unique<SolvedScenes>(
      file.text, start,
      [air, path = file.file, threads = global.threads](const std::string& text, const auto& progress) {
        return solved_scene(text, path, air, threads, progress);
      });
  const auto& facets = start->source->rays().facets();
  const CameraPlace place = place_of(file, facets);

  Space space;
  space.drawer = [shared]() -> DrawScene {
    const auto drawing = std::make_shared<Drawing>(Drawing{.shared = shared});
    return [drawing](const Sensor& sensor, const FrameRequest& request) { return drawing->frame(sensor, request); };
  };
  space.start = {to_millimetres(place.position_m), to_millimetres(place.look_at_m),
                 std::round(asked.value_or(shared->begin_s))};
  space.begin_s = shared->begin_s, space.end_s = shared->end_s;
  const std::string text = file.text, path = file.file;
  space.edited = [text, path](std::span<const Edit> edits) { return edited_scene(text, path, edits); };
  space.sun = [place = file.place](double utc_s) {
    return Json{{"elevation_deg", 90.0 - radiometry::heat::sun_position(utc_s, place).zenith_rad / kDegree},
                {"solar_time_h", radiometry::heat::solar_time_h(utc_s, place.longitude_rad)}};
  };
  space.rows = scene_json;
  space.with_camera = with_camera;
  space.facts = {{"facets", facets.size()},
                 {"longitude_deg", file.place.longitude_rad / kDegree},
                 {"size_m", 2.0 * facets.half_extent_m},
                 {"text", file.text},
                 {"temperatures", options.temperatures},
                 {"solved", solved},
                 {"solvable", !regions_to_solve(file).empty()},
                 {"no_air", options.no_air},
                 {"temperatures_change", start->source->temperatures_change()},
                 {"air_in_scene", file.atmosphere.has_value()}};
  return space;
}

}  // namespace apps::live
