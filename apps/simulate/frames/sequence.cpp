// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/sequence.h"

#include <tbb/info.h>
#include <tbb/parallel_for_each.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/simulate/frames/frame_names.h"
#include "apps/simulate/output_files.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/schedule.h"
#include "mtf/io/file_checks.h"
#include "mtf/work/stopwatch.h"
#include "mtf/work/usable_memory.h"
#include "radiometry/chain/sensor_settings.h"

namespace apps {
namespace {

// When the shutter of a thermal camera closed last, for the frames of a sequence, and what it and the camera were like
// then: as the schedule has them at that frame, whether or not that frame is one of those that are run. So a frame does
// not depend on where --frames begins and on what it leaves out.

class ShutterClosings {
 public:
  /// Throws UsageError for a schedule of temperatures that [detector] shutter_drift changes too.
  ShutterClosings(const mtf::io::SensorConfig& sensor, mtf::io::Schedule schedule)
      : sensor_(sensor), schedule_(std::move(schedule)) {
    require_one_drift(sensor_, schedule_);
  }

  /// The last closing of the camera with these settings, which are those of `frame`; nothing where it does not close.
  std::optional<radiometry::ShutterClosing> before(std::uint32_t frame, const radiometry::SensorSettings& settings) {
    if (!settings.thermal || !settings.thermal->closes()) return std::nullopt;
    const radiometry::ShutterEvents events = shutter_events(settings);
    const std::uint32_t closed = events.closing_before(frame);
    if (last_ && last_->frame == closed) return last_;
    radiometry::CameraEmission camera = emission_of(settings);
    if (closed < frame && !schedule_.settings.empty()) {
      mtf::io::ScheduledSensor then(sensor_, schedule_);
      then.advance(closed);
      camera = emission_of(radiometry::sensor_settings(then.sensor().tables));
    }
    last_ = {closed, warmed(camera, events.warming_k(closed))};
    return last_;
  }

 private:
  mtf::io::SensorConfig sensor_;  ///< of the file
  mtf::io::Schedule schedule_;
  std::optional<radiometry::ShutterClosing> last_;
};

/// Does the work of a step unless an earlier one has failed.
template <class Work>
void attempt(Frame& frame, double& ms, const Work& work) {
  if (frame.error) return;
  const mtf::Stopwatch watch;
  try {
    work();
    ms += watch.ms();
  } catch (...) {
    frame.error = std::current_exception();
  }
}

[[noreturn]] void rethrow(const Frame& frame) {
  const std::string where = "frame " + std::to_string(frame.number) + ": ";
  try {
    std::rethrow_exception(frame.error);
  } catch (const Cancelled&) {
    throw;
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(where + error.what());
  } catch (const mtf::RuntimeError& error) {
    throw mtf::RuntimeError(where + error.what());
  }
}

std::string step_text(const mtf::SampleGrid& grid) {
  return mtf::format_double(grid.step_x_um) + " x " + mtf::format_double(grid.step_y_um) + " um";
}

// What happens to each frame of a sequence, in this order: next, read, plan, run, finish. `next`, `plan` and `finish`
// are called one group of frames at a time and in order, `read` and `run` for several groups at once. A frame that
// fails carries its error to `finish`, so that the first one in order is what is reported, and every frame before it is
// written.

struct SequenceNames {
  std::optional<FrameNames> scenes;  ///< none: the same scene for every frame
  std::optional<FrameNames> out;     ///< none: no files are written
  std::vector<std::int64_t> frames;  ///< rising, at least one
};

class SequenceFrames {
 public:
  /// `scene` is one for every frame, or what numbered files share.
  SequenceFrames(const SimulateOptions& options, const SensorRun& sensor, mtf::io::Schedule schedule,
                 const SequenceNames& names, SceneSource scene, int threads)
      : options_(options),
        names_(names),
        read_(scene.read),
        threads_(threads),
        closings_(sensor.config(), schedule),
        schedule_(sensor.config(), std::move(schedule)),
        planner_(options, threads),
        still_(std::move(scene), options.nan, threads),
        sensor_(sensor) {
    report_.first = names.frames.front();
    report_.last = names.frames.back();
    if (!sensor.is_linear() && (names.frames.front() < 0 || names.frames.back() > kLastNoiseFrame))
      throw mtf::UsageError("frames " + std::to_string(names.frames.front()) + " to " +
                            std::to_string(names.frames.back()) + ": noise is numbered from 0 to " +
                            std::to_string(kLastNoiseFrame));
  }

