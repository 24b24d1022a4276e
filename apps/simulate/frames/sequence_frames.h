// SPDX-License-Identifier: Apache-2.0
#pragma once

// What happens to each frame of a sequence, in this order: next, read, plan, run, finish. `next`, `plan` and `finish`
// are called one frame at a time and in order, `read` and `run` for several frames at once. A frame that fails carries
// its error to `finish`, so that the first one in order is what is reported, and every frame before it is written.

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/simulate/frames/frame_names.h"
#include "apps/simulate/frames/sensor_frame.h"
#include "apps/simulate/frames/sequence_plan.h"
#include "apps/simulate/frames/shutter_closings.h"
#include "mtf/io/config/schedule.h"

namespace apps {

struct SequenceNames {
  std::optional<FrameNames> scenes;  ///< none: the same scene for every frame
  std::optional<FrameNames> out;     ///< none: no files are written
  std::vector<std::int64_t> frames;  ///< rising, at least one
};

class SequenceFrames {
 public:
  /// `scene` is one for every frame, or what numbered files share.
  SequenceFrames(const SimulateOptions& options, const SensorRun& sensor, mtf::io::Schedule schedule,
                 const SequenceNames& names, SceneSource scene, int threads);

  /// Reads the first frame and compiles its plan, on all threads: what the others are judged by. Throws.
  void prepare();
  /// Bytes that a frame takes while it is being worked on.
  double bytes_a_frame() const;
  void set_threads_a_frame(int threads) { threads_ = threads; }

  /// The next frame with its sensor; null after the last one.
  std::shared_ptr<Frame> next();
  void read(Frame& frame);
  void plan(Frame& frame);
  void run(Frame& frame);
  /// Counts the frame and keeps its image where neither a file nor the sink has it. Throws its error, its number before
  /// the message.
  void finish(Frame& frame);

  /// True when frames have to run one after another: each leaves something to the next.
  bool remembers() const;

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
  std::vector<std::pair<std::string, double>> timing_ms() const;
  SequenceReport report() const;
  /// What the chain says of all frames; nothing for a sensor without one.
  const std::optional<ChainReport>& chain_report() const { return chain_report_; }

 private:
  void require_like_first(const Frame& frame);

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
  mtf::io::Scene first_scene_;
  std::shared_ptr<const mtf::SensorPlan> first_plan_, last_plan_;
  SensorRun spacing_sensor_;  ///< that `spacing_` belongs to
  mtf::SampleGrid spacing_;
  std::size_t at_ = 0;  ///< of the next frame
  std::vector<std::string> warnings_, notes_;
  std::vector<SimulatedImage> images_;
  SequenceReport report_;
  std::optional<ChainReport> chain_report_;
  double read_ms_ = 0.0, plan_ms_ = 0.0, run_ms_ = 0.0, write_ms_ = 0.0;
};

}  // namespace apps
