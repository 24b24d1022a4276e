// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/tiles/simulate_tiles.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "apps/simulate/scene_source.h"
#include "apps/simulate/sensor_run.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/image_formats.h"
#include "mtf/io/image_windows.h"
#include "mtf/io/tile_store.h"
#include "mtf/parallel.h"
#include "mtf/survey/bad_pixels.h"
#include "mtf/tiles/tiles.h"
#include "mtf/version.h"
#include "mtf/work/heap.h"
#include "radiometry/chain/chain_tiles.h"

namespace apps {
namespace {

// The scene of a run in tiles: in memory or, where memory is limited, as windows of its file.

constexpr std::int64_t kSurveyShare = 8;      // of the memory that rows may take while the scene is surveyed
constexpr std::size_t kChannelsTogether = 4;  // in one pass: each has running sums of its coarse image
constexpr std::size_t kHeaderBytes = 65536;   // of a scene file, for telling it from another

struct TileScene {
  mtf::io::Scene scene;
  std::optional<mtf::io::ImageWindows> file;
  std::vector<mtf::ImageView<const float>> planes;
  mtf::ReadWindow read;
};

/// Why a scene, an output or a treatment of bad pixels needs the whole image, as the message of an error; "" where the
/// scene can be read and the image be written in pieces.
std::string refusal_of_windows(const SimulateOptions& options, const SceneSource& file) {
  if (file.image)
    return "--memory: " + one_line(file.file) +
           " is in memory already; name a file of the scene, or leave out the limit";
  if (const mtf::io::ImageFormat& format = mtf::io::row_of(mtf::io::detect_format(file.file)); !format.in_pieces())
    return "--memory: " + one_line(file.file) + " is " + std::string(format.name) +
           ", which cannot be read in pieces; convert it to OpenEXR or ENVI";
  if (!options.out.empty() && !mtf::io::holds_floats(mtf::io::format_from_extension(options.out)))
    return "--memory: tiles are written as OpenEXR or ENVI; end the name of the output in .exr or .hdr";
  if (options.nan != NanPolicy::refuse)
    return "--nan: fill and propagate need the whole image; leave out --memory, or replace such pixels before";
  return "";
}

/// Opens the file of a scene that is read in windows; `scene` stays where it is. Throws UsageError with
/// refusal_of_windows().
void open_windows(const SimulateOptions& options, const mtf::io::SensorConfig& config, const SceneSource& file,
                  TileScene& source) {
  if (const std::string refusal = refusal_of_windows(options, file); !refusal.empty()) throw mtf::UsageError(refusal);
  source.file.emplace(file.file, file.read);
  source.scene = mtf::io::describe_scene(config, file.file, source.file->file());
  source.read = [&source](std::size_t channel, std::int64_t x, std::int64_t y, mtf::ImageView<float> out) {
    source.file->read(channel, x, y, out);
    mtf::io::make_physical(source.scene, out);
  };
}

struct SceneSurvey {
  mtf::Border border = mtf::Border::reflect;
  double border_value = 0.0;
  std::int64_t every = 0;   ///< scene samples for one of the coarse image, 0 = none
  std::int64_t memory = 0;  ///< an eighth of it is for rows; 0 = as many as are read together
  int threads = 0;
  std::string_view step = "survey";  ///< its name in progress
  bool computed = false;             ///< the samples are made of finite ones: those that are not finite exceed float32
};

/// Every channel surveyed, within the memory that rows may take. Throws RuntimeError for samples that are not finite.
std::vector<mtf::Survey> survey_all(TileScene& source, const SceneSurvey& asked, RunWatch& watch) {
  mtf::SurveyOptions survey_options{
      .border = asked.border, .border_value = asked.border_value, .every = asked.every, .threads = asked.threads};
  if (source.file) {
    const std::int64_t row_bytes =
        source.scene.grid.width * static_cast<std::int64_t>(source.scene.names.size() * sizeof(float));
    if (asked.memory > 0)
      survey_options.band_rows =
          std::clamp<std::int64_t>(asked.memory / kSurveyShare / row_bytes, 1, survey_options.band_rows);
    source.file->keep_rows(survey_options.band_rows);
  }
  const std::size_t channels = source.scene.names.size();
  std::vector<mtf::Survey> surveys;
  for (std::size_t first = 0; first < channels; first += kChannelsTogether) {
    const std::size_t count = std::min(kChannelsTogether, channels - first);
    survey_options.progress = [&](std::int64_t row) {
      const double share = static_cast<double>(row) / static_cast<double>(source.scene.grid.height);
      watch.share(asked.step,
                  (static_cast<double>(first) + share * static_cast<double>(count)) / static_cast<double>(channels));
    };
    for (mtf::Survey& survey : mtf::survey_channels(source.read, first, count, source.scene.grid, survey_options))
      surveys.push_back(std::move(survey));
  }
  for (std::size_t c = 0; c < channels; ++c) {
    const mtf::Statistics& s = surveys[c].statistics;
    if (s.not_finite > 0 && asked.computed) refuse_overflow(source.scene.names[c]);
    if (s.not_finite > 0)
      throw mtf::RuntimeError("channel " + one_line(source.scene.names[c]) + ": " + std::to_string(s.not_finite) +
                              " pixels are NaN or infinite, the first at column " + std::to_string(s.first_x) +
                              ", row " + std::to_string(s.first_y) +
                              "; replace them before, or run without --memory "
                              "and with --nan fill|propagate");
  }
  return surveys;
}

/// Size of a file and when it was changed.
std::string stamp_of(const std::string& file) {
  struct stat status {};
  static_cast<void>(::stat(file.c_str(), &status));
  return std::to_string(status.st_size) + " " + std::to_string(status.st_mtim.tv_sec) + "." +
         std::to_string(status.st_mtim.tv_nsec);
}

/// All that the pixels of a run in tiles depend on; `stage` is that of a chain whose output they are, "" without one.
std::string key_of(const SimulateOptions& options, const mtf::io::SensorConfig& config, const std::string& file,
                   const TileScene& source, const std::vector<mtf::Survey>& surveys, const mtf::TiledSensorPlan& plan,
                   const std::string& stage) {
  std::string header(kHeaderBytes, '\0');
  if (std::FILE* handle = std::fopen(file.c_str(), "rb")) {
    header.resize(std::fread(header.data(), 1, header.size(), handle));
    std::fclose(handle);
  }
  const mtf::TileReport& r = plan.report();
  std::string key = std::string(mtf::version) + " " + mtf::git_commit + " " + config.sha256 + " " +
                    joined(mtf::io::files_of_image(file), stamp_of, " ") + " " + mtf::format_double(r.tolerance) + " " +
                    (options.measure ? "measure" : "estimate") + " " + stage;
  for (const std::string& curve : files_of(config)) key += " " + stamp_of(curve);  // that the sensor file names
  if (options.region)
    for (const std::int64_t number : *options.region) key += " " + std::to_string(number);
  for (const std::string& name : source.scene.names) key += " [" + name + "]";
  for (const mtf::Survey& survey : surveys) key += " " + std::to_string(survey.fingerprint);
  return key + " " + std::to_string(r.every) + " " + header;
}

// A sensor in a run in tiles (radiometry/chain/chain_tiles.h): which sensors and scenes can go through it, the scene's
// windows as light, and each tile from light to the output stage, with one report for all. Of a linear sensor the
// windows are light as they are, and the filtered tile is the output.

/// The counts of a frame that reports sum up, in the order in which they are kept with a tile.
template <class Frame>
auto counts_in(Frame& frame) {
  return std::array{&frame.well.low,
                    &frame.well.high,
                    &frame.adc.low,
                    &frame.adc.high,
                    &frame.held.pixels,
                    &frame.held.full_well,
                    &frame.held.most_count,
                    &frame.held.least_count,
                    &frame.held_defects.pixels,
                    &frame.held_defects.full_well,
                    &frame.held_defects.most_count,
                    &frame.held_defects.least_count};
}

mtf::io::TileCounts counts_of(const radiometry::ChainFrame& frame) {
  mtf::io::TileCounts counts;
  for (const std::int64_t* count : counts_in(frame)) counts.push_back(*count);
  return counts;
}

/// What comes after the filters of the tiles of one run, and what it has counted in all of them.
class ChainOfTiles {
 public:
  using Planes = std::span<const mtf::ImageView<const float>>;
  /// Takes a finished tile and what has been counted in it. Called from several threads at once.
  using Take = std::function<void(const mtf::Tile& tile, Planes planes, const mtf::io::TileCounts& counts)>;

