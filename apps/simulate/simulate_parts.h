// SPDX-License-Identifier: Apache-2.0
#pragma once

// Steps of a simulation that a single image and a sequence share.

#include <optional>
#include <string>
#include <vector>

#include "apps/simulate/scene_source.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/sensor_run.h"
#include "apps/simulate/simulate.h"
#include "mtf/io/scene.h"

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

}  // namespace apps
