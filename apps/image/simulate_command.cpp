// SPDX-License-Identifier: Apache-2.0

// `mtf simulate SENSOR SCENE -o OUT`: the command line to one call of apps/simulate, its events to standard error, its
// report to a file.

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/bench/machine.h"
#include "apps/config_command.h"
#include "apps/figures/picture.h"
#include "apps/image/simulate_summary.h"
#include "apps/options.h"
#include "apps/sensor/sensor_air.h"
#include "apps/simulate/frames/sequence.h"
#include "apps/simulate/output_files.h"
#include "apps/simulate/simulate.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/plan/measured.h"

namespace apps {
namespace {

// The run times that --rigor measure has measured, kept per host: in the file of --wisdom, else under
// $XDG_CACHE_HOME/mtfkit (or ~/.cache/mtfkit) by the name of the processor.

namespace fs = std::filesystem;

constexpr std::size_t kLargest = std::size_t{16} << 20;

// The fastest method of one processor may be slow on another: home folders are shared between machines.
std::string processor_name() {
  std::string name = this_machine().cpu;
  if (name.empty()) name = "unknown";
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}

fs::path cache_file() {
  const auto folder = [](const char* variable) {
    const char* value = std::getenv(variable);
    return value == nullptr || *value != '/' ? fs::path() : fs::path(value);
  };
  fs::path base = folder("XDG_CACHE_HOME");
  if (base.empty() && !folder("HOME").empty()) base = folder("HOME") / ".cache";
  return base.empty() ? fs::path() : base / "mtfkit" / ("measured-" + processor_name());
}

/// Reads it where measuring is asked for or a file is named. A named file that is missing will be made; one that holds
/// something else is a UsageError; a cache that cannot be read is started over, with a note.
void read_measured(const SimulateCommandOptions& options, const Global& global) {
  std::error_code error;
  if (options.wisdom.empty()) {
    const fs::path cache = cache_file();
    if (!options.run.measure || !fs::is_regular_file(cache, error)) return;
    bool known = false;
    try {
      known = mtf::import_measured(mtf::io::read_text_file(cache.string(), kLargest));
    } catch (const mtf::Error&) {  // as good as none
    }
    if (!known) note(global, "note: " + one_line(cache.string()) + " is damaged; its run times are measured again");
    return;
  }
  if (!fs::exists(options.wisdom, error)) {
    note(global, "note: " + one_line(options.wisdom) + " is created for the run times that are measured now");
    return;
  }
  if (!fs::is_regular_file(options.wisdom, error) ||
      !mtf::import_measured(mtf::io::read_text_file(options.wisdom, kLargest)))
    throw mtf::UsageError("--wisdom: " + one_line(options.wisdom) +
                          " does not hold what measuring has learnt here; name another file");
}

/// Writes it back. A named file that cannot be written is a RuntimeError, the cache a note.
void write_measured(const SimulateCommandOptions& options, const Global& global) {
  if (!options.wisdom.empty()) {
    mtf::io::write_text_file(options.wisdom, mtf::export_measured());
    return;
  }
  const fs::path cache = cache_file();
  if (!options.run.measure || cache.empty()) return;
  try {
    fs::create_directories(cache.parent_path());
    mtf::io::write_text_file(cache.string(), mtf::export_measured());
  } catch (const std::exception& e) {
    note(global, "note: the measured run times are not kept: " + one_line(e.what()));
  }
}

/// Says what a run tells, and that a stopped run in tiles can go on.
class EventPrinter {
 public:
  EventPrinter(const SimulateCommandOptions& options, const Global& global)
      : options_(options), global_(global), planning_(planning_progress(global)) {}

  void operator()(const SimulateEvent& event) {
    switch (event.kind) {
      case SimulateEvent::Kind::share:
        if (event.text == "tiles") promise_to_go_on();
        if (!line_) line_.emplace(global_);
        line_->update(std::string(event.text), event.value);
        break;
      case SimulateEvent::Kind::stage:
        print_stage(event);
        break;
      case SimulateEvent::Kind::planning:
        planning_(static_cast<std::int64_t>(event.value));
        break;
      case SimulateEvent::Kind::warning:
      case SimulateEvent::Kind::note:
        line_.reset();
        note(global_, (event.kind == SimulateEvent::Kind::warning ? "warning: " : "note: ") + one_line(event.text));
        break;
    }
  }

 private:
  // A run of one image is over before a bar would help: progress is a line a stage, for those who ask for it.
  void print_stage(const SimulateEvent& event) const {
    const std::string name(event.text), ms = fixed(event.value, 1);
    if (global_.progress == Progress::plain) complain(name + " " + ms + " ms");
    if (global_.progress == Progress::json) complain("{\"stage\":\"" + name + "\",\"ms\":" + ms + "}");
  }

  void promise_to_go_on() {
    const SimulateOptions& run = options_.run;
    if (kept_ || (run.region && !run.memory)) return;  // those tiles are in memory only
    kept_.emplace(run.resume
                      ? "mtf: finished tiles are kept; the same command goes on from them\n"
                      : "mtf: finished tiles are kept; the same command without --resume no goes on from them\n");
  }