  /// Reads the first frame and compiles its plan, on all threads: what the others are judged by. Throws.
  void prepare() {
    const std::shared_ptr<Frame> frame = next();
    read(*frame);
    plan(*frame);
    if (frame->error) rethrow(*frame);
    prepared_ = frame;
    first_plan_ = frame->plan;
    first_sensor_ = frame->sensor;
    chain_report_ = first_sensor_.report();
    if (frame->chain) {
      const radiometry::OutputStage stage = first_sensor_.chain()->stage;
      frame->chain->prepare(stage, threads_);
      if (!names_.scenes && !remembers()) together_ = frame->chain->batch_size(stage);
    }
    first_scene_ = facts_of(frame->input->scene);
    require_room();
    warnings_ = warnings_of(*frame);
    for (const std::string& text : frame->plan->presample.report().notes) warnings_.push_back(text);
    if (options_.measure)
      notes_.push_back("--rigor measure chose FFT plans by timing; the last bits may differ between runs");
  }
  /// Bytes that a frame takes while it is being worked on.
  double bytes_a_frame() const {
    const mtf::SensorPlan& plan = *first_plan_;
    const auto pixels = [](const mtf::SampleGrid& grid) {
      return static_cast<double>(grid.width) * static_cast<double>(grid.height);
    };
    const auto channels = static_cast<double>(first_scene_.names.size());
    // The scene, the sampled image, the final one and what a file format makes of it; buffers and an OTF of its own.
    const double planes = 4.0 * (2.0 * pixels(plan.in()) + 3.0 * pixels(plan.out()));
    const mtf::PlanReport& report = plan.presample.report();
    return channels * (planes + static_cast<double>(report.run_bytes)) + static_cast<double>(report.otf_bytes);
  }
  void set_threads_a_frame(int threads) { threads_ = threads; }
  /// Frames that go through the sensor together: one, or several of one scene (radiometry::Chain::run_batch).
  using Group = std::vector<std::shared_ptr<Frame>>;
  std::int64_t together() const { return together_; }
  void limit_together(std::int64_t most) { together_ = std::clamp<std::int64_t>(together_, 1, most); }

  /// Empty after the last one.
  Group next_group() {
    Group group;
    while (std::ssize(group) < together_) {
      std::shared_ptr<Frame> frame = waiting_ ? std::exchange(waiting_, nullptr) : next();
      if (!frame) break;
      if (!group.empty() && !goes_on(group, *frame)) {
        waiting_ = std::move(frame);
        break;
      }
      group.push_back(std::move(frame));
    }
    return group;
  }

