// SPDX-License-Identifier: Apache-2.0

// `mtf bench SENSOR SCENE -o DIR`: what a tolerance costs. Promised and realised error and run time of every method
// that keeps it, with bare FFTW and plain OpenCV in the same interleaved rounds.

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/bench/bench_report.h"
#include "apps/bench/machine.h"
#include "apps/bench/tolerance_runs.h"
#include "apps/check/reference_fft.h"
#include "apps/config_command.h"
#include "apps/options.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

using Size = std::array<std::int64_t, 2>;

constexpr int kRounds = 15;

/// The sizes that bare FFTW is timed at: the image's first.
std::vector<Size> floor_sizes(const BenchJob& job, const std::vector<Contender>& contenders) {
  std::vector<Size> sizes{{job.in.width, job.in.height}};
  for (const Contender& contender : contenders)
    if (std::find(sizes.begin(), sizes.end(), contender.size) == sizes.end()) sizes.push_back(contender.size);
  return sizes;
}

void time_all(const ToleranceRuns& results, const BenchOptions& options, double seconds, ProgressLine& progress,
              BenchReport& report) {
  const BenchJob& job = *report.job;
  std::vector<std::function<void()>> cases;
  for (const Contender& contender : results.contenders) cases.push_back(contender.run);
  progress.update("planning bare FFTW", 0.0);
  const std::vector<Size> sizes = floor_sizes(job, results.contenders);
  using Pair = mtf::fft::RealPair2d;
  for (const Size& size : sizes)
    for (const Pair::Place place : {Pair::Place::out, Pair::Place::in})
      cases.emplace_back(
          [pair = std::make_shared<const Pair>(size[0], size[1], place, mtf::Rigor::measure)] { pair->execute(); });
  const std::vector<Timing> times =
      interleave(cases, {.rounds = *options.rounds, .seconds = seconds, .progress = [&](double share) {
                           progress.update("timing", share);
                         }});
  const std::size_t count = results.contenders.size();
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const Timing &out = times[count + 2 * i], &in = times[count + 2 * i + 1];
    report.floors.push_back({sizes[i], in.min_ms < out.min_ms ? in : out, in.min_ms < out.min_ms});
  }
  const auto floor_ms = [&](const Size& size) {
    return report.floors[static_cast<std::size_t>(std::find(sizes.begin(), sizes.end(), size) - sizes.begin())]
        .time.min_ms;
  };
  for (const ToleranceRun& run : results.runs) {
    BenchRow row;
    row.tolerance = run.tolerance;
    row.promised = run.promised;
    row.plan_ms = run.plan_ms;
    row.chosen = run.chosen;
    if (run.contender) {
      const Contender& contender = results.contenders[*run.contender];
      row.method = contender.method;
      row.detail = contender.detail;
      row.rms_error = contender.error.rms;
      row.max_error = contender.error.largest;
      row.time = times[*run.contender];
      row.memory_mib = static_cast<double>(contender.bytes) / 1048576.0;
      row.floor_ms = floor_ms(contender.size);
      row.floor_image_ms = report.floors.front().time.min_ms;
    } else {
      row.method = "refused";
      row.detail = run.reachable < 1.0 ? "reachable: " + significant(run.reachable, 2) : "no tolerance is reachable";
    }
    report.rows.push_back(std::move(row));
  }
}

std::string command_line(const BenchOptions& options, const Global& global) {
  std::string text = "mtf bench " + shell_word(options.sensor) + " " + shell_word(options.scene) + " -o " +
                     shell_word(options.out) + " --rounds " + std::to_string(*options.rounds) + " --seconds " +
                     mtf::format_double(options.seconds) + " --threads " + std::to_string(global.threads);
  if (options.measure) text += " --rigor measure";
  if (options.channel) text += " --channel " + shell_word(*options.channel);
  if (options.layer) text += " --layer " + shell_word(*options.layer);
  if (options.part) text += " --part " + std::to_string(*options.part);
  return text;
}

