// SPDX-License-Identifier: Apache-2.0

// `mtf bench SENSOR SCENE -o DIR`: what a tolerance costs. Promised and realised error and run time of every method
// that keeps it, with bare FFTW and plain OpenCV in the same interleaved rounds.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/bench/bench_rivals.h"
#include "apps/bench/interleave.h"
#include "apps/bench/machine.h"
#include "apps/check/reference_fft.h"
#include "apps/config_command.h"
#include "apps/figures/plot.h"
#include "apps/options.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/error.h"
#include "mtf/units.h"
#include "mtf/version.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

// The results of `mtf bench`, as a table for people, CSV and JSON for programs, and the chart of error against time.

struct BenchRow {
  double tolerance = 0.0;
  std::string method, detail{};
  std::optional<std::size_t>
      contender{};  ///< which may appear at several tolerances; none where no plan keeps this one
  bool chosen = false;
  std::optional<double> promised{}, rms_error{}, max_error{}, plan_ms{}, memory_mib{}, floor_ms{}, floor_image_ms{};
  std::optional<Timing> time{};
};

/// Bare FFTW, forward and back, in place or out of place, whichever is faster.
struct Floor {
  std::array<std::int64_t, 2> size{};
  Timing time;
  bool in_place = false;
};

struct BenchReport {
  std::string command, sensor, sensor_name, config_sha256, scene_path, channel;
  const BenchJob* job = nullptr;
  int threads = 0;  ///< that plans used; FFTW and OpenCV: one
  int rounds = 0;
  std::vector<Floor> floors;  ///< the first is that of the image
  std::vector<BenchRow> rows;
  std::vector<std::string> notes;
};

std::string digits(const std::optional<double>& value, int count) { return value ? significant(*value, count) : ""; }

std::string speed_text(const BenchRow& row) {
  if (!row.time || !row.floor_image_ms || *row.floor_image_ms <= 0.0) return "";
  return fixed(row.time->min_ms / *row.floor_image_ms, 2);
}

std::optional<double> min_ms(const BenchRow& row) {
  return row.time ? std::optional<double>(row.time->min_ms) : std::nullopt;
}
std::optional<double> median_ms(const BenchRow& row) {
  return row.time ? std::optional<double>(row.time->median_ms) : std::nullopt;
}

Json row_json(const BenchRow& row) {
  return {{"tolerance", row.tolerance}, {"method", row.method},
          {"chosen", row.chosen},       {"promised", row.promised},
          {"rms_error", row.rms_error}, {"max_error", row.max_error},
          {"time_ms_min", min_ms(row)}, {"time_ms_median", median_ms(row)},
          {"plan_ms", row.plan_ms},     {"memory_mib", row.memory_mib},
          {"floor_ms", row.floor_ms},   {"floor_image_ms", row.floor_image_ms},
          {"detail", row.detail},       {"runs", row.time ? Json(row.time->runs) : Json(nullptr)}};
}

// The least error that can be had within a time: a staircase over the rows that no other beats in both error and time.
Series pareto_front(const std::vector<BenchRow>& rows) {
  std::vector<std::pair<double, double>> points;
  for (const BenchRow& row : rows)
    if (row.time && row.rms_error && *row.rms_error > 0.0) points.emplace_back(row.time->min_ms, *row.rms_error);
  std::sort(points.begin(), points.end());
  Series front{"Pareto front", {}, {}, true};
  for (const auto& [time, error] : points)
    if (front.y.empty() || error < front.y.back()) {
      if (!front.y.empty()) {
        front.x.push_back(time);
        front.y.push_back(front.y.back());
      }
      front.x.push_back(time);
      front.y.push_back(error);
    }
  return front;
}

std::string bench_table(const BenchReport& report) {
  TextTable table({"tolerance", "", "method", "promised", "rms error", "max error", "ms min", "median", "plan ms",
                   "MiB", "x FFTW", "detail"});
  double last = 0.0;
  for (const BenchRow& row : report.rows) {
    table.add({row.tolerance == last ? "" : significant(row.tolerance, 2), row.chosen ? ">" : "", row.method,
               digits(row.promised, 2), digits(row.rms_error, 2), digits(row.max_error, 2),
               row.time ? fixed(row.time->min_ms, 3) : "", row.time ? fixed(row.time->median_ms, 3) : "",
               row.plan_ms ? fixed(*row.plan_ms, 1) : "", row.memory_mib ? fixed(*row.memory_mib, 1) : "",
               speed_text(row), row.detail});
    last = row.tolerance;
  }
  constexpr Align l = Align::left, r = Align::right;
  std::string text = table.aligned({r, l, l, r, r, r, r, r, r, r, r, l});
  text +=
      "> is what the plan chooses; errors are relative to the scene's std; x FFTW compares with bare FFTW of the "
      "image's size\n";
  for (const Floor& floor : report.floors)
    text += "bare FFTW " + mtf::size_text(floor.size[0], floor.size[1]) + ", forward and back, " +
            (floor.in_place ? "in" : "out of") + " place: " + fixed(floor.time.min_ms, 3) + " ms (median " +
            fixed(floor.time.median_ms, 3) + ")\n";
  return text;
}

