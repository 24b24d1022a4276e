// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/simulate_tiles.h"

#include <malloc.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "apps/measured_file.h"
#include "apps/sensor/sensor_file.h"
#include "apps/simulate/radiometric_chain.h"
#include "apps/simulate/run_summary.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/exr/exr_windows.h"
#include "mtf/io/tile_store.h"
#include "mtf/survey/bad_pixels.h"
#include "mtf/survey/statistics.h"
#include "mtf/version.h"

namespace apps {
namespace {

using Clock = std::chrono::steady_clock;

// The C library keeps freed blocks of tiles for later ones of other sizes, beyond what the limit allows.
void return_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 256 << 10);
  mallopt(M_TRIM_THRESHOLD, 1 << 20);
#endif
}

constexpr std::int64_t kSurveyShare = 8;      // of the memory that rows may take while the scene is surveyed
constexpr std::size_t kChannelsTogether = 4;  // in one pass: each has running sums of its coarse image
constexpr std::size_t kHeaderBytes = 65536;   // of a scene file, for telling it from another

// A scene in memory or, where memory is limited, as windows of its file.
struct Source {
  mtf::io::Scene scene;
  std::optional<mtf::io::ExrWindows> file;
  std::vector<mtf::ImageView<const float>> planes;
  mtf::ReadWindow read;
};

void open_windows(const SimulateOptions& options, const mtf::io::SensorConfig& config, Source& source) {
  if (mtf::io::detect_format(options.scene) != mtf::io::Format::exr)
    throw mtf::UsageError("--memory: " + one_line(options.scene) +
                          " is no OpenEXR file, which is the format that can be read in pieces; convert it");
  if (mtf::io::format_from_extension(options.out) != mtf::io::Format::exr)
    throw mtf::UsageError("--memory: tiles are written as OpenEXR; end the name of the output in .exr");
  if (options.nan != NanPolicy::refuse)
    throw mtf::UsageError(
        "--nan: fill and propagate look at the whole image; leave out --memory, or replace such "
        "pixels before");
  if (!options.wisdom.empty()) throw mtf::UsageError("--wisdom is for whole images; leave it out with --memory");
  source.file.emplace(options.scene, mtf::io::ReadOptions{options.channel, options.layer, options.part});
  source.scene = mtf::io::describe_scene(config, options.scene, source.file->file());
  source.read = [&source](std::size_t channel, std::int64_t x, std::int64_t y, mtf::ImageView<float> out) {
    source.file->read(channel, x, y, out);
    mtf::io::make_physical(source.scene, out);
  };
}

std::vector<mtf::Survey> survey_all(Source& source, const mtf::io::SceneDefaults& defaults, std::int64_t memory,
                                    const Global& global, ProgressLine& progress) {
  mtf::SurveyOptions survey_options{.border = defaults.border,
                                    .border_value = defaults.border_value,
                                    .every = mtf::coarse_every(source.scene.grid, defaults.border, memory),
                                    .threads = global.threads};
  if (source.file) {
    if (memory > 0)
      survey_options.band_rows =
          std::clamp<std::int64_t>(memory / kSurveyShare / source.file->row_bytes(), 1, survey_options.band_rows);
    source.file->keep_rows(survey_options.band_rows);
  }
  const std::size_t channels = source.scene.names.size();
  std::vector<mtf::Survey> surveys;
  for (std::size_t first = 0; first < channels; first += kChannelsTogether) {
    const std::size_t count = std::min(kChannelsTogether, channels - first);
    survey_options.progress = [&](std::int64_t row) {
      const double share = static_cast<double>(row) / static_cast<double>(source.scene.grid.height);
      progress.update(
          "survey", (static_cast<double>(first) + share * static_cast<double>(count)) / static_cast<double>(channels));
    };
    for (mtf::Survey& survey : mtf::survey_channels(source.read, first, count, source.scene.grid, survey_options))
      surveys.push_back(std::move(survey));
  }
  for (std::size_t c = 0; c < channels; ++c) {
    const mtf::Statistics& s = surveys[c].statistics;
    if (s.not_finite > 0)
      throw mtf::RuntimeError("channel " + one_line(source.scene.names[c]) + ": " + std::to_string(s.not_finite) +
                              " pixels are NaN or infinite, the first at column " + std::to_string(s.first_x) +
                              ", row " + std::to_string(s.first_y) +
                              "; replace them before, or run without --memory "
                              "and with --nan fill|propagate");
  }
  return surveys;
}

std::optional<mtf::SceneSummary> worst_of(const std::vector<mtf::Survey>& surveys,
                                          const mtf::io::SceneDefaults& defaults) {
  std::optional<mtf::SceneSummary> worst;
  for (const mtf::Survey& survey : surveys)
    worst = harder_of(worst, survey.summary(defaults.border, defaults.border_value));
  return worst;
}

