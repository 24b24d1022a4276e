// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sensor at one moment, as a run asks it: what the scene is worth as light, what filters it, to which tolerance, and
// what the output is. A sensor file without [detector] is linear: its light is the scene, its output the filtered
// scene. One with [detector] has a chain, and the place in it whose image is wanted. Who runs it does not ask which of
// them it is: one image, a sequence, a live view and tiles call the same functions.

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "apps/simulate/run_report.h"
#include "apps/simulate/scene_light.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/simulate_options.h"
#include "mtf/io/config/schedule.h"
#include "mtf/plan/sensor_plan.h"

namespace apps {

/// Of each file that a sensor names: when it was changed, and its size.
using FileStates = std::vector<std::pair<std::filesystem::file_time_type, std::uintmax_t>>;

/// What a sensor file with [detector] says beyond the OTF.
struct RadiometricChain {
  LoadedSensor loaded;
  FileStates files;            ///< when they were read
  mtf::System<double> system;  ///< with the electron rate of the band
  radiometry::OutputStage stage{};
};

/// Copies share what they hold; it never changes.
class SensorRun {
 public:
  SensorRun() = default;
  /// `stage`: the one asked for, else the last. `before`, where it is given, is the run of a sensor that has changed
  /// since: files are not read again where nothing but components of the OTF differs, and the files are those that were
  /// read. Throws UsageError for --stage where there is no [detector], and as load_chain.
  SensorRun(std::shared_ptr<const mtf::io::SensorConfig> config, std::optional<radiometry::OutputStage> stage,
            const SensorRun* before = nullptr);
  SensorRun(const mtf::io::SensorConfig& config, std::optional<radiometry::OutputStage> stage)
      : SensorRun(std::make_shared<const mtf::io::SensorConfig>(config), stage) {}

  const mtf::io::SensorConfig& config() const { return *config_; }
  const std::shared_ptr<const mtf::io::SensorConfig>& shared_config() const { return config_; }
  /// Null of a linear sensor.
  const RadiometricChain* chain() const { return chain_.get(); }
  bool is_linear() const { return chain_ == nullptr; }
  /// True when both are one run, or were made of one chain.
  bool has_chain_of(const SensorRun& other) const { return chain_ == other.chain_; }

  const mtf::System<double>& system() const { return chain_ ? chain_->system : config_->system; }
  int samples_a_pitch() const { return chain_ ? radiometry::samples_a_pitch(chain_->loaded.sensor) : 1; }

  /// The planes of `scene` become the light that the plan filters, which may make one of several masks of bad pixels.
  /// `source` as to_light() of scene_light.h, whose `rate` is filled in. Throws RuntimeError beyond float32.
  SceneLight light(mtf::io::Scene& scene, std::vector<mtf::Image>& masks, const SceneSource& source, int threads) const;

  /// The tolerance that a scene of that standard deviation is planned for: the one asked for, else the default, 1e-4 or
  /// a tenth of a count after the converter; `std` is nothing for a uniform scene.
  double tolerance(const std::optional<double>& asked, std::optional<double> std) const;
  /// What a default may become without a warning: errors no larger than those of the converter's rounding, 1/sqrt(12)
  /// of a count rms, are not seen in counts. 0 where the image is not counts.
  double unseen_tolerance(double by_default) const;

  /// True when each frame leaves something to the next.
  bool remembers() const;
  /// What to say of a thermal detector whose time constant is longer than a sequence of frames `steps` after the first;
  /// "" where it is not, or where there is one frame.
  std::string lag_warning(std::int64_t steps) const;

  /// What reports say of the chain before anything has run; nothing of a linear sensor.
  std::optional<ChainReport> report() const;
  /// Attributes of an image: provenance(), what its numbers are, and which frame of the noise it is.
  mtf::io::Metadata metadata(const mtf::io::Scene& scene, const mtf::SensorPlan& plan, double tolerance,
                             std::int64_t frame, const std::optional<std::array<std::int64_t, 4>>& region = {}) const;
  /// How the output becomes whole numbers where no range was asked for: counts as they are, display levels from 0 to
  /// the largest, which is white. Up to 255 levels take 8 bits, so that viewers show them as the display does.
  IntegerRange integer_range(const std::optional<std::array<double, 2>>& asked) const;

 private:
  std::shared_ptr<const mtf::io::SensorConfig> config_;
  std::shared_ptr<const RadiometricChain> chain_;
};

/// Number of the last frame that noise knows.
inline constexpr std::int64_t kLastNoiseFrame = 0x7fffffff;

/// True when a scene of the same values under [scene] (SceneDefaults) has the same light in both.
bool same_light(const SensorRun& a, const SensorRun& b);

/// True when the correction that one of them measures is that of the other: at most components of the OTF before the
/// detector or after [[readout]] differ.
bool same_correction(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b);
/// True when the correction of one nearly serves the other under the shading of the first: the pixels differ among
/// themselves in the same way and are converted in the same way; light, optics and their shading, the detector's
/// efficiency and dark current, and temporal noise may differ. Where warm optics or dark current have changed under a
/// strong shading, that change is divided by the shading in the image.
bool nearly_same_correction(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b);

/// Throws UsageError for a schedule of temperatures after frame 0 that [detector] shutter_drift changes too.
void require_one_drift(const mtf::io::SensorConfig& sensor, const mtf::io::Schedule& schedule);

/// Throws RuntimeError: a channel of this name has filtered values beyond what float32 holds.
[[noreturn]] void refuse_overflow(const std::string& channel);

/// The part of an image that a region of the output wants.
mtf::Image cropped(const mtf::Image& image, const std::array<std::int64_t, 4>& region);

}  // namespace apps
