// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/sequence_frames.h"

#include <algorithm>

#include "apps/simulate/image_output.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

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

std::string size_text(const mtf::SampleGrid& grid) {
  return std::to_string(grid.width) + "x" + std::to_string(grid.height);
}

std::string step_text(const mtf::SampleGrid& grid) {
  return mtf::format_double(grid.step_x_um) + " x " + mtf::format_double(grid.step_y_um) + " um";
}

}  // namespace

SequenceFrames::SequenceFrames(const SimulateOptions& options, const SensorRun& sensor, mtf::io::Schedule schedule,
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

void SequenceFrames::prepare() {
  const std::shared_ptr<Frame> frame = next();
  read(*frame);
  plan(*frame);
  if (frame->error) rethrow(*frame);
  prepared_ = frame;
  first_plan_ = frame->plan;
  first_sensor_ = frame->sensor;
  chain_report_ = first_sensor_.report();
  if (frame->chain) frame->chain->prepare(first_sensor_.chain()->stage, threads_);
  first_scene_ = facts_of(frame->input->scene);
  warnings_ = warnings_of(*frame);
  for (const std::string& text : frame->plan->presample.report().notes) warnings_.push_back(text);
  if (options_.measure)
    notes_.push_back("--rigor measure chose FFT plans by timing; the last bits may differ between runs");
}

// A schedule may switch a shutter to rolling later on.
bool SequenceFrames::remembers() const { return first_sensor_.remembers(); }

double SequenceFrames::bytes_a_frame() const {
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

std::shared_ptr<Frame> SequenceFrames::next() {
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

void SequenceFrames::read(Frame& frame) {
  if (frame.input) return;
  attempt(frame, frame.read_ms,
          [&] { load_own(frame, {.file = names_.scenes->name(frame.number), .read = read_}, options_.nan, threads_); });
}

// Frames of another kind are a mistake in the sequence, whatever could be made of them.
void SequenceFrames::require_like_first(const Frame& frame) {
  const mtf::io::Scene& scene = frame.input->scene;
  const auto fail = [&](const std::string& what, const std::string& is, const std::string& was) {
    throw mtf::RuntimeError(names_.scenes->name(frame.number) + " has " + what + " " + is +
                            ", the sequence began with " + was + "; bring it to the same, or leave it out by --frames");
  };
  if (first_plan_) {
    const mtf::io::Scene& first = first_scene_;
    if (scene.grid.width != first.grid.width || scene.grid.height != first.grid.height)
      fail("size", size_text(scene.grid), size_text(first.grid));
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

void SequenceFrames::plan(Frame& frame) {
  if (frame.plan) return;
  attempt(frame, frame.plan_ms, [&] {
    if (names_.scenes) require_like_first(frame);
    planner_.plan(frame);
    planner_.chain(frame);
  });
}

void SequenceFrames::run(Frame& frame) {
  attempt(frame, frame.run_ms, [&] {
    frame.image.frame = frame.number;
    radiometry::ChainState own;  // a closing is known without the frames before
    radiometry::ChainState* state = remembers() ? &state_ : frame.closing ? &own : nullptr;
    if (frame.closing) state->closing = frame.closing;
    frame.image.planes = run_planes(frame, state, threads_);
  });
  attempt(frame, frame.write_ms, [&] {
    frame.image.metadata = metadata_of(frame);
    deliver(options_, names_.out ? names_.out->name(frame.number) : "", output_names(frame.input->scene.names),
            frame.image, frame.sensor.integer_range(options_.range));
  });
}

void SequenceFrames::finish(Frame& frame) {
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
  if (frame.counted.held.any()) report_.saturated.emplace_back(frame.number, frame.counted.held);
  ++report_.frames;
  report_.predicted_error = std::max(report_.predicted_error, frame.plan->predicted_error);
  last_plan_ = frame.plan;
  read_ms_ += frame.read_ms;
  plan_ms_ += frame.plan_ms;
  run_ms_ += frame.run_ms;
  write_ms_ += frame.write_ms;
}

std::vector<std::pair<std::string, double>> SequenceFrames::timing_ms() const {
  return {{"read", read_ms_}, {"plan", plan_ms_}, {"run", run_ms_}, {"write", write_ms_}};
}

SequenceReport SequenceFrames::report() const {
  SequenceReport report = report_;
  report.plans_compiled = planner_.compiled();
  report.plans_updated = planner_.updated();
  return report;
}

}  // namespace apps