// That the scene holds, whatever format the sensor has.
std::array<std::int64_t, 2> whole_pixels(const mtf::io::SensorConfig& config, const mtf::SampleGrid& scene) {
  mtf::System<double> system = config.system;
  system.frame.columns = system.frame.rows = 0;
  const mtf::SampleGrid detector = mtf::detector_grid(system, scene);
  return {detector.width, detector.height};
}

// All that the pixels depend on.
std::string key_of(const SimulateOptions& options, const mtf::io::SensorConfig& config, const Source& source,
                   const std::vector<mtf::Survey>& surveys, const mtf::TiledSensorPlan& plan) {
  struct stat status {};
  static_cast<void>(::stat(options.scene.c_str(), &status));
  std::string header(kHeaderBytes, '\0');
  if (std::FILE* file = std::fopen(options.scene.c_str(), "rb")) {
    header.resize(std::fread(header.data(), 1, header.size(), file));
    std::fclose(file);
  }
  const mtf::TileReport& r = plan.report();
  std::string key = std::string(mtf::version) + " " + mtf::git_commit + " " + config.sha256 + " " +
                    std::to_string(status.st_size) + " " + std::to_string(status.st_mtim.tv_sec) + "." +
                    std::to_string(status.st_mtim.tv_nsec) + " " + mtf::format_double(r.tolerance) + " " +
                    (options.measure ? "measure" : "estimate");
  for (const std::string& file : files_of(config)) {  // curves that the sensor file names
    struct stat part {};
    static_cast<void>(::stat(file.c_str(), &part));
    key += " " + std::to_string(part.st_size) + " " + std::to_string(part.st_mtim.tv_sec) + "." +
           std::to_string(part.st_mtim.tv_nsec);
  }
  for (const std::string& name : source.scene.names) key += " [" + name + "]";
  for (const mtf::Survey& survey : surveys) key += " " + std::to_string(survey.fingerprint);
  return key + " " + std::to_string(r.every) + " " + header;
}

// The first channel with values beyond float32.
std::optional<std::size_t> overflowing(std::span<const mtf::ImageView<const float>> planes) {
  for (std::size_t c = 0; c < planes.size(); ++c)
    if (!mtf::all_finite(planes[c])) return c;
  return std::nullopt;
}

// Pixels that are NaN where bad samples reach them need the whole image and its plan.
std::vector<mtf::Image> run_whole(const mtf::io::SensorConfig& config, Source& source,
                                  const std::vector<mtf::Image>& masks, const mtf::PlanOptions& options,
                                  const mtf::Region& region) {
  const mtf::SensorPlan plan = mtf::compile_sensor(config.system, source.scene.grid, options);
  std::vector<mtf::Image> images = plan.run(std::move(source.scene.planes), config.scene.border_value, options.threads);
  for (std::size_t c = 0; c < images.size(); ++c) {
    if (masks[c].size() > 0)
      mtf::propagate_bad_pixels(plan, masks[c], options.tolerance, options.threads, images[c].view());
    mtf::Image cut(region.width, region.height);
    for (std::int64_t y = 0; y < region.height; ++y)
      std::memcpy(cut.view().row(y), images[c].view().row(region.y + y) + region.x,
                  static_cast<std::size_t>(region.width) * sizeof(float));
    images[c] = std::move(cut);
  }
  return images;
}

std::vector<mtf::Image> run_in_memory(const mtf::io::SensorConfig& config, Source& source,
                                      const std::vector<mtf::Survey>& surveys, const std::vector<mtf::Image>& masks,
                                      const mtf::TiledSensorPlan& plan, const mtf::PlanOptions& options,
                                      const mtf::TileRunOptions& run, const mtf::Region& region, RunReport& report) {
  if (std::any_of(masks.begin(), masks.end(), [](const mtf::Image& mask) { return mask.size() > 0; }))
    return run_whole(config, source, masks, options, region);
  std::vector<mtf::Image> images;
  for (std::size_t c = 0; c < surveys.size(); ++c) images.emplace_back(plan.out().width, plan.out().height);
  report.tiles->tally = plan.run(
      source.read, surveys,
      [&](const mtf::Tile& tile, std::span<const mtf::ImageView<const float>> planes) {
        if (const auto c = overflowing(planes)) refuse_overflow(source.scene.names[*c]);
        for (std::size_t c = 0; c < planes.size(); ++c)
          for (std::int64_t y = 0; y < tile.region.height; ++y)
            std::memcpy(images[c].view().row(tile.region.y + y) + tile.region.x, planes[c].row(y),
                        static_cast<std::size_t>(tile.region.width) * sizeof(float));
      },
      run);
  return images;
}

