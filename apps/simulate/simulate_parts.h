// SPDX-License-Identifier: Apache-2.0
#pragma once

// Steps of a simulation that a single image, a sequence and an image in tiles share.

#include <array>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/simulate/run_report.h"
#include "apps/simulate/scene_source.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/sensor_run.h"
#include "apps/simulate/simulate.h"
#include "apps/simulate/simulate_options.h"
#include "mtf/io/scene.h"
#include "mtf/otf/factored_otf.h"
#include "mtf/plan/plan.h"
#include "mtf/tiles/tiles.h"
#include "radiometry/chain/chain.h"

namespace apps {

/// Tolerance, border, rigor, device, threads and the blur of the samples, as the caller, the sensor file and the scene
/// with that summary say.
mtf::PlanOptions plan_options_of(const SimulateOptions& options, const SensorRun& sensor, const mtf::io::Scene& scene,
                                 const std::optional<mtf::SceneSummary>& summary);

/// That the device failed and the processor took over; "" where it did not.
std::string device_words(const mtf::DeviceChoice& choice);

/// The blur of the samples: what the file says (attribute mtf:aperture, "point" or "box" of one sample), else [scene].
mtf::SceneAperture aperture_of(const mtf::io::SceneDefaults& defaults, const mtf::io::Scene& scene);

/// Fills in what was simulated, for whom, and where it went.
void describe_run(RunReport& report, const mtf::io::SensorConfig& config, mtf::io::Scene scene_facts,
                  const std::string& scene_path, const SimulateOptions& options, double tolerance);

/// Why a correction leaves more in an image than the noise of its flat frames; "" where it does not, or for none.
std::string correction_warning(const std::shared_ptr<const radiometry::TwoPoint>& correction);

/// Masks of bad pixels per channel (empty where there are none), the planes filled; `summary` says so. Throws
/// RuntimeError when the policy is to refuse, UsageError when an encoding table does not cover them.
std::vector<mtf::Image> treat_bad_pixels(mtf::io::Scene& scene, NanPolicy policy, std::string& summary);

/// The parts of two channels that make the promise harder to keep, on the scale of the first; a flat one has none.
std::optional<mtf::SceneSummary> harder_of(std::optional<mtf::SceneSummary> a,
                                           const std::optional<mtf::SceneSummary>& b);

/// Takes what can be kept for the tolerance, with a warning where that is above SensorRun::unseen_tolerance().
void loosen_default(const mtf::UnreachableTolerance& refusal, const SensorRun& sensor, mtf::PlanOptions& options,
                    std::vector<std::string>& warnings);

/// compile() for the tolerance asked for; without one, for the default or, where that cannot be kept, for what can be
/// kept. `compile` uses `options`.
template <class Compile>
auto compile_reachable(bool asked, const SensorRun& sensor, mtf::PlanOptions& options,
                       std::vector<std::string>& warnings, const Compile& compile) {
  try {
    return compile();
  } catch (const mtf::UnreachableTolerance& refusal) {
    if (asked || !(refusal.reachable() < 1.0)) throw;
    loosen_default(refusal, sensor, options, warnings);
  }
  return compile();
}

/// One summary for all channels: the parts that make the promise hardest to keep, on the scale of one of them. Nothing
/// when all are flat, or have less contrast than the rounding of their values, of which `warnings` hears. `error`: of a
/// value, at most, as it comes (SceneLight::error).
std::optional<mtf::SceneSummary> summarise_all(const mtf::io::Scene& scene, mtf::Border border, double border_value,
                                               double error, std::vector<std::string>& warnings);

/// One spectrum for all channels that have contrast, where the border has one (mtf/engines/fft/scene_spectrum.h) and
/// the planes are not huge.
std::shared_ptr<const mtf::SceneSpectrum> spectrum_of_all(const mtf::io::Scene& scene, mtf::Border border, int threads);

/// Where a finished image goes: a file, the caller's sink, or back to the caller.
/// `file`: the name to write, "" for none. What is left of `image` afterwards is what the caller gets back: without
/// planes where a file or the sink has them, but for SimulateOptions::keep_images. Returns how a PNG or TIFF was
/// scaled. Throws as write_sensor_image.
Written deliver(const SimulateOptions& options, const std::string& file, const std::vector<std::string>& names,
                SimulatedImage& image, const IntegerRange& range);

/// True where images go to files of whole numbers alone, which have no more of a display of levels to 255 than these.
bool takes_whole_levels(const SimulateOptions& options);

// What a run tells its caller, from whatever thread: one event at a time, and the run ends where the caller says so.

class RunWatch {
 public:
  /// The report lives longer than the watch. Warnings and notes go to it too.
  RunWatch(const SimulateOptions& options, RunReport& report)
      : report_(report), caller_(std::make_shared<Caller>(options.watch)) {}
  ~RunWatch() { caller_->leave(); }
  RunWatch(const RunWatch&) = delete;
  RunWatch& operator=(const RunWatch&) = delete;