  /// The next frame with its sensor; null after the last one.
  std::shared_ptr<Frame> next() {
    if (prepared_) return std::exchange(prepared_, nullptr);
    if (at_ == names_.frames.size()) return nullptr;
    auto frame = std::make_shared<Frame>();
    frame->number = names_.frames[at_++];
    attempt(*frame, frame->plan_ms, [&] {
      if (schedule_.advance(frame->number)) {
        ++report_.schedule_changes;
        sensor_ = SensorRun(schedule_.sensor(), options_.stage);
      }
      if (const RadiometricChain* chain = sensor_.chain())
        frame->closing = closings_.before(static_cast<std::uint32_t>(frame->number), chain->loaded.sensor.settings);
    });
    frame->sensor = sensor_;
    frame->settings = schedule_.in_force();
    if (names_.scenes) return frame;
    attempt(*frame, frame->read_ms, [&] { frame->input = still_.of(sensor_); });
    return frame;
  }
  void read(Frame& frame) {
    if (frame.input) return;
    attempt(frame, frame.read_ms, [&] {
      load_own(frame, {.file = names_.scenes->name(frame.number), .read = read_}, options_.nan, threads_);
    });
  }
  void plan(Frame& frame) {
    if (frame.plan) return;
    attempt(frame, frame.plan_ms, [&] {
      if (names_.scenes) require_like_first(frame);
      planner_.plan(frame);
      planner_.chain(frame);
    });
  }
  void run(const Group& group) {
    for (const auto& frame : group) {
      frame->image.frame = frame->number;
      frame->whole_levels = takes_whole_levels(options_);
    }
    Frame& first = *group.front();
    const auto fits = [&](const auto& one) { return !one->error && !one->closing && one->chain == first.chain; };
    if (group.size() == 1 || !std::ranges::all_of(group, fits)) {
      for (const auto& frame : group) run_alone(*frame);
    } else {
      attempt(first, first.run_ms, [&] { run_batch(group, threads_); });
      for (const auto& frame : group) frame->error = first.error;
    }
    tbb::parallel_for_each(group, [&](const auto& frame) { write(*frame); });
  }
  /// Counts the frame and keeps its image where neither a file nor the sink has it. Throws its error with its number.
  void finish(Frame& frame) {
    for (const std::string& text : frame.warnings)
      warnings_.push_back("frame " + std::to_string(frame.number) + ": " + text);
    if (frame.error) {
      notes_.push_back(std::to_string(report_.frames) + " of " + std::to_string(count()) +
                       " frames were finished before this one and are whole");
      rethrow(frame);
    }
    if (!frame.input->bad_pixels.empty() && report_.frames_with_bad_pixels++ == 0)
      notes_.push_back("frame " + std::to_string(frame.number) + ": " + frame.input->bad_pixels +
                       " (the report counts such frames)");
    if (!frame.image.planes.empty()) images_.push_back(std::move(frame.image));
    if (chain_report_) chain_report_->add(frame.counted);
    written_ = {frame.written.scaling, written_.clamped + frame.written.clamped};
    if (frame.counted.held.any()) report_.saturated.emplace_back(frame.number, frame.counted.held);
    ++report_.frames;
    report_.predicted_error = std::max(report_.predicted_error, frame.plan->predicted_error);
    last_plan_ = frame.plan;
    read_ms_ += frame.read_ms;
    plan_ms_ += frame.plan_ms;
    run_ms_ += frame.run_ms;
    write_ms_ += frame.write_ms;
  }

  /// True when frames have to run one after another: each leaves something to the next.
  // A schedule may switch a shutter to rolling later on.
  bool remembers() const { return first_sensor_.remembers(); }