  const SimulateCommandOptions& options_;
  const Global& global_;
  mtf::OtfProgress planning_;
  std::optional<ProgressLine> line_;
  std::optional<InterruptNote> kept_;
};

SimulateResult run_library(const SimulateCommandOptions& options, const Global& global,
                           const mtf::io::SensorConfig& sensor) {
  EventPrinter print_event(options, global);
  SimulateOptions run = options.run;
  run.device = device_of(options.device, global);
  run.threads = global.threads;
  run.keep_images = !options.picture.empty();
  for (const std::string& more : {options.report, options.wisdom, options.picture})
    if (!more.empty() && more != "-") run.also_written.push_back(more);
  run.watch = [&](const SimulateEvent& event) {
    print_event(event);
    return true;
  };
  return simulate(sensor, {.file = options.scene, .read = options.read}, run);
}

/// --picture: each plane of the scene beside that of the image.
void draw_picture(const SimulateCommandOptions& options, const mtf::io::SensorConfig& sensor,
                  const SimulateResult& result) {
  const mtf::io::Scene scene = mtf::io::load_scene(sensor, options.scene, options.read);
  const std::vector<mtf::Image>& planes = result.images.front().planes;
  PairedPicture page;
  for (std::size_t c = 0; c < planes.size(); ++c) {
    const std::string plane = planes.size() > 1 ? " " + one_line(result.names[c]) : "";
    // A spectral scene has more planes than the image that a detector makes of it: the one in its middle stands for it.
    const std::size_t shown = scene.planes.size() == planes.size() ? c : scene.planes.size() / 2;
    const mtf::Image& seen = scene.planes[shown];
    const std::int64_t width = std::max<std::int64_t>(seen.width(), 512);
    page.add({"scene" + plane, "samples"}, seen.view(), std::string(mtf::io::quantity_unit(scene.quantity)), width);
    page.add({"image of the sensor" + plane, "pixels"}, planes[c].view(), result.report.unit(), width);
  }
  page.write(options.picture);
}

/// Counts of a detector of 14 bits, in a scene of little contrast, are a hundredth of the grey values of a PNG or TIFF.
void note_dark_scale(const SimulateCommandOptions& options, const Global& global, const SimulateResult& result) {
  constexpr double kSeen = 0.03;
  if (result.report.integer_scaling.empty() || result.statistics.empty()) return;
  double low = mtf::kInfinity, high = -mtf::kInfinity;
  for (const mtf::Statistics& plane : result.statistics) {
    low = std::min(low, static_cast<double>(plane.min));
    high = std::max(high, static_cast<double>(plane.max));
  }
  const mtf::io::IntegerScaling& scaling = result.report.scaling;
  const double used = (high - low) / scaling.gain / scaling.largest();
  if (!(used > 0.0 && used < kSeen)) return;
  const auto stored = [&](double value) { return fixed((value - scaling.offset) / scaling.gain, 0); };
  note(global, "note: " + one_line(options.run.out) + " uses " + significant(100.0 * used, 2) +
                   " % of its grey scale, " + stored(low) + " to " + stored(high) + " of " +
                   fixed(scaling.largest(), 0) + ", and looks like one grey in a viewer; " +
                   (options.picture.empty() ? "--picture FILE.png draws it for the eye"
                                            : one_line(options.picture) + " is for the eye"));
}

}  // namespace

int run_simulate(const SimulateCommandOptions& options, const Global& global) {
  mtf::io::SensorConfig sensor = read_sensor(options.sensor, global);
  if (options.without_path && !options.run.schedule.empty())
    throw mtf::UsageError(
        "--without-path: a schedule reads the sensor file anew for its frames; remove [path] or "
        "[atmosphere] from it instead");
  if (options.without_path) sensor = without_path(std::move(sensor));
  if (options.run.out.empty())
    throw mtf::UsageError("-o, --out is missing: name the output image (.exr, .hdr, .png, .tif)");
  const bool has_signal = options.run.stage.value_or(radiometry::OutputStage::display) > radiometry::OutputStage::watts;
  if (const mtf::SettingsTable* detector = find_table(sensor.tables, "detector");
      detector != nullptr && has_signal && detector->find("read_noise") != nullptr &&
      find_table(sensor.tables, "noise") == nullptr)
    note(global, "note: images are without the read noise of [detector]: the sensor file has no [noise] table");
  require_picture_name(options.picture);
  if (!options.picture.empty() && (options.run.memory || is_sequence({.file = options.scene}, options.run)))
    throw mtf::UsageError("--picture draws one whole image; leave it out of a sequence, and with --memory");
  if (options.wisdom == "-") throw mtf::UsageError("--wisdom: name a file; \"-\" is for --report only");
  if (options.run.memory && !options.wisdom.empty())
    throw mtf::UsageError("--wisdom is for whole images; leave it out with --memory");
  if (!options.wisdom.empty()) {  // which is read before the library sees that it will be written
    std::vector<std::string> inputs = files_of(sensor);
    inputs.push_back(options.scene);
    require_writable({options.wisdom}, inputs);
  }
  read_measured(options, global);
  const SimulateResult result = run_library(options, global, sensor);
  write_measured(options, global);
  note_dark_scale(options, global, result);
  if (!options.picture.empty() && result.images.empty())
    note(global, "note: no picture is drawn: the image went through in tiles");
  else if (!options.picture.empty())
    draw_picture(options, sensor, result);
  if (!options.report.empty()) emit(options.report, to_json(result.report));
  if (options.report == "-") return 0;  // standard output is the report
  if (options.explain) print(explain_text(result.report));
  print(summary_text(result));
  return 0;
}

}  // namespace apps