/// The columns of the table, then detail and runs. 17 digits; an empty field where there is no number.
std::string bench_csv(const BenchReport& report) {
  TextTable table({"tolerance", "method", "chosen", "promised", "rms_error", "max_error", "time_ms_min",
                   "time_ms_median", "plan_ms", "memory_mib", "floor_ms", "floor_image_ms", "detail", "runs"});
  for (const BenchRow& row : report.rows)
    table.add({mtf::format_double(row.tolerance), row.method, row.chosen ? "1" : "0", digits(row.promised, 17),
               digits(row.rms_error, 17), digits(row.max_error, 17), digits(min_ms(row), 17),
               digits(median_ms(row), 17), digits(row.plan_ms, 17), digits(row.memory_mib, 17),
               digits(row.floor_ms, 17), digits(row.floor_image_ms, 17), row.detail,
               row.time ? std::to_string(row.time->runs) : ""});
  return table.csv();
}

std::string bench_json(const BenchReport& report) {
  const BenchJob& job = *report.job;
  const Machine machine = this_machine();
  Json json;
  json["version"] = mtf::version;
  json["git_commit"] = mtf::git_commit;
  json["fft"] = mtf::fft::version();
  json["machine"] = {{"cpu", machine.cpu}, {"cores", machine.cores}, {"memory_bytes", machine.memory_bytes}};
  json["command"] = report.command;
  json["sensor"] = report.sensor;
  json["sensor_name"] = report.sensor_name;
  json["config_sha256"] = report.config_sha256;
  json["scene"] = report.scene_path;
  json["channel"] = report.channel;
  json["scene_size"] = {job.in.width, job.in.height};
  json["out_size"] = {job.out.width, job.out.height};
  json["border"] = mtf::kBorderNames[static_cast<std::size_t>(job.options.border)];
  json["scene_std"] = job.flat ? 0.0 : job.scale;
  json["threads"] = report.threads;
  json["rigor"] = job.options.rigor == mtf::Rigor::measure ? "measure" : "estimate";
  json["rounds"] = report.rounds;
  json["floors"] = Json::array();
  for (const Floor& floor : report.floors)
    json["floors"].push_back({{"size", floor.size},
                              {"in_place", floor.in_place},
                              {"time_ms_min", floor.time.min_ms},
                              {"time_ms_median", floor.time.median_ms},
                              {"runs", floor.time.runs}});
  json["rows"] = Json::array(report.rows, row_json);
  json["warnings"] = report.notes;
  // Names of files may hold any bytes; the report stays valid UTF-8.
  return json_document(json);
}

