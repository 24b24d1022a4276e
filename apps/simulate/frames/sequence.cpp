// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/sequence.h"

#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "apps/simulate/frames/frame_names.h"
#include "apps/simulate/frames/sequence_frames.h"
#include "apps/simulate/output_files.h"
#include "apps/simulate/run_watch.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"
#include "mtf/work/usable_memory.h"

namespace apps {
namespace {

/// Frames of a still scene: those of the range, else every one that the schedule names.
std::vector<std::int64_t> frames_of_schedule(const SimulateOptions& options, const mtf::io::Schedule& schedule) {
  if (options.frames) return frames_of(*options.frames);
  std::vector<std::int64_t> frames;
  for (const mtf::io::Setting& setting : schedule.settings)
    if (frames.empty() || frames.back() != setting.frame) frames.push_back(setting.frame);
  return frames;
}

/// Nothing where no file is written.
std::optional<FrameNames> output_names_of(const SimulateOptions& options, bool numbered) {
  if (options.out.empty()) return std::nullopt;
  auto out = FrameNames::parse(options.out);
  const std::string which = one_line(options.out);
  if (!out)
    throw mtf::UsageError(which +
                          ": a sequence needs a frame number in the name of its output; write for example -o "
                          "out.%04d.exr");
  if (!numbered && options.schedule.empty())
    throw mtf::UsageError(which +
                          ": holds a frame number, but the scene is one image; name numbered scenes "
                          "(frame.%04d.exr), or give a --schedule");
  return out;
}

/// No output frame or other file of the caller may replace a file that is read, or another one.
void check_files(const SimulateOptions& options, const SceneSource& scene, const SequenceNames& names,
                 std::vector<std::string> inputs) {
  const std::vector<std::int64_t>& frames = names.frames;
  const auto is_frame = [&](const std::string& name) { return names.out->is_among(frames, name); };
  std::vector<std::string> outputs = options.also_written;
  if (names.out) outputs.insert(outputs.begin(), names.out->name(frames.front()));
  if (!options.schedule.empty()) inputs.push_back(options.schedule);
  if (!names.scenes && !scene.image) inputs.push_back(scene.file);
  require_writable(outputs, inputs);
  if (!names.out) return;
  for (const std::string& input : inputs)
    if (is_frame(input)) throw mtf::UsageError(one_line(input) + ": is an input; name other files for the output");
  for (std::size_t i = 1; i < outputs.size(); ++i)
    if (is_frame(outputs[i]) || is_frame(place_of(outputs[i]).string()))
      throw mtf::UsageError(one_line(outputs[i]) + ": is the name of an output frame; give it its own name");
  std::set<std::filesystem::path> linked;
  for (std::size_t i = 1; i < outputs.size(); ++i) linked.insert(place_of(outputs[i]));
  for (const std::string& input : inputs) linked.insert(place_of(input));
  for (const std::string& name : names.out->links(frames)) {
    const std::filesystem::path place = place_of(name);
    if (is_frame(place.string()) || !linked.insert(place).second)
      throw mtf::UsageError(one_line(name) + ": is a link to " + one_line(place.string()) +
                            ", which another output or an input is too; remove the link");
  }
  if (!names.scenes) return;
  for (const std::int64_t frame : frames) {
    if (names.scenes->is_among(frames, names.out->name(frame)))
      throw mtf::UsageError(one_line(names.out->name(frame)) +
                            ": is a frame of the input; name other files for the output");
    require_different(names.scenes->name(frame), names.out->name(frame));
  }
}

/// As many frames at a time as keep every thread busy and fit into half of the usable memory.
std::int64_t frames_in_flight(const SequenceFrames& frames, int threads) {
  const double room = 0.5 * mtf::usable_bytes() / std::max(1.0, frames.bytes_a_frame());
  const auto wanted = std::min<std::int64_t>(threads == 1 ? 1 : 2 * std::int64_t{threads}, frames.count());
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::min(room, 1e6)), 1, wanted);
}