std::string summary_text(const RunReport& report, const std::vector<std::string>& names,
                         const std::vector<mtf::Statistics>& statistics) {
  const TilesReport& tiles = *report.tiles;
  const auto by = [](const std::array<std::int64_t, 2>& n) {
    return std::to_string(n[0]) + "x" + std::to_string(n[1]);
  };
  std::string text = summary_head(report, tiles.out) + summary_channels(names, statistics);
  if (tiles.plan.whole)
    text += "one tile: " + tiles.plan.reason + "\n";
  else
    text += std::to_string(tiles.plan.count) + " tiles of " + by(tiles.plan.side) + " px, halo " + by(tiles.plan.halo) +
            " samples; " + std::to_string(tiles.tally.flat) + " flat, " + std::to_string(tiles.tally.resumed) +
            " from a stopped run\n";
  return text + summary_costs(report) + ", peak memory " + fixed(peak_rss_mib(), 0) + " MiB\n";
}

}  // namespace

std::optional<mtf::TiledSensorPlan> flat_tiles(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene,
                                               const std::vector<mtf::Image>& masks, const mtf::PlanOptions& options,
                                               RunReport& report) try {
  if (std::any_of(masks.begin(), masks.end(), [](const mtf::Image& mask) { return mask.size() > 0; }))
    return std::nullopt;
  std::vector<mtf::ImageView<const float>> planes;
  for (const mtf::Image& plane : scene.planes) planes.push_back(plane.view());
  auto plan = mtf::worth_tiling(config.system, scene.grid, planes, config.scene.border_value, options);
  if (!plan) return plan;
  report.tiles = TilesReport{plan->report(), {}, scene.grid, plan->out(), whole_pixels(config, scene.grid)};
  return plan;
} catch (const mtf::UnreachableTolerance&) {
  return std::nullopt;  // the whole image may keep it, or says what it can
}

std::vector<mtf::Image> run_flat_tiles(const mtf::TiledSensorPlan& plan, const mtf::io::Scene& scene,
                                       double border_value, RunReport& report) {
  std::vector<mtf::ImageView<const float>> planes;
  for (const mtf::Image& plane : scene.planes) planes.push_back(plane.view());
  return plan.run(planes, border_value, &report.tiles->tally);
}

bool wants_tiles(const SimulateOptions& options) {
  if (options.memory || options.region) return true;
  if (mtf::io::detect_format(options.scene) != mtf::io::Format::exr) return false;
  // Planes of three channels, transforms and OTF of one, about.
  const mtf::io::FileInfo info = mtf::io::read_info(options.scene);
  const double machine = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  return static_cast<double>(info.width) * static_cast<double>(info.height) * 20.0 > machine;
}