/// Nothing when no row has an error and a time that a logarithmic chart can show.
std::optional<Figure> bench_figure(const BenchReport& report) {
  Figure figure;
  figure.title = "error against run time: " + (report.sensor_name.empty() ? report.sensor : report.sensor_name) + ", " +
                 mtf::size_text(report.job->in.width, report.job->in.height) + " samples to " +
                 mtf::size_text(report.job->out.width, report.job->out.height) + " pixels";
  figure.x_label = "time of one image [ms], minimum of interleaved runs";
  figure.y_label = "realised rms error [std of the scene]";
  figure.log_x = figure.log_y = true;
  figure.series.push_back(pareto_front(report.rows));
  if (figure.series.front().x.empty()) return std::nullopt;
  Series chosen{"chosen by the plan", {}, {}, true, Mark::large_points};
  // All methods in one order, present or not, so that each has the same symbol in every chart.
  std::vector<std::string_view> methods(mtf::kMethodNames.begin(), mtf::kMethodNames.end());
  methods.insert(methods.end(), kRivalNames.begin(), kRivalNames.end());
  methods.push_back(mtf::kDiamondOnDevice);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    Series series{.name = std::string(methods[i]), .mark = Mark::points, .style = i};
    for (const BenchRow& row : report.rows) {
      if (row.method != methods[i] || !row.time) continue;
      series.x.push_back(row.time->min_ms);
      series.y.push_back(*row.rms_error);
      if (!row.chosen) continue;
      chosen.x.push_back(row.time->min_ms);
      chosen.y.push_back(*row.rms_error);
    }
    if (!series.x.empty()) figure.series.push_back(std::move(series));
  }
  figure.series.push_back(std::move(chosen));
  double low = figure.series.front().x.front(), high = low;
  for (const Series& series : figure.series)
    for (const double x : series.x) low = std::min(low, x), high = std::max(high, x);
  for (const Floor& floor : report.floors) {
    figure.vertical_lines.push_back({floor.time.min_ms, "FFTW " + mtf::size_text(floor.size[0], floor.size[1])});
    low = std::min(low, floor.time.min_ms), high = std::max(high, floor.time.min_ms);
  }
  std::sort(figure.vertical_lines.begin(), figure.vertical_lines.end(),
            [](const VerticalLine& a, const VerticalLine& b) { return a.x < b.x; });
  figure.x_range = std::array{0.8 * low, 1.25 * high};
  return figure;
}

// Every decade of tolerance from 1e-1 to 1e-7: the plan that is chosen, every other method that keeps the tolerance,
// and plain OpenCV; each is run once and compared with the exact image.

/// Methods whose predicted cost is above `slowest_ms` are left out, unless they are chosen. `out` is where all images
/// go, the size of job.out.
class Climber {
 public:
  Climber(const BenchJob& job, mtf::ImageView<float> out, double slowest_ms)
      : job_(job), out_(out), slowest_ms_(slowest_ms), memory_(this_machine().memory_bytes / 4) {}

  void plans(double tolerance) {
    mtf::PlanOptions options = job_.options;
    options.tolerance = tolerance;
    const mtf::Stopwatch watch;
    std::optional<mtf::SensorPlan> chosen;
    try {
      chosen = mtf::compile_sensor(job_.system, job_.in, options);
    } catch (const mtf::UnreachableTolerance& refusal) {
      const std::string kept = refusal.reachable() < 1.0 ? significant(refusal.reachable(), 2) : "";
      if (refused_.empty())
        refused_ = "no plan keeps " + significant(tolerance, 2) + " and less; " +
                   (kept.empty() ? "no tolerance can be kept for this scene" : kept + " can be kept");
      rows.push_back({.tolerance = tolerance,
                      .method = "refused",
                      .detail = kept.empty() ? "no tolerance is reachable" : "reachable: " + kept});
      return;
    }
    add(tolerance, *chosen, watch.ms(), true);
    const mtf::PlanReport& report = chosen->presample.report();
    std::set<std::string_view> seen;
    for (const mtf::Candidate& candidate : report.candidates) {
      const std::string_view name = mtf::name_of(candidate);
      if (!candidate.possible || name == report.method || !seen.insert(name).second) continue;
      if (candidate.cost_ms > slowest_ms_) {
        leave_out(std::string(name), "a run takes about " + fixed(1e-3 * candidate.cost_ms, 1) + " s; see --seconds");
        continue;
      }
      if (bytes_ + candidate.bytes > memory_) {
        leave_out(std::string(name), "all filters together would take more than a quarter of the memory");
        continue;
      }
      try {
        mtf::PlanOptions how = options;
        if (!candidate.on_device) how.device = {};
        another_way(tolerance, *chosen, candidate.method, how);
      } catch (const mtf::UsageError& refusal) {
        leave_out(std::string(name), refusal.what());
      }
    }
  }

  void rivals(double tolerance) {
    if (!rivals_) return;
    for (Contender& rival : rivals_->at(tolerance)) add_row(tolerance, std::move(rival));
  }

  void invite_rivals() {
    if (job_.flat) return;
    std::string obstacle = Rivals::obstacle(job_);
    if (obstacle.empty()) try {
        rivals_ = std::make_unique<Rivals>(job_, out_, slowest_ms_);
      } catch (const mtf::RuntimeError& error) {
        obstacle = error.what();
      }
    if (!obstacle.empty()) notes.push_back("no rows for OpenCV: " + obstacle);
  }

  /// Which rows are left out, and why.
  void finish() {
    if (rivals_)
      for (const std::string& what : rivals_->too_slow()) leave_out(what, "a run takes too long; see --seconds");
    if (!refused_.empty()) notes.push_back(refused_);
  }

