// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/sequence.h"
#include "apps/measured_file.h"

#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>

#include "apps/sensor/sensor_file.h"
#include "apps/simulate/frame_names.h"
#include "apps/simulate/run_report.h"
#include "apps/simulate/run_summary.h"
#include "apps/simulate/sequence_frames.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"

namespace apps {
namespace {

/// Frames of a still scene: those of --frames, else every one that the schedule names.
std::vector<std::int64_t> frames_of_schedule(const SimulateOptions& options, const mtf::io::Schedule& schedule) {
  if (options.frames) return frames_of(*options.frames);
  std::vector<std::int64_t> frames;
  for (const mtf::io::Setting& setting : schedule.settings)
    if (frames.empty() || frames.back() != setting.frame) frames.push_back(setting.frame);
  return frames;
}

FrameNames output_names_of(const SimulateOptions& options, bool numbered) {
  const auto out = FrameNames::parse(options.out);
  const std::string which = one_line(options.out);
  if (!out)
    throw mtf::UsageError(which +
                          ": a sequence needs a frame number in the name of its output; write for example -o "
                          "out.%04d.exr");
  if (!numbered && options.schedule.empty())
    throw mtf::UsageError(which +
                          ": holds a frame number, but the scene is one image; name numbered scenes "
                          "(frame.%04d.exr), or give a --schedule");
  return *out;
}

/// No output frame, report or wisdom file may replace a file that is read, or another one.
void check_files(const SimulateOptions& options, const SequenceNames& names, std::vector<std::string> inputs) {
  const std::vector<std::int64_t>& frames = names.frames;
  const auto is_frame = [&](const std::optional<std::int64_t>& number) {
    return number && std::binary_search(frames.begin(), frames.end(), *number);
  };
  std::vector<std::string> outputs = outputs_of(options);
  outputs.front() = names.out->name(frames.front());
  if (!options.schedule.empty()) inputs.push_back(options.schedule);
  if (!names.scenes) inputs.push_back(options.scene);
  require_writable(outputs, inputs);
  for (const std::string& input : inputs)
    if (is_frame(names.out->frame_of(input)))
      throw mtf::UsageError(one_line(input) + ": is an input; name other files for the output");
  for (std::size_t i = 1; i < outputs.size(); ++i)
    if (is_frame(names.out->frame_of(outputs[i])) || is_frame(names.out->frame_of(place_of(outputs[i]).string())))
      throw mtf::UsageError(one_line(outputs[i]) + ": is the name of an output frame; give it its own name");
  std::set<std::filesystem::path> linked;
  for (std::size_t i = 1; i < outputs.size(); ++i) linked.insert(place_of(outputs[i]));
  for (const std::int64_t frame : frames) {
    const std::string name = names.out->name(frame);
    std::error_code error;
    if (!std::filesystem::is_symlink(std::filesystem::symlink_status(name, error))) continue;
    const std::filesystem::path place = place_of(name);
    if (is_frame(names.out->frame_of(place.string())) || !linked.insert(place).second)
      throw mtf::UsageError(one_line(name) + ": is a link to " + one_line(place.string()) +
                            ", which another output is too; remove the link");
  }
  if (!names.scenes) return;
  for (const std::int64_t frame : frames) {
    if (is_frame(names.scenes->frame_of(names.out->name(frame))))
      throw mtf::UsageError(one_line(names.out->name(frame)) +
                            ": is a frame of the input; name other files for the output");
    require_different(names.scenes->name(frame), names.out->name(frame));
  }
}

std::string plural(std::int64_t count, const std::string& word) {
  return std::to_string(count) + " " + word + (count == 1 ? "" : "s");
}

void print_summary(const RunReport& report, const SequenceReport& s) {
  const mtf::SampleGrid& out = report.plan->out();
  std::string text = one_line(report.out_path) + "  " + plural(s.frames, "frame") + " (" + std::to_string(s.first) +
                     " to " + std::to_string(s.last) + ")  " + std::to_string(out.width) + "x" +
                     std::to_string(out.height) + "  " + report.quantity() + " [" + report.unit() + "]\n";
  text += plural(s.schedule_changes, "change") + " of parameters; " + plural(s.plans_compiled, "plan") + " compiled, " +
          std::to_string(s.plans_updated) + " updated\n";
  text += "predicted error up to " + significant(s.predicted_error, 2) + " of a frame's std (tolerance " +
          mtf::format_double(report.tolerance) + ")\n";
  std::string times;
  for (const auto& [name, ms] : report.timing_ms)
    times += (times.empty() ? "" : ", ") + name + " " + fixed(ms / static_cast<double>(s.frames), 1);
  text += "time " + fixed(s.seconds, 2) + " s, " + significant(s.fps, 3) + " frames/s (ms a frame: " + times + "; " +
          plural(s.in_flight, "frame") + " at a time)\n";
  print(text);
}

/// As many frames at a time as keep every thread busy and fit into half of the machine's memory.
std::int64_t frames_in_flight(const SequenceFrames& frames, int threads) {
  const double room = 0.5 * machine_bytes() / std::max(1.0, frames.bytes_a_frame());
  const auto wanted = std::min<std::int64_t>(threads == 1 ? 1 : 2 * std::int64_t{threads}, frames.count());
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::min(room, 1e6)), 1, wanted);
}

