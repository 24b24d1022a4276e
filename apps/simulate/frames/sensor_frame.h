// SPDX-License-Identifier: Apache-2.0
#pragma once

// One frame on its way through the sensor: the only one of a run, or one of a sequence or of a live view. Its scene is
// read, its bad pixels filled, in the unit that the sensor's plan filters.

#include <array>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/simulate/simulate_parts.h"
#include "mtf/plan/plan.h"
#include "mtf/tiles/tiles.h"
#include "radiometry/chain/chain.h"

namespace apps {

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
  std::optional<std::array<std::int64_t, 4>> region;  ///< of the image that is wanted, where it is not all of it
  std::shared_ptr<const mtf::SensorPlan> plan;
  std::optional<mtf::TiledSensorPlan> tiles;          ///< takes less time than `plan`, of which it is made
  mtf::TileTally tally;                               ///< of these tiles
  std::shared_ptr<const radiometry::Chain> chain;     ///< chain_of()
  std::optional<radiometry::ShutterClosing> closing;  ///< the last one, of a shutter that closes now and then
  radiometry::ChainFrame counted;                     ///< what the chain says of it, without its image
  std::vector<std::string> warnings;
  SimulatedImage image;  ///< without planes once a file or the sink has them
  double read_ms = 0.0, plan_ms = 0.0, run_ms = 0.0, write_ms = 0.0;
  std::exception_ptr error;
};

/// What is to be said of the sensor and the scene of a frame before it is planned.
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

/// What is stored with the image of one frame of several.
mtf::io::Metadata metadata_of(const Frame& frame);

}  // namespace apps