  std::vector<Contender> contenders;
  std::vector<BenchRow> rows;      ///< without their times
  std::vector<std::string> notes;  ///< what was left out, and why

 private:
  // The chosen plan with its presample step done by another method; the tolerance of that step stays.
  void another_way(double tolerance, const mtf::SensorPlan& chosen, mtf::Method method, mtf::PlanOptions options) {
    options.tolerance = chosen.presample.report().tolerance;
    options.method = method;
    const mtf::Stopwatch watch;
    mtf::SensorPlan plan = chosen;
    plan.presample = mtf::compile(job_.system, job_.in, job_.out, options);
    const double ms = watch.ms();
    double predicted = plan.presample.report().predicted.total();
    if (chosen.post) {
      const mtf::PlanReport& post = chosen.post->report();
      predicted = predicted * std::max(1.0, post.largest_gain) + post.predicted.total();
    }
    plan.predicted_error = predicted;
    add(tolerance, plan, ms, false);
  }

  void add(double tolerance, const mtf::SensorPlan& plan, double plan_ms, bool chosen) {
    const mtf::PlanReport& report = plan.presample.report();
    Contender contender;
    contender.method = report.method;
    for (const mtf::Candidate& candidate : report.candidates)
      if (candidate.reason.empty()) contender.detail = candidate.detail;
    if (plan.post) contender.detail += "; then " + plan.post->report().method;
    contender.size = report.size;
    contender.bytes = report.otf_bytes + report.run_bytes;
    std::int64_t filters = report.otf_bytes;
    if (plan.post) {
      contender.bytes += plan.post->report().otf_bytes + 4 * job_.out.width * job_.out.height;
      filters += plan.post->report().otf_bytes;
    }
    contender.run = runner(plan);
    contender.run();
    contender.error = realised_error(job_, out_);
    const std::size_t count = contenders.size();
    BenchRow& row = add_row(tolerance, std::move(contender));
    row.chosen = chosen;
    row.promised = plan.predicted_error;
    row.plan_ms = plan_ms;
    if (contenders.size() > count) bytes_ += filters;
  }

  std::function<void()> runner(const mtf::SensorPlan& plan) const {
    const auto scene = job_.scene.view();
    const double level = job_.border_value;
    const int threads = job_.options.threads;
    const mtf::ImageView<float> out = out_;
    if (!plan.post) return [=] { plan.presample.run(scene, out, level, threads); };
    const auto sampled = std::make_shared<mtf::Image>(out.width, out.height);
    return [=] {
      plan.presample.run(scene, sampled->view(), level, threads);
      plan.post->run(sampled->view(), out, plan.presample.dc() * level, threads);
    };
  }

  /// One contender at one tolerance. Plans of one shape and one result to the last digit are one contender.
  BenchRow& add_row(double tolerance, Contender contender) {
    const auto same = [&](const Contender& other) {
      return other.method == contender.method && other.detail == contender.detail && other.size == contender.size &&
             other.bytes == contender.bytes && other.error.rms == contender.error.rms &&
             other.error.largest == contender.error.largest;
    };
    const auto known = std::ranges::find_if(contenders, same);
    const auto index = static_cast<std::size_t>(known - contenders.begin());
    rows.push_back({.tolerance = tolerance,
                    .method = contender.method,
                    .detail = contender.detail,
                    .contender = index,
                    .rms_error = contender.error.rms,
                    .max_error = contender.error.largest,
                    .memory_mib = static_cast<double>(contender.bytes) / 1048576.0});
    if (index == contenders.size()) contenders.push_back(std::move(contender));
    return rows.back();
  }

  void leave_out(const std::string& method, const std::string& reason) {
    const std::string text = "no rows for " + method + " at some tolerances: " + reason;
    if (std::ranges::find(notes, text) == notes.end()) notes.push_back(text);
  }

  const BenchJob& job_;
  mtf::ImageView<float> out_;
  double slowest_ms_;
  std::int64_t memory_, bytes_ = 0;
  std::string refused_;  // of the largest tolerance that no plan keeps
  std::unique_ptr<Rivals> rivals_;
};

using Size = std::array<std::int64_t, 2>;

constexpr int kRounds = 15;

/// The sizes that bare FFTW is timed at: the image's first.
std::vector<Size> floor_sizes(const BenchJob& job, const std::vector<Contender>& contenders) {
  std::vector<Size> sizes{{job.in.width, job.in.height}};
  for (const Contender& contender : contenders)
    if (std::find(sizes.begin(), sizes.end(), contender.size) == sizes.end()) sizes.push_back(contender.size);
  return sizes;
}