  /// `first` is the pixel of the detector at which the output of `plan` starts. The counts go to `report`, that of the
  /// sensor, which lives longer. Throws UsageError as TiledChain.
  ChainOfTiles(const SensorRun& sensor, const mtf::TiledSensorPlan& plan, radiometry::Origin first, int threads,
               std::optional<ChainReport>& report)
      : first_(first), threads_(std::max(1, mtf::threads_of(threads) / plan.report().in_flight)), report_(report) {
    const RadiometricChain* chain = sensor.chain();
    if (chain == nullptr) return;
    const mtf::SampleGrid whole = mtf::detector_grid(sensor.config().system, plan.in());
    at_its_place(sensor.config(), [&] {
      chain_.emplace(plan.inner(), chain->system, chain->loaded.sensor, whole.width, whole.height, chain->stage);
    });
  }

  /// Filtered light to the output stage. From several threads at once.
  void run(const mtf::Tile& tile, Planes filtered, const Take& take) {
    if (!chain_) return take(tile, filtered, {});
    const radiometry::ChainFrame frame =
        chain_->run(copy_of(filtered.front()), {first_.x + tile.region.x, first_.y + tile.region.y}, 0, threads_);
    {
      const std::scoped_lock guard(lock_);
      report_->add(frame);
      for (const auto& [stage, ms] : frame.timing_ms) radiometry::add_time(report_->timing_ms, stage, ms);
    }
    const mtf::ImageView<const float> output = frame.image.view();
    take(tile, {&output, 1}, counts_of(frame));
  }
  /// How many counts there are.
  std::size_t counts_a_tile() const { return chain_ ? counts_of({}).size() : 0; }
  /// Adds what a stopped run counted in a tile.
  void add(const mtf::io::TileCounts& counts) {
    if (!chain_) return;
    radiometry::ChainFrame frame;
    const auto places = counts_in(frame);
    for (std::size_t i = 0; i < counts.size(); ++i) *places[i] = counts[i];
    report_->add(frame);
  }