  double share_done() const { return static_cast<double>(report_.frames) / static_cast<double>(count()); }
  std::int64_t count() const { return static_cast<std::int64_t>(names_.frames.size()); }
  /// What the first frame was and how it was planned; without its planes.
  const mtf::io::Scene& first_scene() const { return first_scene_; }
  const std::shared_ptr<const mtf::SensorPlan>& first_plan() const { return first_plan_; }
  const std::shared_ptr<const mtf::SensorPlan>& last_plan() const { return last_plan_; }
  /// In the order of the frames.
  std::vector<SimulatedImage>& images() { return images_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// What there is to say that is no warning.
  const std::vector<std::string>& notes() const { return notes_; }
  /// Sums over frames: read, plan, run, write.
  std::vector<std::pair<std::string, double>> timing_ms() const {
    return {{"read", read_ms_}, {"plan", plan_ms_}, {"run", run_ms_}, {"write", write_ms_}};
  }
  SequenceReport report() const {
    SequenceReport report = report_;
    report.plans_compiled = planner_.compiled();
    report.plans_updated = planner_.updated();
    return report;
  }
  /// What the chain says of all frames; nothing for a sensor without one.
  const std::optional<ChainReport>& chain_report() const { return chain_report_; }
  const Written& written() const { return written_; }  ///< of the last frame, but clamped in all

 private:
  void run_alone(Frame& frame) {
    attempt(frame, frame.run_ms, [&] {
      radiometry::ChainState own;  // a closing is known without the frames before
      radiometry::ChainState* state = remembers() ? &state_ : frame.closing ? &own : nullptr;
      if (frame.closing) state->closing = frame.closing;
      frame.image.planes = run_planes(frame, state, threads_);
    });
  }
  void write(Frame& frame) {
    attempt(frame, frame.write_ms, [&] {
      frame.image.metadata = metadata_of(frame);
      frame.written =
          deliver(options_, names_.out ? names_.out->name(frame.number) : "", output_names(frame.input->scene.names),
                  frame.image, frame.sensor.integer_range(options_.range));
    });
  }
  /// Whether it differs from a group of frames in its noise alone, their numbers equally far apart.
  static bool goes_on(const Group& group, const Frame& frame) {
    const Frame& last = *group.back();
    const std::int64_t apart = frame.number - last.number;
    return !frame.error && !last.error && frame.input == last.input && frame.settings == last.settings &&
           (group.size() == 1 || apart == last.number - group[group.size() - 2]->number);
  }
  // Frames of another kind are a mistake in the sequence, whatever could be made of them.
  void require_like_first(const Frame& frame) {
    const mtf::io::Scene& scene = frame.input->scene;
    const auto fail = [&](const std::string& what, const std::string& is, const std::string& was) {
      throw mtf::RuntimeError(names_.scenes->name(frame.number) + " has " + what + " " + is +
                              ", the sequence began with " + was +
                              "; bring it to the same, or leave it out by --frames");
    };
    if (first_plan_) {
      const mtf::io::Scene& first = first_scene_;
      if (scene.grid.width != first.grid.width || scene.grid.height != first.grid.height)
        fail("size", mtf::size_text(scene.grid.width, scene.grid.height),
             mtf::size_text(first.grid.width, first.grid.height));
      if (scene.names != first.names) fail("channels", one_line(joined(scene.names)), one_line(joined(first.names)));
      if (scene.quantity != first.quantity)
        fail("quantity", std::string(mtf::io::quantity_name(scene.quantity)),
             std::string(mtf::io::quantity_name(first.quantity)));
      if (same_spacing(spacing_sensor_.config().scene, frame.sensor.config().scene) && scene.grid != spacing_)
        fail("samples of", step_text(scene.grid), step_text(spacing_));
    }
    spacing_sensor_ = frame.sensor;
    spacing_ = scene.grid;
  }
  /// Throws UsageError where the images that are kept for the caller do not fit into the usable memory together.
  void require_room() const {
    if (names_.out || options_.sink) return;
    const mtf::SampleGrid& grid = first_plan_->out();
    const double bytes = sizeof(float) * static_cast<double>(grid.width) * static_cast<double>(grid.height) *
                         static_cast<double>(first_scene_.names.size()) * static_cast<double>(count());
    const mtf::UsableMemory memory = mtf::usable_memory();
    if (bytes > memory.bytes)
      throw mtf::UsageError(
          "frames: " + std::to_string(count()) + " images of " + mtf::size_text(grid.width, grid.height) +
          " pixels need " + mtf::io::shown_bytes(bytes) + "; " + memory.whose + " " +
          mtf::io::shown_bytes(memory.bytes) +
          ": write them to files by an output with a number in its name (frame.%04d.exr), or run them "
          "in parts");
  }

  const SimulateOptions& options_;
  const SequenceNames& names_;
  mtf::io::ReadOptions read_;  ///< of numbered files
  int threads_ = 1;
  ShutterClosings closings_;
  mtf::io::ScheduledSensor schedule_;
  SequencePlanner planner_;
  StillScene still_;
  SensorRun sensor_, first_sensor_;
  radiometry::ChainState state_;
  std::shared_ptr<Frame> prepared_;  ///< the first frame, until it goes its way
  std::shared_ptr<Frame> waiting_;   ///< one that did not go with the group before it
  std::int64_t together_ = 1;
  mtf::io::Scene first_scene_;
  std::shared_ptr<const mtf::SensorPlan> first_plan_, last_plan_;
  SensorRun spacing_sensor_;  ///< that `spacing_` belongs to
  mtf::SampleGrid spacing_;
  std::size_t at_ = 0;  ///< of the next frame
  std::vector<std::string> warnings_, notes_;
  std::vector<SimulatedImage> images_;
  SequenceReport report_;
  std::optional<ChainReport> chain_report_;
  Written written_;
  double read_ms_ = 0.0, plan_ms_ = 0.0, run_ms_ = 0.0, write_ms_ = 0.0;
};

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
  if (!numbered && options.schedule.empty() && !options.frames)
    throw mtf::UsageError(which +
                          ": holds a frame number, but the scene is one image; name numbered scenes "
                          "(frame.%04d.exr), or give --frames N or a --schedule");
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
    for (const std::string& input : mtf::io::files_of_image(names.scenes->name(frame)))
      for (const std::string& output : mtf::io::files_of_image(names.out->name(frame)))
        require_different(input, output);
  }
}

/// As many groups of frames at a time as keep every thread busy and fit into half of the usable memory.
std::int64_t groups_in_flight(SequenceFrames& frames, int threads) {
  const double room = 0.5 * mtf::usable_bytes() / std::max(1.0, frames.bytes_a_frame());
  const auto most = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::min(room, 1e6)));
  frames.limit_together(std::min(most, frames.count()));
  const std::int64_t groups = (frames.count() + frames.together() - 1) / frames.together();
  const auto wanted = std::min<std::int64_t>(threads == 1 ? 1 : 2 * std::int64_t{threads}, groups);
  return std::clamp<std::int64_t>(most / frames.together(), 1, wanted);
}

