// SPDX-License-Identifier: Apache-2.0

// `mtf bench scene.toml -o DIR`: what each tolerance of the temperatures costs: promised and realised error, and time.
// `mtf bench scene.toml camera.toml -o DIR`: what points and tables of a picture cost, and how far it is from the
// truth.
//   sampling  each sample against the mean of 64 points over its square (256 a pixel at two samples a pitch), rms and
//             largest, of the picture's standard deviation
//   tables    emitted and path radiance of 1000 of its samples against direct integration over wavelength through the
//             air of that very range and height (radiometry/light/scene_radiance.h), which shares no quadrature with
//             the tables; beside it what the tables promise
//   time      of the first picture from a scene that is read, and of those that follow with another look at the same

#include <algorithm>
#include <cmath>

#include "apps/bench/machine.h"
#include "apps/config_command.h"
#include "apps/figures/plot.h"
#include "apps/scene/heat/read_temperatures.h"
#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/render/sensor_picture.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/version.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/light/scene_radiance.h"

namespace apps {
namespace {

namespace render = radiometry::render;
using namespace scene;

/// Times of the rounds of a rung.
struct Rounds {
  std::vector<double> ms{};
  double least_ms() const { return *std::min_element(ms.begin(), ms.end()); }
  double median_ms() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

/// What is written of a ladder of settings.
struct Ladder {
  std::string name;          ///< of its files
  Json about;                ///< what was measured
  std::vector<Json> rows{};  ///< a rung each; its numbers are those of the CSV file
  std::string table{};
  std::vector<std::string> broken{};  ///< promises
};

/// Errors against the least time, with a factor from ms: curves by their names and the names of their numbers.
Figure figure_of(const Ladder& ladder, const std::string& title, double factor,
                 const std::vector<std::pair<const char*, const char*>>& curves) {
  Figure figure;
  figure.title = "error against run time" + title;
  figure.log_x = figure.log_y = true;
  for (const auto& [name, key] : curves) {
    Series series{.name = name, .mark = figure.series.empty() ? Mark::large_points : Mark::points};
    for (const Json& row : ladder.rows) {
      series.x.push_back(factor * row["time_ms_min"].get<double>());
      series.y.push_back(row[key].get<double>());
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

OutputSet outputs_of(const BenchOptions& options, const std::string& name, const std::vector<std::string>& inputs) {
  return OutputSet({.folder = options.out,
                    .force = options.force,
                    .names = {name + ".csv", name + ".json", name + ".svg"},
                    .inputs = inputs});
}

std::string csv_of(const std::vector<Json>& rows) {
  const auto cells = [](const Json& row, const auto& text_of) {
    std::vector<std::string> texts;
    for (const auto& [name, value] : row.items())
      if (value.is_number()) texts.push_back(text_of(name, value));
    return texts;
  };
  TextTable table(cells(rows.front(), [](const std::string& name, const Json&) { return name; }));
  for (const Json& row : rows)
    table.add(cells(row, [](const std::string&, const Json& value) { return csv_number(value.get<double>()); }));
  return table.csv();
}

std::string json_of(const Ladder& ladder, int threads, std::size_t rounds) {
  const Machine machine = this_machine();
  Json json = {{"version", mtf::version},
               {"git_commit", mtf::git_commit},
               {"machine", {{"cpu", machine.cpu}, {"cores", machine.cores}, {"memory_bytes", machine.memory_bytes}}}};
  json.update(ladder.about);
  json["threads"] = threads > 0 ? threads : machine.cores;
  json["rounds"] = rounds;
  json["rows"] = ladder.rows;
  return json_document(json);
}

/// The exit code.
int write_ladder(const Ladder& ladder, const Figure& figure, std::size_t rounds, const BenchOptions& options,
                 const Global& global, OutputSet& outputs) {
  const std::string csv = csv_of(ladder.rows), json = json_of(ladder, global.threads, rounds);
  emit(outputs.in(ladder.name + ".csv"), csv);
  emit(outputs.in(ladder.name + ".json"), json);
  if (!draw_figure(outputs.in(ladder.name + ".svg"), figure))
    note(global, "note: gnuplot is not installed; " + ladder.name + ".csv has the numbers, " + ladder.name +
                     ".svg is left out");
  outputs.commit();
  print(options.format == Format::json  ? json
        : options.format == Format::csv ? csv
                                        : ladder.table + "written to " + one_line(options.out) + "/\n");
  for (const std::string& promise : ladder.broken) complain("mtf: PROMISE BROKEN: " + promise);
  return ladder.broken.empty() ? 0 : 3;
}

struct HeatRung : Rounds {  ///< weather and meshes read, rays, heat
  double tolerance_k = 0.0;
  HeatReport report{};  ///< of the run that is verified
  bool kept() const { return report.verified->as_units.largest_k <= report.promised.total_k(); }
};

HeatRung rung_of(const SceneFile& file, double tolerance_k, int rounds, const Global& global, ProgressLine& progress) {
  HeatRung rung;
  rung.tolerance_k = tolerance_k;
  const std::string name = significant(tolerance_k, 2) + " K: ";
  const auto say = [&](const std::string& step, double share) { progress.update(name + step, share); };
  HeatOptions options{.tolerance_k = tolerance_k, .threads = global.threads};
  const auto solved = [&] {
    return run_heat(
        prepare_heat(file, options), options, [](const HeatOutput&) {}, say);
  };
  for (int round = 0; round < rounds; ++round) {
    const mtf::Stopwatch watch;
    solved();
    rung.ms.push_back(watch.ms());
  }
  options.verify = true;
  rung.report = solved();
  return rung;
}

Json row_of(const HeatRung& rung) {
  const RealisedError &ours = rung.report.verified->as_units, &facets = rung.report.verified->by_itself;
  return {{"tolerance_K", rung.tolerance_k},
          {"promised_K", rung.report.promised.total_k()},
          {"realised_K", ours.largest_k},
          {"facets_rms_K", facets.rms_k},
          {"facets_95_K", facets.percentile_95_k},
          {"facets_99_9_K", facets.percentile_999_k},
          {"facets_largest_K", facets.largest_k},
          {"classes", static_cast<double>(rung.report.units)},
          {"time_ms_min", rung.least_ms()},
          {"time_ms_median", rung.median_ms()},
          {"kept", rung.kept()}};
}

std::string table_of(const std::vector<HeatRung>& ladder) {
  TextTable table(
      {"tolerance", "promised", "realised", "facets rms", "95 %", "largest [K]", "classes", "s min", "median"});
  for (const HeatRung& rung : ladder) {
    const RealisedError &ours = rung.report.verified->as_units, &facets = rung.report.verified->by_itself;
    table.add({significant(rung.tolerance_k, 2), significant(rung.report.promised.total_k(), 2),
               significant(ours.largest_k, 2), significant(facets.rms_k, 2), significant(facets.percentile_95_k, 2),
               significant(facets.largest_k, 2), std::to_string(rung.report.units), fixed(1e-3 * rung.least_ms(), 2),
               fixed(1e-3 * rung.median_ms(), 2)});
  }
  using enum Align;
  return table.aligned({right, right, right, right, right, right, right, right, right}) +
         "realised: the worst facet and output against a tenth of the tolerance, with the same classes; facets: "
         "against\n"
         "every facet solved by itself, with what those of a class see differently, which the promise leaves out\n";
}

struct PictureRung : Rounds {  ///< of the pictures that follow
  int points = 1;              ///< n x n of a sample
  double tolerance = 0.0;
  double promised = 0.0, tables = 0.0;            ///< relative
  double sampling_rms = 0.0, sampling_max = 0.0;  ///< of the standard deviation
  std::size_t divided = 0;
  double first_ms = 0.0;
};

struct Subject {
  const PictureScene& scene;
  const render::RenderBand& band;
  const render::Camera& camera;
  int threads;
};

render::RenderOptions how(const Subject& subject, int points, double tolerance) {
  return {.points = points, .tolerance = tolerance, .threads = subject.threads};
}

/// The mean of 64 points over each sample: 16 for each of four parts of it.
mtf::Image reference_of(const Subject& subject) {
  render::Camera fine = subject.camera;
  fine.width *= 2, fine.height *= 2;
  fine.step_x *= 0.5, fine.step_y *= 0.5;
  fine.axis_x *= 2.0, fine.axis_y *= 2.0;
  render::RenderOptions options = how(subject, 4, 1e-6);
  options.ray_shadows = true;
  render::Renderer renderer(subject.scene.scene, {subject.band}, options);
  const render::RenderedFrame frame = renderer.render(fine);
  const mtf::Image& from = frame.radiance.front();
  mtf::Image mean(subject.camera.width, subject.camera.height);
  for (std::int64_t y = 0; y < mean.height(); ++y)
    for (std::int64_t x = 0; x < mean.width(); ++x) {
      double sum = 0.0;
      for (const auto& [i, j] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}})
        sum += static_cast<double>(from.at(2 * x + i, 2 * y + j));
      mean.at(x, y) = static_cast<float>(0.25 * sum);
    }
  return mean;
}

/// A thousand facets that the picture shows, evenly over it.
struct Seen {
  std::size_t finish;
  double kelvin, range_m, height_m;
};

std::vector<Seen> seen_of(const Subject& subject) {
  constexpr std::size_t kPlaces = 1000;
  render::RenderOptions options = how(subject, 1, 1e-3);
  options.layers = {.temperature = true, .range = true, .finish = true};
  render::Renderer renderer(subject.scene.scene, {subject.band}, options);
  const render::RenderedFrame frame = renderer.render(subject.camera);
  const auto layer = [&](std::string_view name) -> const mtf::Image& {
    return std::ranges::find_if(frame.layers, [&](const auto& one) { return one.name == name; })->plane;
  };
  const mtf::Image &kelvin = layer("temperature"), &range = layer("Z"), &finish = layer("material");
  std::vector<Seen> seen;
  const auto hits = static_cast<std::size_t>(
      std::count_if(finish.data(), finish.data() + finish.size(), [](float m) { return m >= 0.0F; }));
  const std::size_t step = std::max<std::size_t>(1, hits / kPlaces);
  std::size_t hit = 0;
  for (std::int64_t y = 0; y < finish.height(); ++y)
    for (std::int64_t x = 0; x < finish.width(); ++x) {
      if (finish.at(x, y) < 0.0F || hit++ % step != 0) continue;
      const render::Vector d = subject.camera.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      const auto range_m = static_cast<double>(range.at(x, y));
      seen.push_back({static_cast<std::size_t>(finish.at(x, y)), static_cast<double>(kelvin.at(x, y)), range_m,
                      subject.camera.position[2] + range_m * d[2] / radiometry::scene::length(d)});
    }
  return seen;
}

/// The largest error of tables of that tolerance, and what they promise.
void measure_tables(const Subject& subject, const std::vector<Seen>& seen, PictureRung& rung) {
  const render::Patches none{};
  const radiometry::scene::Views unseen{.rings = 9, .sky = {}, .ground = {}, .surfaces = {}, .rays = {}, .patches = {}};
  render::BandShader shader(subject.band, subject.scene.scene, none, unseen, rung.tolerance, true);
  render::PathExtent extent{seen.front().range_m, seen.front().range_m, seen.front().height_m, seen.front().height_m};
  for (const Seen& one : seen)
    extent = {std::min(extent.nearest_m, one.range_m), std::max(extent.farthest_m, one.range_m),
              std::min(extent.lowest_m, one.height_m), std::max(extent.highest_m, one.height_m)};
  shader.prepare(subject.camera.position[2], extent);
  rung.promised = shader.promised();
  const render::AirView* view = shader.air_view();
  const radiometry::SpectralCamera& curves = subject.band.curves;
  const double reference_k = view != nullptr ? view->reference_k() : 300.0;
  const double black = view != nullptr ? scene_radiance(curves, {.temperature_k = reference_k}, {}) : 0.0;
  for (const Seen& one : seen) {
    radiometry::Path path;
    if (view != nullptr) {
      const render::AirSamples air = view->to(one.range_m, one.height_m);
      path.transmission = {"transmission", shader.nodes().sample_um, air.transmission};
      path.emissivity = {"emissivity", shader.nodes().sample_um, air.source};
      path.air_temperature_k = reference_k;
    }
    const radiometry::Spectrum& emissivity = subject.scene.scene.finish[one.finish].emissivity;
    const double direct = scene_radiance(curves, {.temperature_k = one.kelvin, .emissivity = emissivity}, path) +
                          (view != nullptr ? weighted_path_radiance(curves, path) : 0.0);
    const double tables = shader.own_radiance(one.finish, one.kelvin, one.range_m, one.height_m);
    rung.tables = std::max(rung.tables, std::abs(tables - direct) / std::max(direct, black));
  }
}

void measure_picture(const Subject& subject, const mtf::Image& reference, int rounds, PictureRung& rung) {
  const mtf::Stopwatch first;
  render::Renderer renderer(subject.scene.scene, {subject.band}, how(subject, rung.points, rung.tolerance));
  render::RenderedFrame frame = renderer.render(subject.camera);
  rung.first_ms = first.ms();
  for (int round = 0; round < rounds; ++round) {
    const mtf::Stopwatch watch;
    frame = renderer.render(subject.camera);
    rung.ms.push_back(watch.ms());
  }
  rung.divided = frame.divided;
  const double std = mtf::statistics(reference.view()).std;
  double square = 0.0;
  for (std::int64_t i = 0; i < reference.size(); ++i) {
    const double error =
        std::abs(static_cast<double>(frame.radiance.front().data()[i]) - static_cast<double>(reference.data()[i]));
    square += error * error;
    rung.sampling_max = std::max(rung.sampling_max, error / std);
  }
  rung.sampling_rms = std::sqrt(square / static_cast<double>(reference.size())) / std;
}

Json row_of(const PictureRung& rung) {
  return {{"points_a_sample", static_cast<double>(rung.points * rung.points)},
          {"tolerance", rung.tolerance},
          {"promised", rung.promised},
          {"tables_error", rung.tables},
          {"sampling_rms", rung.sampling_rms},
          {"sampling_max", rung.sampling_max},
          {"divided", static_cast<double>(rung.divided)},
          {"first_ms", rung.first_ms},
          {"time_ms_min", rung.least_ms()},
          {"time_ms_median", rung.median_ms()}};
}

std::string table_of(const std::vector<PictureRung>& ladder) {
  TextTable table({"points a sample", "tolerance", "tables promise", "tables err", "sampling rms", "largest",
                   "first ms", "ms min", "median"});
  for (const PictureRung& rung : ladder)
    table.add({std::to_string(rung.points * rung.points), significant(rung.tolerance, 2), significant(rung.promised, 2),
               significant(rung.tables, 2), significant(rung.sampling_rms, 2), significant(rung.sampling_max, 2),
               fixed(rung.first_ms, 0), fixed(rung.least_ms(), 1), fixed(rung.median_ms(), 1)});
  using enum Align;
  return table.aligned({left, right, right, right, right, right, right, right, right}) +
         "sampling: against the mean of 64 points over each sample, of the picture's standard deviation\n"
         "tables: largest of 1000 samples against direct integration over wavelength, relative\n";
}

}  // namespace

int run_bench_heat(const BenchOptions& options, const Global& global) {
  const SceneFile file = load_scene(options.sensor);
  Ladder ladder{.name = "heat_bench", .about = {{"scene", file.file}, {"scene_sha256", file.sha256}}};
  OutputSet outputs = outputs_of(options, ladder.name, files_of(file));
  std::vector<double> tolerances = options.tolerances_k;
  if (tolerances.empty()) tolerances = {1.0, 0.3, 0.1};
  const int rounds = options.rounds.value_or(1);
  std::vector<HeatRung> rungs;
  {
    ProgressLine progress(global);
    for (const double tolerance_k : tolerances) rungs.push_back(rung_of(file, tolerance_k, rounds, global, progress));
  }
  ladder.about["facets"] = rungs.front().report.facets;
  for (const HeatRung& rung : rungs) {
    ladder.rows.push_back(row_of(rung));
    if (!rung.kept())
      ladder.broken.push_back("tolerance " + significant(rung.tolerance_k, 2) + " K: promised " +
                              significant(rung.report.promised.total_k(), 3) + " K, realised " +
                              significant(rung.report.verified->as_units.largest_k, 3) + " K");
  }
  ladder.table = table_of(rungs);
  Figure figure = figure_of(ladder, ": " + file.file, 1e-3,
                            {{"promised", "promised_K"},
                             {"realised, worst facet and output", "realised_K"},
                             {"every facet by itself, rms", "facets_rms_K"}});
  figure.x_label = "time [s], minimum of the rounds";
  figure.y_label = "error [K]";
  return write_ladder(ladder, figure, static_cast<std::size_t>(rounds), options, global, outputs);
}

int run_bench_render(const BenchOptions& options, const Global& global) {
  const SceneFile file = load_scene(options.sensor);
  const PictureSensor sensor = picture_sensor(read_sensor(options.scene, global), PictureQuantity::weighted);
  std::vector<std::string> inputs = files_of(file);
  for (const std::vector<std::string>& more : {files_of(sensor.config), temperature_files(options.temperatures)})
    inputs.insert(inputs.end(), more.begin(), more.end());
  OutputSet outputs = outputs_of(options, "render_bench", inputs);
  const PictureScene scene = read_picture_scene(
      file, {.temperatures = options.temperatures, .sensor_air = sensor.air, .sensor_file = options.scene});
  const render::Camera camera = picture_camera(sensor, pose_of(file, options.position, options.look_at), 2.0);
  require_above_ground(scene, camera.position);
  const Subject subject{scene, sensor.band, camera, global.threads};

  constexpr double kUsual = 5e-6;
  std::vector<PictureRung> rungs;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) rungs.push_back({{}, 1, tolerance});
  rungs.push_back({{}, 1, kUsual});
  for (const int points : {2, 4}) rungs.push_back({{}, points, kUsual});
  {
    ProgressLine progress(global);
    progress.update("reference of 64 points a sample", 0.0);
    const mtf::Image reference = reference_of(subject);
    const std::vector<Seen> seen = seen_of(subject);
    for (std::size_t r = 0; r < rungs.size(); ++r) {
      progress.update("pictures", static_cast<double>(r) / static_cast<double>(rungs.size()));
      measure_tables(subject, seen, rungs[r]);
      measure_picture(subject, reference, options.rounds.value_or(5), rungs[r]);
    }
  }
  Ladder ladder{.name = "render_bench",
                .about = {{"scene", options.sensor},
                          {"sensor", options.scene},
                          {"samples", {camera.width, camera.height}},
                          {"facets", scene.rays->facets().size()}},
                .table = table_of(rungs)};
  for (const PictureRung& rung : rungs) {
    ladder.rows.push_back(row_of(rung));
    if (rung.tables > rung.promised)
      ladder.broken.push_back("tables of tolerance " + significant(rung.tolerance, 2) + ": promised " +
                              significant(rung.promised, 3) + ", realised " + significant(rung.tables, 3));
  }
  Figure figure =
      figure_of(ladder, " of a picture", 1.0, {{"sampling, rms", "sampling_rms"}, {"tables, largest", "tables_error"}});
  figure.x_label = "time of a picture [ms], minimum of the rounds";
  figure.y_label = "rms error / standard deviation, or relative";
  return write_ladder(ladder, figure, rungs.front().ms.size(), options, global, outputs);
}

}  // namespace apps
