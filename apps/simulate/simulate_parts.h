// SPDX-License-Identifier: Apache-2.0
#pragma once

// Steps of a simulation that a single image, a sequence and an image in tiles share.

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
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
/// And how the values of a PNG or TIFF were scaled.
void describe_integers(RunReport& report, const Written& written);

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
  void warn(const std::string& text);
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

}  // namespace apps