/// Writes the results, with a note where a figure is left out because gnuplot is missing. Returns the names.
std::string write_results(OutputSet& outputs, const BenchReport& report, const Global& global) {
  emit(outputs.in("bench.csv"), bench_csv(report));
  emit(outputs.in("bench.json"), bench_json(report));
  const std::optional<Figure> figure = bench_figure(report);
  if (!figure) {
    note(global, "note: every error is 0, so that no chart is made");
    return "bench.csv bench.json";
  }
  if (!draw_figure(outputs.in("bench.svg"), *figure)) {
    note(global, "note: gnuplot is not installed; bench.csv has the numbers, bench.svg and bench.png are left out");
    return "bench.csv bench.json";
  }
  draw_figure(outputs.in("bench.png"), *figure);
  return "bench.csv bench.json bench.svg bench.png";
}

/// Complaints about every row whose error is above what was promised.
int count_broken(const BenchReport& report) {
  int broken = 0;
  for (const BenchRow& row : report.rows) {
    if (!row.promised || *row.rms_error <= *row.promised) continue;
    ++broken;
    complain("mtf: PROMISE BROKEN: tolerance " + significant(row.tolerance, 2) + ", " + row.method + " (" + row.detail +
             "): promised " + significant(*row.promised, 3) + ", realised " + significant(*row.rms_error, 3));
  }
  return broken;
}

}  // namespace

int run_bench(const BenchOptions& given, const Global& global) {
  BenchOptions options = given;
  options.rounds = given.rounds.value_or(kRounds);
  const mtf::Stopwatch watch;
  if (options.out.empty()) throw mtf::UsageError("-o, --out is missing: name the folder for the results");
  const mtf::io::SensorConfig config = load_sensor(options.sensor, global);
  std::vector<std::string> inputs = files_of(config);
  inputs.push_back(options.scene);
  OutputSet outputs({.folder = options.out,
                     .force = options.force,
                     .names = {"bench.csv", "bench.json", "bench.svg", "bench.png"},
                     .inputs = inputs});
  mtf::io::Scene scene = mtf::io::load_scene(config, options.scene, {options.channel, options.layer, options.part});
  require_decoded(scene);

  BenchReport report;
  report.notes = scene.warnings;
  if (scene.planes.size() > 1)
    report.notes.push_back("the scene has " + std::to_string(scene.planes.size()) + " channels; " + scene.names[0] +
                           " is used (see --channel)");
  BenchJob job = make_job(config, scene, 0, global.threads);
  job.options.rigor = options.measure ? mtf::Rigor::measure : mtf::Rigor::estimate;
  if (job.flat) report.notes.push_back("the scene is uniform: every method gives it exactly, errors are 0");
  report.job = &job;
  report.command = command_line(options, global);
  report.sensor = options.sensor;
  report.sensor_name = config.system.name;
  report.config_sha256 = config.sha256;
  report.scene_path = options.scene;
  report.channel = scene.names[0];
  report.threads = global.threads > 0 ? global.threads : this_machine().cores;
  report.rounds = *options.rounds;
  if (report.threads > 1)
    report.notes.push_back("plans use " + std::to_string(report.threads) +
                           " threads, FFTW and OpenCV one; --threads 1 compares like with like");

  {
    ProgressLine progress(global);
    progress.update("exact image", 0.0);
    job.exact = check::reference_sensor_image(job.system, job.scene.view(), job.in, job.options.aperture,
                                              job.options.border, job.border_value, global.threads);
    if (std::any_of(job.exact.begin(), job.exact.end(),
                    [](double v) { return !(std::abs(v) <= std::numeric_limits<float>::max()); }))
      throw mtf::RuntimeError("filtered values exceed what float32 holds (3.4e38); scale the scene with scene.gain");
    mtf::Image out(job.out.width, job.out.height);
    const ToleranceRuns results = run_tolerances(job, out.view(), 1e3 * options.seconds / 60.0, progress);
    report.notes.insert(report.notes.end(), results.notes.begin(), results.notes.end());
    // What remains of the time asked for, at least half of it.
    const double seconds = std::max(0.5 * options.seconds, options.seconds - watch.seconds());
    time_all(results, options, seconds, progress, report);
  }
  for (const std::string& text : report.notes) note(global, "note: " + one_line(text));
  const std::string written = write_results(outputs, report, global);
  outputs.commit();
  print(options.format == Format::json ? bench_json(report)
        : options.format == Format::csv
            ? bench_csv(report)
            : bench_table(report) + "written to " + one_line(options.out) + "/: " + written + "\n");
  return count_broken(report) > 0 ? 3 : 0;
}

}  // namespace apps