void run_pipeline(SequenceFrames& frames, std::int64_t in_flight, int threads, RunWatch& watch) {
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
              watch.share("frames", frames.share_done());
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

/// Reads, runs and hands over all frames, and says what there is to say when they are done, or when one has failed.
/// Returns how many were at work at a time.
std::int64_t run_frames(SequenceFrames& frames, int threads, RunWatch& watch) {
  const auto say = [&] {
    for (const std::string& text : frames.warnings()) watch.warn(text);
    if (const std::string text = saturation_warning(frames.report()); !text.empty()) watch.warn(text);
    for (const std::string& text : frames.notes()) watch.note(text);
  };
  std::int64_t in_flight = 1;
  try {
    frames.prepare();
    in_flight = frames_in_flight(frames, threads);
    frames.set_threads_a_frame(frames.remembers() ? threads
                                                  : static_cast<int>(std::max<std::int64_t>(1, threads / in_flight)));
    run_pipeline(frames, in_flight, threads, watch);
  } catch (const Cancelled&) {
    throw;
  } catch (...) {
    say();
    throw;
  }
  say();
  return in_flight;
}

}  // namespace

bool is_sequence(const SceneSource& scene, const SimulateOptions& options) {
  return options.frames || !options.schedule.empty() || (!scene.image && FrameNames::parse(scene.file)) ||
         FrameNames::parse(options.out);
}

SimulateResult simulate_sequence(const mtf::io::SensorConfig& sensor, SceneSource& scene,
                                 const SimulateOptions& options) {
  SimulateResult result;
  RunReport& report = result.report;
  RunWatch watch(options, report);
  SequenceNames names;
  if (!scene.image) names.scenes = FrameNames::parse(scene.file);
  names.out = output_names_of(options, names.scenes.has_value());
  mtf::io::Schedule schedule;
  if (!options.schedule.empty()) schedule = mtf::io::read_schedule(options.schedule, sensor);
  names.frames = names.scenes ? names.scenes->find(options.frames) : frames_of_schedule(options, schedule);
  if (names.frames.empty())
    throw mtf::UsageError(one_line(options.schedule) +
                          ": sets no parameter, so it names no frames; choose them by --frames START:STOP");
  std::vector<std::string> inputs = files_of(sensor);
  inputs.insert(inputs.end(), schedule.files.begin(), schedule.files.end());
  check_files(options, scene, names, std::move(inputs));
  const SensorRun run(sensor, options.stage);
  if (names.out && mtf::io::format_from_extension(options.out) != mtf::io::Format::exr &&
      !run.integer_range(options.range).ends)
    throw mtf::UsageError("16-bit frames need one scale for all of them; give --range LOW:HIGH, or write .exr");
  if (!schedule.settings.empty() && schedule.settings.back().frame > names.frames.back())
    watch.note(options.schedule + " goes on to frame " + std::to_string(schedule.settings.back().frame) +
               ", the sequence ends with " + std::to_string(names.frames.back()));

  if (const std::string slow = run.lag_warning(names.frames.back() - names.frames.front()); !slow.empty())
    watch.warn(slow);

  const std::string schedule_sha256 = schedule.sha256, scene_path = scene.file;
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  SequenceFrames frames(options, run, std::move(schedule), names, std::move(scene), threads);
  const mtf::Stopwatch clock;
  const std::int64_t in_flight = run_frames(frames, threads, watch);
  const double seconds = clock.seconds();

  SequenceReport facts = frames.report();
  facts.schedule = options.schedule;
  facts.schedule_sha256 = schedule_sha256;
  facts.in_flight = in_flight;
  facts.seconds = seconds;
  facts.fps = static_cast<double>(facts.frames) / facts.seconds;
  facts.first_plan = frames.first_plan();
  describe_run(report, sensor, facts_of(frames.first_scene()), scene_path, options,
               frames.last_plan()->options.tolerance);
  report.plan = frames.last_plan();
  report.timing_ms = frames.timing_ms();
  report.sequence = std::move(facts);
  report.chain = frames.chain_report();
  result.names = output_names(frames.first_scene().names);
  result.images = std::move(frames.images());
  return result;
}

}  // namespace apps