void run_pipeline(SequenceFrames& frames, std::int64_t in_flight, int threads, const Global& global) {
  ProgressLine progress(global);
  using Token = std::shared_ptr<Frame>;
  const auto step = [](void (SequenceFrames::*work)(Frame&), SequenceFrames& all) {
    return [work, &all](const Token& frame) {
      (all.*work)(*frame);
      return frame;
    };
  };
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_pipeline(
        static_cast<std::size_t>(in_flight),
        tbb::make_filter<void, Token>(tbb::filter_mode::serial_in_order,
                                      [&](tbb::flow_control& control) {
                                        Token frame = frames.next();
                                        if (!frame) control.stop();
                                        return frame;
                                      }) &
            tbb::make_filter<Token, Token>(tbb::filter_mode::parallel, step(&SequenceFrames::read, frames)) &
            tbb::make_filter<Token, Token>(tbb::filter_mode::serial_in_order, step(&SequenceFrames::plan, frames)) &
            tbb::make_filter<Token, Token>(
                frames.remembers() ? tbb::filter_mode::serial_in_order : tbb::filter_mode::parallel,
                step(&SequenceFrames::run, frames)) &
            tbb::make_filter<Token, void>(tbb::filter_mode::serial_in_order, [&](const Token& frame) {
              frames.finish(*frame);
              progress.update("frames", frames.share_done());
            }));
  });
}

/// Of all frames together; "" where none has saturated pixels.
std::string saturation_warning(const SequenceReport& report) {
  const auto& frames = report.saturated;
  const auto most = std::max_element(frames.begin(), frames.end(),
                                     [](const auto& a, const auto& b) { return a.second.share() < b.second.share(); });
  if (most == frames.end()) return {};
  return std::to_string(frames.size()) + " of " + plural(report.frames, "frame") +
         " with saturated pixels, the most in " + std::to_string(most->first) + ": " + words(most->second);
}

/// Reads, runs and writes all frames, and says what there is to say when they are done, or when one has failed. Returns
/// how many were on their way at a time.
std::int64_t run_frames(SequenceFrames& frames, int threads, const Global& global) {
  const auto say = [&] {
    for (const std::string& text : frames.warnings()) note(global, "warning: " + one_line(text));
    if (const std::string text = saturation_warning(frames.report()); !text.empty()) note(global, "warning: " + text);
    for (const std::string& text : frames.notes()) note(global, "note: " + one_line(text));
  };
  try {
    frames.prepare();
    const std::int64_t in_flight = frames_in_flight(frames, threads);
    frames.set_threads_a_frame(frames.remembers() ? threads
                                                  : static_cast<int>(std::max<std::int64_t>(1, threads / in_flight)));
    run_pipeline(frames, in_flight, threads, global);
    say();
    return in_flight;
  } catch (...) {
    say();
    throw;
  }
}

}  // namespace

bool is_sequence(const SimulateOptions& options) {
  return options.frames || !options.schedule.empty() || FrameNames::parse(options.scene) ||
         FrameNames::parse(options.out);
}

int run_sequence(const SimulateOptions& options, const Global& global) {
  const mtf::io::SensorConfig sensor = read_sensor(options.sensor, global);
  SequenceNames names;
  names.scenes = FrameNames::parse(options.scene);
  names.still = options.scene;
  names.out = output_names_of(options, names.scenes.has_value());
  mtf::io::Schedule schedule;
  if (!options.schedule.empty()) schedule = mtf::io::read_schedule(options.schedule, sensor);
  names.frames = names.scenes ? names.scenes->find(options.frames) : frames_of_schedule(options, schedule);
  check_files(options, names, files_of(sensor));
  const std::shared_ptr<const RadiometricChain> radiometric = radiometric_chain_of(sensor, options);
  if (mtf::io::format_from_extension(options.out) != mtf::io::Format::exr &&
      !integer_range(radiometric.get(), options).low)
    throw mtf::UsageError("16-bit frames need one scale for all of them; give --range LOW:HIGH, or write .exr");
  if (!schedule.settings.empty() && schedule.settings.back().frame > names.frames.back())
    note(global, "note: " + one_line(options.schedule) + " goes on to frame " +
                     std::to_string(schedule.settings.back().frame) + ", the sequence ends with " +
                     std::to_string(names.frames.back()));
  read_measured(options, global);

  const int threads = global.threads > 0 ? global.threads : tbb::info::default_concurrency();
  const std::string schedule_sha256 = schedule.sha256;
  SequenceFrames frames(options, sensor, radiometric, std::move(schedule), names, threads);
  const auto start = std::chrono::steady_clock::now();
  const std::int64_t in_flight = run_frames(frames, threads, global);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  write_measured(options, global);

  SequenceReport facts = frames.report();
  facts.schedule = options.schedule;
  facts.schedule_sha256 = schedule_sha256;
  facts.in_flight = in_flight;
  facts.seconds = elapsed.count();
  facts.fps = static_cast<double>(facts.frames) / facts.seconds;
  RunReport report;
  report.config = &sensor;
  report.scene = &frames.first_scene();
  report.plan = &frames.last_plan();
  report.scene_path = options.scene;
  report.out_path = options.out;
  report.tolerance = frames.last_plan().options.tolerance;
  report.timing_ms = frames.timing_ms();
  report.warnings = frames.warnings();
  if (std::string text = saturation_warning(facts); !text.empty()) report.warnings.push_back(std::move(text));
  report.sequence = facts;
  report.chain = frames.chain_report();
  if (!options.report.empty()) emit(options.report, to_json(report));
  if (options.report == "-") return 0;  // standard output is the report
  if (options.explain)
    print("plan of frame " + std::to_string(facts.first) + ", the first of " + plural(facts.frames, "frame") +
          "; those after it have it too, with what the schedule changes, or one of their own\n" +
          explain_text(frames.first_plan()));
  print_summary(report, facts);
  return 0;
}

}  // namespace apps