 private:
  std::optional<radiometry::TiledChain> chain_;
  radiometry::Origin first_;
  int threads_;
  std::mutex lock_;
  std::optional<ChainReport>& report_;
};

/// The last output stage before the one wanted whose image can be made in tiles.
std::optional<radiometry::OutputStage> earlier_stage(const RadiometricChain& chain) {
  using radiometry::OutputStage;
  const radiometry::Sensor& sensor = chain.loaded.sensor;
  for (int i = static_cast<int>(chain.stage) - 1; i >= 0; --i) {
    const auto stage = static_cast<OutputStage>(i);
    if (stage == OutputStage::dn && !sensor.settings.adc) continue;
    if (!may_have_stage(stage, sensor.settings.thermal.has_value())) continue;
    if (whole_image_stages(chain.system, sensor, stage).empty()) return stage;
  }
  return std::nullopt;
}

/// radiometry::whole_image_stages() up to the image that is wanted; "" of a linear sensor.
std::string stages_of_the_whole(const SensorRun& sensor) {
  const RadiometricChain* chain = sensor.chain();
  return chain ? whole_image_stages(chain->system, chain->loaded.sensor, chain->stage) : std::string();
}

/// Throws UsageError for a sensor with such stages: it names them, and the last output stage before them.
void require_tileable(const SensorRun& sensor) {
  const std::string whole = stages_of_the_whole(sensor);
  if (whole.empty()) return;
  const auto stage = earlier_stage(*sensor.chain());
  throw mtf::UsageError("--memory: the image goes through in tiles, and these stages of " +
                        one_line(sensor.config().file) + " need all of it at once: " + whole +
                        "; leave out --memory, or remove their tables" +
                        (stage ? ", or take the image before them with --stage " + output_stage_name(*stage) : ""));
}

/// What of a sensor's filters tiles do themselves: all of a linear sensor, presample OTF and sampling before a chain.
mtf::System<double> tiled_system(const SensorRun& sensor) {
  mtf::System<double> system = sensor.system();
  if (sensor.is_linear()) return system;
  system.list(mtf::Stage::readout).clear();
  system.list(mtf::Stage::postsample).clear();
  return system;
}

/// From now on the windows of `source` are light. Reads the whole scene once, after the checks of the sensor's maps.
/// Returns what a constant border is worth. Throws UsageError as require_light_of_windows, require_maps and
/// light_of_windows.
double read_as_light(const SensorRun& sensor, const std::string& file, TileScene& source, std::int64_t memory,
                     int threads, RunWatch& watch) {
  const mtf::io::SensorConfig& config = sensor.config();
  if (sensor.is_linear()) return config.scene.border_value;
  const LoadedSensor& loaded = sensor.chain()->loaded;
  require_light_of_windows(config, loaded, source.scene, one_line(file));
  const mtf::SampleGrid detector = mtf::detector_grid(config.system, source.scene.grid);
  at_its_place(config, [&] { require_maps(loaded.sensor, detector.width, detector.height); });
  const std::vector<mtf::Survey> values =
      survey_all(source, {.every = 0, .memory = memory, .threads = threads, .step = "range"}, watch);
  const LightOfWindows light =
      at_its_place(config, [&] { return light_of_windows(config, loaded, source.scene, values.front().statistics); });
  source.read = [values_of = std::move(source.read), convert = light.convert](
                    std::size_t channel, std::int64_t x, std::int64_t y, mtf::ImageView<float> out) {
    values_of(channel, x, y, out);
    convert(out);
  };
  return light.border_value;
}

/// What the chain needs beside the plan of the tiles.
void count_memory(const SensorRun& sensor, mtf::TileOptions& options) {
  if (sensor.is_linear()) return;
  const RadiometricChain& chain = *sensor.chain();
  options.receiver_bytes = tile_bytes_a_pixel(chain.system, chain.loaded.sensor);
  options.held_bytes = map_bytes(chain.loaded.sensor);
}

using Planes = ChainOfTiles::Planes;

/// The summary that makes the promise hardest to keep, of all channels.
std::optional<mtf::SceneSummary> worst_of(const std::vector<mtf::Survey>& surveys, mtf::Border border,
                                          double border_value) {
  std::optional<mtf::SceneSummary> worst;
  for (const mtf::Survey& survey : surveys) worst = harder_of(worst, survey.summary(border, border_value));
  return worst;
}

// That the scene holds, whatever format the sensor has.
std::array<std::int64_t, 2> whole_pixels(const mtf::io::SensorConfig& config, const mtf::SampleGrid& scene) {
  mtf::System<double> system = config.system;
  system.frame.columns = system.frame.rows = 0;
  const mtf::SampleGrid detector = mtf::detector_grid(system, scene);
  return {detector.width, detector.height};
}

// Pixels that are NaN because bad samples blur into them need the whole image and its plan.
std::vector<mtf::Image> run_whole(const mtf::io::SensorConfig& config, TileScene& source,
                                  const std::vector<mtf::Image>& masks, const mtf::PlanOptions& options,
                                  const std::array<std::int64_t, 4>& region) {
  const mtf::SensorPlan plan = mtf::compile_sensor(config.system, source.scene.grid, options);
  std::vector<mtf::Image> images = plan.run(std::move(source.scene.planes), config.scene.border_value, options.threads);
  for (std::size_t c = 0; c < images.size(); ++c) {
    if (masks[c].size() > 0)
      mtf::propagate_bad_pixels(plan, masks[c], options.tolerance, options.threads, images[c].view());
    images[c] = cropped(images[c], region);
  }
  return images;
}

struct SurveyedPlan {
  std::vector<mtf::Survey> surveys;
  mtf::PlanOptions options;  ///< with the tolerance that the plan keeps
  mtf::TiledSensorPlan plan;
};

/// A run in tiles that is ready: read, surveyed, compiled.
struct TileRun {
  const SensorRun& sensor;
  const SceneSource& file;
  const SimulateOptions& options;
  TileScene& source;
  const SurveyedPlan& planned;
  ChainOfTiles& chain;
  mtf::TileRunOptions run;
  RunWatch& watch;
  SimulateResult& result;
};

void run_tiles(
    TileRun& all, const ChainOfTiles::Take& take, const std::function<void()>& before_refusal = [] {}) {
  const auto finite = [&](const mtf::Tile& tile, Planes planes, const mtf::io::TileCounts& counts) {
    for (std::size_t c = 0; c < planes.size(); ++c) {
      if (mtf::all_finite(planes[c])) continue;
      before_refusal();
      refuse_overflow(all.source.scene.names[c]);
    }
    take(tile, planes, counts);
  };
  RunReport& report = all.result.report;
  report.tiles->tally = all.planned.plan.run(
      all.source.read, all.planned.surveys,
      [&](const mtf::Tile& tile, Planes planes) { all.chain.run(tile, planes, finite); }, all.run);
  if (!report.chain) return;
  if (report.chain->held.any()) all.watch.warn(words(report.chain->held));
  all.watch.warn(correction_warning(report.chain->correction));
}

std::vector<mtf::Image> run_to_memory(TileRun& all) {
  const mtf::SampleGrid& out = all.planned.plan.out();
  std::vector<mtf::Image> images;
  for (std::size_t c = 0; c < all.planned.surveys.size(); ++c) images.emplace_back(out.width, out.height);
  run_tiles(all, [&](const mtf::Tile& tile, Planes planes, const mtf::io::TileCounts&) {
    for (std::size_t c = 0; c < planes.size(); ++c) copy(planes[c], part_of(images[c].view(), tile.region));
  });
  return images;
}

void run_to_sink(TileRun& all, const mtf::io::Metadata& metadata) {
  run_tiles(all, [&](const mtf::Tile& tile, Planes planes, const mtf::io::TileCounts&) {
    all.options.sink({0, tile.region, all.result.names, planes, metadata});
  });
}

/// Finished tiles are kept beside the file until all are there, and the image is written from them.
void run_to_file(TileRun& all, const mtf::io::Metadata& metadata) {
  const mtf::TiledSensorPlan& plan = all.planned.plan;
  const std::vector<std::string>& names = all.result.names;
  mtf::io::TileStore store(all.options.out,
                           {key_of(all.options, all.sensor.config(), all.file.file, all.source, all.planned.surveys,
                                   plan, all.result.report.chain ? all.result.report.chain->stage : ""),
                            plan.out().width, plan.out().height, names.size(), plan.report().count,
                            all.chain.counts_a_tile(), [&](std::int64_t i) { return plan.tile(i).region; }},
                           all.options.resume);
  if (!store.note().empty()) all.watch.note(store.note());
  if (store.resumed() > 0)
    all.watch.note(std::to_string(store.resumed()) + " of " + std::to_string(plan.report().count) +
                   " tiles are there from a stopped run");
  for (const mtf::io::TileCounts& counts : store.resumed_counts()) all.chain.add(counts);
  all.run.done = [&](std::int64_t i) { return store.done(i); };
  run_tiles(
      all,
      [&](const mtf::Tile& tile, Planes planes, const mtf::io::TileCounts& counts) {
        store.write(tile.index, planes, counts);
      },
      [&] { store.remove(); });  // the same run will not do better
  all.watch.lap("run");
  mtf::io::write_float_rows(
      all.options.out, names, plan.out().width, plan.out().height,
      [&](std::int64_t first, std::span<const mtf::ImageView<float>> planes) {
        for (std::size_t c = 0; c < planes.size(); ++c) store.read_rows(c, first, planes[c]);
        all.watch.share("write", static_cast<double>(first) / static_cast<double>(plan.out().height));
      },
      metadata, all.options.threads);
  for (std::size_t c = 0; c < names.size(); ++c)
    all.result.statistics.push_back(mtf::survey([&](std::size_t plane, std::int64_t, std::int64_t y,
                                                    mtf::ImageView<float> rows) { store.read_rows(plane, y, rows); },
                                                c, plan.out(), {.threads = all.options.threads})
                                        .statistics);
  store.remove();
}

/// Opens the scene's file for windows of it or, for a region of a sensor without a chain, reads all its planes. Returns
/// the masks of the bad pixels of planes.
std::vector<mtf::Image> open_scene(const mtf::io::SensorConfig& config, SceneSource& file,
                                   const SimulateOptions& options, bool windows, TileScene& source, RunReport& report,
                                   RunWatch& watch) {
  if (windows) {
    if (options.memory) mtf::set_heap({.returned_from = 256 << 10, .kept_at_end = 1 << 20});
    open_windows(options, config, file, source);
    return {};
  }
  source.scene = take_scene(config, file);
  std::vector<mtf::Image> masks = treat_bad_pixels(source.scene, options.nan, report.bad_pixels);
  if (!report.bad_pixels.empty()) watch.note(report.bad_pixels);
  for (const mtf::Image& plane : source.scene.planes) source.planes.push_back(plane.view());
  source.read = mtf::windows_of(source.planes);
  return masks;
}

/// The region that is wanted; empty for the whole image.
mtf::Region region_of(const SimulateOptions& options) {
  if (!options.region) return {};
  const auto& [x, y, width, height] = *options.region;
  return {x, y, width, height};
}

mtf::TileOptions tile_options_of(const SimulateOptions& options, const TileScene& source, const SensorRun& sensor) {
  mtf::TileOptions tiles;
  tiles.memory = options.memory.value_or(0);
  tiles.threads = options.threads;
  if (source.file) {
    tiles.row_bytes = source.file->row_bytes();
    tiles.more_rows = source.file->more_rows();
  }
  tiles.channels = static_cast<std::int64_t>(source.scene.names.size());
  if (options.region) tiles.region = region_of(options);
  count_memory(sensor, tiles);
  return tiles;
}

/// Surveys the samples that are filtered, and compiles the plan of their tiles.
SurveyedPlan survey_and_plan(const SensorRun& sensor, const SimulateOptions& options, double border_value,
                             TileScene& source, RunReport& report, RunWatch& watch) {
  const mtf::SampleGrid& grid = source.scene.grid;
  const mtf::TileOptions tiles = tile_options_of(options, source, sensor);
  const mtf::Border border = sensor.config().scene.border;
  std::vector<mtf::Survey> surveys = survey_all(source,
                                                {.border = border,
                                                 .border_value = border_value,
                                                 .every = mtf::coarse_every(grid, border, tiles.memory),
                                                 .memory = tiles.memory,
                                                 .threads = options.threads,
                                                 .computed = !sensor.is_linear()},
                                                watch);
  mtf::PlanOptions plan_options =
      plan_options_of(options, sensor, source.scene, worst_of(surveys, border, border_value));
  if (plan_options.device.device)
    watch.note("an image in tiles is the processor's work, not that of " + plan_options.device.device->info().name);
  plan_options.device = {};
  plan_options.progress = watch.planning();
  watch.lap("survey");
  mtf::TiledSensorPlan plan =
      compile_reachable(options.tolerance.has_value(), sensor, plan_options, report.warnings,
                        [&] { return mtf::compile_tiled(tiled_system(sensor), grid, plan_options, tiles); });
  if (source.file)
    source.file->keep_rows(plan.report().whole ? source.file->more_rows() : plan.inner().presample.in().height);
  plan_options.progress = {};
  for (const std::string& warning : report.warnings) watch.tell_warning(warning);
  watch.lap("plan");
  return {std::move(surveys), std::move(plan_options), std::move(plan)};
}

mtf::io::Metadata metadata_of(const SensorRun& sensor, const SimulateOptions& options, const mtf::io::Scene& scene,
                              const SurveyedPlan& planned) {
  return sensor.metadata(scene, planned.plan.inner(), planned.options.tolerance, 0, options.region);
}

/// Hands the planes of an image in memory over: to the file, to the sink, or in the result.
void deliver_image(TileRun& all, SimulatedImage image) {
  SimulateResult& result = all.result;
  for (const mtf::Image& plane : image.planes) result.statistics.push_back(mtf::statistics(plane.view()));
  all.watch.describe_integers(
      deliver(all.options, all.options.out, result.names, image, all.sensor.integer_range(all.options.range)));
  if (!image.planes.empty()) result.images.push_back(std::move(image));
}

}  // namespace

std::optional<mtf::TiledSensorPlan> flat_tiles(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene,
                                               const mtf::PlanOptions& options, RunReport& report) try {
  std::vector<mtf::ImageView<const float>> planes;
  for (const mtf::Image& plane : scene.planes) planes.push_back(plane.view());
  auto plan = mtf::worth_tiling(config.system, scene.grid, planes, config.scene.border_value, options);
  if (!plan) return plan;
  report.tiles = TilesReport{plan->report(), {}, scene.grid, plan->out(), whole_pixels(config, scene.grid), true};
  return plan;
} catch (const mtf::UnreachableTolerance&) {
  return std::nullopt;  // the whole image may keep it, or says what it can
}

bool wants_tiles(const SensorRun& sensor, const SceneSource& scene, const SimulateOptions& options, double usable) {
  if (options.memory || (options.region && sensor.is_linear())) return true;
  if (!refusal_of_windows(options, scene).empty()) return false;
  // Planes of three channels, transforms and OTF of one, about.
  const mtf::io::FileInfo info = mtf::io::read_info_of(scene.file, scene.read.part);
  if (static_cast<double>(info.width) * static_cast<double>(info.height) * 20.0 <= usable) return false;
  if (sensor.is_linear()) return true;
  if (!stages_of_the_whole(sensor).empty()) return false;
  TileScene source;
  open_windows(options, sensor.config(), scene, source);
  return refusal_of_light(sensor.config(), sensor.chain()->loaded, source.scene).empty();
}

SimulateResult simulate_tiles(const SensorRun& sensor, SceneSource& file, const SimulateOptions& options) {
  const mtf::io::SensorConfig& config = sensor.config();
  SimulateResult result;
  RunReport& report = result.report;
  RunWatch watch(options, report);
  const bool windows = options.memory || !options.region || !sensor.is_linear();
  require_tileable(sensor);
  TileScene source;
  const std::vector<mtf::Image> masks = open_scene(config, file, options, windows, source, report, watch);
  const mtf::io::Scene& scene = source.scene;
  const double border_value =
      read_as_light(sensor, file.file, source, options.memory.value_or(0), options.threads, watch);
  report.warnings = warnings_of(sensor, scene);
  const SurveyedPlan planned = survey_and_plan(sensor, options, border_value, source, report, watch);
  const mtf::TiledSensorPlan& plan = planned.plan;

  result.names = output_names(scene.names);
  describe_run(report, config, facts_of(scene), file.file, options, planned.options.tolerance);
  report.plan = std::make_shared<const mtf::SensorPlan>(plan.inner());
  report.tiles = TilesReport{plan.report(), {}, scene.grid, plan.out(), whole_pixels(config, scene.grid), false};
  report.chain = sensor.report();
  const mtf::Region region = region_of(options);
  ChainOfTiles chain(sensor, plan, {region.x, region.y}, options.threads, report.chain);
  TileRun run{sensor, file, options, source, planned, chain, {.border_value = border_value}, watch, result};
  run.run.progress = [&](std::int64_t done, std::int64_t of) {
    watch.share("tiles", static_cast<double>(done) / static_cast<double>(of));
  };
  if (options.measure)
    watch.note("--rigor measure chose methods and FFT plans by timing; results may differ between runs");

  SimulatedImage image;
  image.metadata = metadata_of(sensor, options, scene, planned);
  const bool any_bad = std::any_of(masks.begin(), masks.end(), [](const mtf::Image& mask) { return mask.size() > 0; });
  if (windows && !options.out.empty()) {
    run_to_file(run, image.metadata);
  } else if (!any_bad && options.out.empty() && options.sink) {
    run_to_sink(run, image.metadata);
    watch.lap("run");
  } else {
    image.planes = any_bad ? run_whole(config, source, masks, planned.options, *options.region) : run_to_memory(run);
    watch.lap("run");
    deliver_image(run, std::move(image));
  }
  watch.lap("write");
  return result;
}

}  // namespace apps
