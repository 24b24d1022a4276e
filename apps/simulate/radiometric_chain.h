// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf simulate` needs for a sensor file that says more than the OTF: its chain, and the place in it whose image
// is written.

#include <filesystem>
#include <utility>
#include <vector>

#include "apps/simulate/run_report.h"
#include "apps/simulate/scene_light.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/simulate_options.h"
#include "mtf/plan/sensor_plan.h"

namespace apps {

/// Of each file that a sensor names: when it was changed, and its size.
using FileStates = std::vector<std::pair<std::filesystem::file_time_type, std::uintmax_t>>;

struct RadiometricChain {
  LoadedSensor loaded;
  FileStates files;            ///< when they were read
  mtf::System<double> system;  ///< with the electron rate of the band
  radiometry::OutputStage stage{};

  int samples_a_pitch() const { return radiometry::samples_a_pitch(loaded.sensor); }
  /// The default tolerance for a scene of that standard deviation: a tenth of a count after the converter.
  double tolerance(double otherwise, double std) const;
  /// What that default may become without a warning: errors no larger than those of the converter's rounding,
  /// 1/sqrt(12) of a count rms, are not seen in counts. 0 where the image is not counts.
  double unseen_tolerance(double by_default) const;
  std::string_view quantity() const { return output_quantity(loaded.sensor, stage); }
  std::string_view unit() const { return output_unit(loaded.sensor, stage); }
};

/// `stage`: the one asked for, else the last. Nothing for a sensor file without [detector]. Throws UsageError for
/// --stage where there is none, and as load_chain.
std::shared_ptr<const RadiometricChain> radiometric_chain_of(const mtf::io::SensorConfig& config,
                                                             std::optional<radiometry::OutputStage> stage);

/// The same for a sensor that has changed since `before`, of which `chain` is (both may be null): files are not read
/// again where nothing but components of the OTF differs, and the files are those that were read.
std::shared_ptr<const RadiometricChain> radiometric_chain_of(const mtf::io::SensorConfig& config,
                                                             std::optional<radiometry::OutputStage> stage,
                                                             const mtf::io::SensorConfig* before,
                                                             const RadiometricChain* chain);

/// Number of the last frame that noise knows.
inline constexpr std::int64_t kLastNoiseFrame = 0x7fffffff;

/// True when each frame leaves something to the next.
bool remembers(const RadiometricChain& radiometric);

/// What to say of a thermal detector whose time constant is longer than a sequence of frames `steps` after the first;
/// "" where it is not, or where there is one frame.
std::string lag_warning(const RadiometricChain& radiometric, std::int64_t steps);

/// True when a scene of the same values under [scene] (SceneDefaults) has the same light in both.
bool same_light(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b);

/// True when the correction that one of them measures is that of the other: at most components of the OTF before the
/// detector or after [[readout]] differ.
bool same_correction(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b);
/// True when the correction of one nearly serves the other under the shading of the first: the pixels differ among
/// themselves in the same way and are converted in the same way; light, optics and their shading, the detector's
/// efficiency and dark current, and temporal noise may differ. Where warm optics or dark current have changed under a
/// strong shading, that change is divided by the shading in the image.
bool nearly_same_correction(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b);

/// to_light() of scene_light.h with its `rate`; the masks of bad pixels become one. Throws RuntimeError where light
/// exceeds float32.
SceneLight to_light(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric, mtf::io::Scene& scene,
                    std::vector<mtf::Image>& masks, const SceneSource& source, int threads);

/// What reports say of it before anything has run.
ChainReport report_of(const RadiometricChain& radiometric);

/// Says in the attributes of an image what its numbers are, and which frame of the noise it is.
void add_chain(mtf::io::Metadata& metadata, const RadiometricChain& radiometric, std::uint32_t frame);

/// How the output becomes whole numbers where no range was asked for: counts as they are, display levels from 0 to the
/// largest, which is white. Up to 255 levels take 8 bits, so that viewers show them as the display does.
IntegerRange integer_range(const RadiometricChain* radiometric, const SimulateOptions& options);

/// The part of an image that a region of the output wants.
mtf::Image cropped(const mtf::Image& image, const std::array<std::int64_t, 4>& region);

}  // namespace apps