int simulate_tiles(const SimulateOptions& options, const Global& global, const mtf::io::SensorConfig& config) {
  RunReport report;
  Clock::time_point last = Clock::now();
  const auto lap = [&](const char* name) {
    const Clock::time_point now = Clock::now();
    report.timing_ms.emplace_back(name, std::chrono::duration<double, std::milli>(now - last).count());
    last = now;
  };
  const bool streamed = options.memory || !options.region;
  Source source;
  std::vector<mtf::Image> masks;
  if (streamed) {
    if (options.memory) return_freed_memory();
    open_windows(options, config, source);
  } else {
    source.scene = mtf::io::load_scene(config, options.scene, {options.channel, options.layer, options.part});
    masks = treat_bad_pixels(source.scene, options.nan, report.bad_pixels);
    if (!report.bad_pixels.empty()) note(global, "note: " + report.bad_pixels);
    for (const mtf::Image& plane : source.scene.planes) source.planes.push_back(plane.view());
    source.read = mtf::windows_of(source.planes);
  }
  const mtf::io::Scene& scene = source.scene;
  report.warnings = scene.warnings;
  for (std::string& warning : mtf::io::sampling_warnings(config.system, scene.grid))
    report.warnings.push_back(std::move(warning));

  std::optional<ProgressLine> progress(global);
  mtf::PlanOptions plan_options;
  plan_options.tolerance = options.tolerance.value_or(plan_options.tolerance);
  plan_options.border = config.scene.border;
  plan_options.rigor = options.measure ? mtf::Rigor::measure : mtf::Rigor::estimate;
  plan_options.aperture = mtf::io::scene_aperture(config.scene, scene.grid);
  plan_options.threads = global.threads;
  plan_options.progress = planning_progress(global);
  mtf::TileOptions tile_options;
  tile_options.memory = options.memory.value_or(0);
  tile_options.threads = global.threads;
  if (source.file) {
    tile_options.row_bytes = source.file->row_bytes();
    tile_options.more_rows = source.file->more_rows();
  }
  tile_options.channels = static_cast<std::int64_t>(scene.names.size());
  read_measured(options, global);
  if (options.region) {
    const auto [x, y, width, height] = *options.region;
    tile_options.region = mtf::Region{x, y, width, height};
  }
  const std::vector<mtf::Survey> surveys = survey_all(source, config.scene, tile_options.memory, global, *progress);
  plan_options.scene = worst_of(surveys, config.scene);
  lap("survey");
  const mtf::TiledSensorPlan plan =
      compile_reachable(options.tolerance.has_value(), plan_options, report.warnings,
                        [&] { return mtf::compile_tiled(config.system, scene.grid, plan_options, tile_options); });
  if (source.file)
    source.file->keep_rows(plan.report().whole ? source.file->more_rows() : plan.inner().presample.in().height);
  progress.reset();
  plan_options.progress = {};
  for (const std::string& warning : report.warnings) note(global, "warning: " + one_line(warning));
  lap("plan");

  const std::vector<std::string> names = output_names(scene.names);
  report.config = &config;
  report.scene = &scene;
  report.plan = &plan.inner();
  report.scene_path = options.scene;
  report.out_path = options.out;
  report.tolerance = plan_options.tolerance;
  report.tiles = TilesReport{plan.report(), {}, scene.grid, plan.out(), {}};
  report.tiles->whole_pixels = whole_pixels(config, scene.grid);

  progress.emplace(global);
  mtf::TileRunOptions run;
  run.border_value = config.scene.border_value;
  run.progress = [&](std::int64_t done, std::int64_t of) {
    progress->update("tiles", static_cast<double>(done) / static_cast<double>(of));
  };
  write_measured(options, global);
  mtf::io::Metadata metadata = provenance(config, scene, plan.inner(), plan_options.tolerance);
  if (options.region) {
    const auto& [x, y, width, height] = *options.region;
    metadata.text["mtf:region"] = std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(width) + " " +
                                  std::to_string(height) + " pixels of the whole image";
  }
  if (options.measure)
    note(global, "note: --rigor measure chose methods and FFT plans by timing; results may differ between runs");
  std::vector<mtf::Statistics> statistics;
  if (streamed) {
    mtf::io::TileStore store(options.out,
                             {key_of(options, config, source, surveys, plan), plan.out().width, plan.out().height,
                              names.size(), plan.report().count, [&](std::int64_t i) { return plan.tile(i).region; }},
                             options.resume);
    if (!store.note().empty()) note(global, "note: " + one_line(store.note()));
    if (store.resumed() > 0)
      note(global, "note: " + std::to_string(store.resumed()) + " of " + std::to_string(plan.report().count) +
                       " tiles are there from a stopped run");
    const InterruptNote kept(
        options.resume ? "mtf: finished tiles are kept; the same command goes on from them\n"
                       : "mtf: finished tiles are kept; the same command without --resume no goes on from them\n");
    run.done = [&](std::int64_t i) { return store.done(i); };
    report.tiles->tally = plan.run(
        source.read, surveys,
        [&](const mtf::Tile& tile, std::span<const mtf::ImageView<const float>> planes) {
          if (const auto c = overflowing(planes)) {
            store.remove();  // the same command will not do better
            refuse_overflow(scene.names[*c]);
          }
          store.write(tile.index, planes);
        },
        run);
    lap("run");
    progress.emplace(global);
    mtf::io::write_tiled_exr(
        options.out, names, plan.out().width, plan.out().height,
        [&](std::int64_t first, std::span<const mtf::ImageView<float>> planes) {
          for (std::size_t c = 0; c < planes.size(); ++c) store.read_rows(c, first, planes[c]);
          progress->update("write", static_cast<double>(first) / static_cast<double>(plan.out().height));
        },
        metadata, global.threads);
    for (std::size_t c = 0; c < names.size(); ++c)
      statistics.push_back(mtf::survey([&](std::size_t plane, std::int64_t, std::int64_t y,
                                           mtf::ImageView<float> rows) { store.read_rows(plane, y, rows); },
                                       c, plan.out(), {.threads = global.threads})
                               .statistics);
    store.remove();
  } else {
    std::vector<mtf::Image> images =
        run_in_memory(config, source, surveys, masks, plan, plan_options, run, *tile_options.region, report);
    lap("run");
    const Written written = write_sensor_image(options.out, names, images, metadata, integer_range(nullptr, options));
    if (written.scaling) {
      report.scaling = *written.scaling;
      report.clamped = written.clamped;
      report.integer_scaling =
          "value = gain x file + offset, in " + std::string(mtf::io::quantity_unit(scene.quantity));
    }
    for (const mtf::Image& image : images) statistics.push_back(mtf::statistics(image.view()));
  }
  progress.reset();
  lap("write");
  if (!options.report.empty()) emit(options.report, to_json(report));
  if (options.report == "-") return 0;  // standard output is the report
  if (options.explain) print(explain_tiles(plan.inner(), plan.report()));
  print(summary_text(report, names, statistics));
  return 0;
}

}  // namespace apps