  /// So much of a step is done. All of these throw Cancelled where the caller ends the run.
  void share(std::string_view step, double share) { tell({SimulateEvent::Kind::share, step, share}); }
  void note(const std::string& text);
  void warn(const std::string& text);  ///< nothing where the text is ""
  /// How the values of a PNG or TIFF were scaled, in the report and as a note; nothing of other files.
  void describe_integers(const Written& written);
  /// A warning that is in the report already.
  void tell_warning(const std::string& text) { tell({SimulateEvent::Kind::warning, text, 0.0}); }
  /// Time since the last lap goes to the report; `tell_stage` does that and tells it.
  void lap(const char* stage);
  void tell_stage(const char* stage);
  /// For PlanOptions::progress; nothing where nobody watches. Plans keep it: it is silent once the run is over.
  mtf::OtfProgress planning();

 private:
  using Clock = std::chrono::steady_clock;

  class Caller {
   public:
    explicit Caller(std::function<bool(const SimulateEvent&)> watch) : watch_(std::move(watch)) {}
    bool watches() const { return watch_ != nullptr; }
    void tell(const SimulateEvent& event);
    void leave();

   private:
    std::mutex lock_;
    std::function<bool(const SimulateEvent&)> watch_;
  };

  void tell(const SimulateEvent& event) { caller_->tell(event); }

  RunReport& report_;
  std::shared_ptr<Caller> caller_;
  Clock::time_point last_ = Clock::now();
};

// One frame on its way through the sensor: the only one of a run, or one of a sequence or of a live view. Its scene is
// read, its bad pixels filled, in the unit that the sensor's plan filters.

struct SceneInput {
  mtf::io::Scene scene;
  std::vector<mtf::Image> masks;  ///< of bad pixels, per channel
  std::string bad_pixels;         ///< what happened to them, "" = none
  std::optional<mtf::SceneSummary> summary;
  double border_value = 0.0;  ///< in the unit of the planes
  /// Of the band's OTF, where the scene says how far away its pixels are; else that of the sensor holds.
  std::shared_ptr<const mtf::ElectronRate> rate{};
  std::vector<std::string> warnings{};  ///< of the light and of its contrast; `scene` has those of reading it
};

/// What filters that scene: the system of the sensor, with the `rate` of the scene.
mtf::System<double> system_for(const SensorRun& sensor, const SceneInput& input);

/// True when [scene] of both gives samples the same spacing.
bool same_spacing(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b);

/// True when [scene] of both gives samples the same values, spacing and border. The aperture is left out: the plan
/// alone depends on it.
bool same_values(const mtf::io::SceneDefaults& a, const mtf::io::SceneDefaults& b);

/// One scene for every frame. It is loaded again only where the sensor asks for other values of it: [scene] may have
/// changed, samples may be angles, whose size follows the focal length, and the light that a sensor with [detector]
/// takes depends on the band and on all that is before the pixels. A file whose scene is loaded again stays in memory.
class StillScene {
 public:
  StillScene(SceneSource source, NanPolicy nan, int threads)
      : source_(std::move(source)), nan_(nan), threads_(threads) {
    complete_name(source_);
  }