void run_pipeline(SequenceFrames& frames, std::int64_t in_flight, int threads, RunWatch& watch) {
  using Token = SequenceFrames::Group;
  const auto step = [](void (SequenceFrames::*work)(Frame&), SequenceFrames& all) {
    return [work, &all](const Token& group) {
      for (const auto& frame : group) (all.*work)(*frame);
      return group;
    };
  };
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_pipeline(
        static_cast<std::size_t>(in_flight),
        tbb::make_filter<void, Token>(tbb::filter_mode::serial_in_order,
                                      [&](tbb::flow_control& control) {
                                        Token group = frames.next_group();
                                        if (group.empty()) control.stop();
                                        return group;
                                      }) &
            tbb::make_filter<Token, Token>(tbb::filter_mode::parallel, step(&SequenceFrames::read, frames)) &
            tbb::make_filter<Token, Token>(tbb::filter_mode::serial_in_order, step(&SequenceFrames::plan, frames)) &
            tbb::make_filter<Token, Token>(
                frames.remembers() ? tbb::filter_mode::serial_in_order : tbb::filter_mode::parallel,
                [&](const Token& group) {
                  frames.run(group);
                  return group;
                }) &
            tbb::make_filter<Token, void>(tbb::filter_mode::serial_in_order, [&](const Token& group) {
              for (const auto& frame : group) {
                frames.finish(*frame);
                watch.share("frames", frames.share_done());
              }
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
    watch.warn(saturation_warning(frames.report()));
    for (const std::string& text : frames.notes()) watch.note(text);
  };
  std::int64_t in_flight = 1;
  try {
    frames.prepare();
    const std::int64_t groups = groups_in_flight(frames, threads);
    in_flight = groups * frames.together();
    frames.set_threads_a_frame(frames.remembers() ? threads
                                                  : static_cast<int>(std::max<std::int64_t>(1, threads / groups)));
    run_pipeline(frames, groups, threads, watch);
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
  if (names.out && !mtf::io::holds_floats(mtf::io::format_from_extension(options.out)) &&
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
  watch.warn(device_words(options.device));
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
  watch.describe_integers(frames.written());
  if (report.chain) watch.warn(correction_warning(report.chain->correction));
  result.names = output_names(frames.first_scene().names);
  result.images = std::move(frames.images());
  return result;
}

}  // namespace apps