/// Adds the times of the contenders to the rows.
void time_all(const std::vector<Contender>& contenders, const BenchOptions& options, double seconds,
              ProgressLine& progress, BenchReport& report) {
  std::vector<std::function<void()>> cases;
  for (const Contender& contender : contenders) cases.push_back(contender.run);
  progress.update("planning bare FFTW", 0.0);
  const std::vector<Size> sizes = floor_sizes(*report.job, contenders);
  using Pair = mtf::fft::RealPair2d;
  for (const Size& size : sizes)
    for (const Pair::Place place : {Pair::Place::out, Pair::Place::in})
      cases.emplace_back(
          [pair = std::make_shared<const Pair>(size[0], size[1], place, mtf::Rigor::measure)] { pair->execute(); });
  const std::vector<Timing> times =
      interleave(cases, {.rounds = *options.rounds, .seconds = seconds, .progress = [&](double share) {
                           progress.update("timing", share);
                         }});
  const std::size_t count = contenders.size();
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const Timing &out = times[count + 2 * i], &in = times[count + 2 * i + 1];
    report.floors.push_back({sizes[i], in.min_ms < out.min_ms ? in : out, in.min_ms < out.min_ms});
  }
  const auto floor_ms = [&](const Size& size) {
    return report.floors[static_cast<std::size_t>(std::ranges::find(sizes, size) - sizes.begin())].time.min_ms;
  };
  for (BenchRow& row : report.rows) {
    if (!row.contender) continue;
    row.time = times[*row.contender];
    row.floor_ms = floor_ms(contenders[*row.contender].size);
    row.floor_image_ms = report.floors.front().time.min_ms;
  }
}

std::string command_line(const BenchOptions& options, const Global& global) {
  std::string text = "mtf bench " + shell_word(options.sensor) + " " + shell_word(options.scene) + " -o " +
                     shell_word(options.out) + " --rounds " + std::to_string(*options.rounds) + " --seconds " +
                     mtf::format_double(options.seconds) + " --threads " + std::to_string(global.threads);
  if (options.measure) text += " --rigor measure";
  if (options.device != "cpu") text += " --device " + shell_word(options.device);
  if (options.read.channel) text += " --channel " + shell_word(*options.read.channel);
  if (options.read.layer) text += " --layer " + shell_word(*options.read.layer);
  if (options.read.part) text += " --part " + std::to_string(*options.read.part);
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
  const mtf::io::SensorConfig config = load_sensor(options.sensor, global);
  mtf::require_isoplanatic(config.system, "mtf bench");
  std::vector<std::string> inputs = files_of(config);
  inputs.push_back(options.scene);
  OutputSet outputs({.folder = options.out,
                     .force = options.force,
                     .names = {"bench.csv", "bench.json", "bench.svg", "bench.png"},
                     .inputs = inputs});
  mtf::io::Scene scene = mtf::io::load_scene(config, options.scene, options.read);
  require_decoded(scene);

  BenchReport report;
  report.notes = scene.warnings;
  if (scene.planes.size() > 1)
    report.notes.push_back("the scene has " + std::to_string(scene.planes.size()) + " channels; " + scene.names[0] +
                           " is used (see --channel)");
  BenchJob job = make_job(config, scene, 0, global.threads);
  job.options.rigor = options.measure ? mtf::Rigor::measure : mtf::Rigor::estimate;
  std::string told;
  job.options.device = mtf::choose_device(options.device, told);
  if (!told.empty()) report.notes.push_back(told);
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
    Climber climber(job, out.view(), 1e3 * options.seconds / 60.0);
    climber.invite_rivals();
    constexpr std::array kTolerances{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7};
    for (std::size_t i = 0; i < kTolerances.size(); ++i) {
      progress.update("plans", static_cast<double>(i) / static_cast<double>(kTolerances.size()));
      climber.plans(kTolerances[i]);
      climber.rivals(kTolerances[i]);
    }
    climber.finish();
    report.rows = std::move(climber.rows);
    report.notes.insert(report.notes.end(), climber.notes.begin(), climber.notes.end());
    // What remains of the time asked for, at least half of it.
    const double seconds = std::max(0.5 * options.seconds, options.seconds - watch.seconds());
    time_all(climber.contenders, options, seconds, progress, report);
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