  /// Throws as take_scene, treat_bad_pixels and SensorRun::light.
  std::shared_ptr<const SceneInput> of(const SensorRun& sensor);
  const SceneSource& source() const { return source_; }

 private:
  SceneSource source_;
  NanPolicy nan_;
  int threads_;
  SensorRun sensor_;  ///< that `input_` serves
  std::shared_ptr<const SceneInput> input_;
};

struct Frame {
  std::int64_t number = 0;
  SensorRun sensor;      ///< as it is at this frame
  std::string settings;  ///< what the schedule has changed so far
  std::shared_ptr<const SceneInput> input;
  SceneInput* own = nullptr;                          ///< `input`, where no other frame has it: its planes are used up
  mtf::KeptScene* kept = nullptr;                     ///< of a scene that comes again: the planes of `input`
  std::int64_t noise_rows = 1;                        ///< of a kept scene: see radiometry::Chain::run
  bool whole_levels = false;                          ///< are enough: see there
  std::optional<std::array<std::int64_t, 4>> region;  ///< of the image that is wanted, where it is not all of it
  std::shared_ptr<const mtf::SensorPlan> plan;
  std::optional<mtf::TiledSensorPlan> tiles;          ///< takes less time than `plan`, of which it is made
  mtf::TileTally tally;                               ///< of these tiles
  std::shared_ptr<const radiometry::Chain> chain;     ///< chain_of()
  std::optional<radiometry::ShutterClosing> closing;  ///< the last one, of a shutter that closes now and then
  radiometry::ChainFrame counted;                     ///< what the chain says of it, without its image
  std::vector<std::string> warnings;
  SimulatedImage image;  ///< without planes once a file or the sink has them
  Written written;       ///< how its file of whole numbers was made
  double read_ms = 0.0, plan_ms = 0.0, run_ms = 0.0, write_ms = 0.0;
  std::exception_ptr error;
};

/// What is to be said of a scene and what images it before it is planned: of its file, its sampling, and of what is not
/// in the promised error. Of a frame, what its light says too.
std::vector<std::string> warnings_of(const SensorRun& sensor, const mtf::io::Scene& scene);
std::vector<std::string> warnings_of(const Frame& frame);

/// Takes the scene of `source` for this frame alone. Arguments and errors as StillScene; `watch` hears of the steps
/// "read" and "light" of a run of one image.
void load_own(Frame& frame, SceneSource source, NanPolicy nan, int threads, RunWatch* watch = nullptr);

/// The chain with that plan; null of a linear sensor. Further arguments as those of radiometry::Chain, whose errors get
/// their place in the sensor file.
std::shared_ptr<const radiometry::Chain> chain_of(const SensorRun& sensor, const mtf::SensorPlan& plan, int threads,
                                                  const radiometry::Chain* before = nullptr, bool keep_shading = false);

/// The planes of a frame that has its input, its plan and its chain. `state`: of the sequence, for a sensor whose
/// frames leave something to the next, else null. Throws RuntimeError for values that float32 does not hold.
std::vector<mtf::Image> run_planes(Frame& frame, radiometry::ChainState* state, int threads);

/// The same of several frames of one scene by one chain, their numbers equally far apart, that stand for themselves, in
/// batches where a device makes them (radiometry::Chain::run_batch). Puts the planes into their images.
void run_batch(std::span<const std::shared_ptr<Frame>> frames, int threads);

/// What is stored with the image of one frame of several.
mtf::io::Metadata metadata_of(const Frame& frame);

}  // namespace apps
