// SPDX-License-Identifier: Apache-2.0
#pragma once

// Frames for the page: the image of the scene by a sensor, by the same LiveSimulation that other programs call, and
// that image as whole numbers of 16 bits. The values themselves are kept for the last few frames, for cursor and files.

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/simulate/frames/frame_names.h"
#include "apps/simulate/live_simulation.h"

namespace apps::live {

using Sensor = std::shared_ptr<const mtf::io::SensorConfig>;

/// Where the camera of a 3-D scene is, and when: m in axes of the scene, UTC.
struct Viewpoint {
  std::array<double, 3> position_m{}, look_at_m{};
  double utc_s = 0.0;

  bool operator==(const Viewpoint&) const = default;
};

/// What is asked of a frame beside the sensor.
struct FrameRequest {
  std::int64_t number = 0;          ///< of the noise, and of a sequence's files
  bool preview = false;             ///< for the moment: quicker, and less exact (README.md)
  std::int64_t every = 1;           ///< so many pixels along and down, of a preview, one is shown
  std::optional<Viewpoint> from{};  ///< of a 3-D scene
  std::string scene{};              ///< text of its file; "": that of the start
  std::string tab{};                ///< page that asks
  bool may_lag = false;             ///< the light of another time will do for the moment
  std::optional<double> tolerance{};
  std::optional<radiometry::OutputStage> stage{};

  /// A preview does not wait for one.
  CorrectionOf correction() const { return preview ? CorrectionOf::earlier : CorrectionOf::own; }

  bool operator==(const FrameRequest&) const = default;
};

/// Pixels as 16-bit numbers: value = low + n (high - low) / 65535, between the ends of the whole image.
struct PixelBytes {
  std::int64_t width = 0, height = 0;
  double low = 0.0, high = 0.0;
  double dark = 0.0, bright = 0.0;  ///< between which all but the darkest and the brightest half per cent lie
  std::string bytes;                ///< rows from the top, little-endian
};
/// Every so many pixels of a row, and of a column.
PixelBytes pixel_bytes(mtf::ImageView<const float> image, int every, int threads = 1);

/// A finished frame.
struct KeptFrame {
  std::uint64_t id = 0;
  std::vector<std::string> names{};
  SimulatedImage image{};
  IntegerRange range{};
  std::vector<std::string> warnings{};
  std::shared_ptr<const mtf::SensorPlan> plan{};
  double ms = 0.0;
  bool passing = false;          ///< a preview, or of another time's light or temperatures: no file is made of it
  bool correction_lags = false;  ///< it has the correction of earlier values
  std::int64_t noise_rows = 1;   ///< the first row and every so-many-th one after it have noise of each pixel
  /// Of a 3-D scene: what the sensor took in, its relative error, whether its light is of another time, and what stands
  /// for sky, sun and air.
  std::shared_ptr<const mtf::io::Scene> scene{};
  double radiance_promised = 0.0;
  bool light_lags = false;
  std::string solving{};  ///< temperatures are those before the change: what is going on, in words
  std::vector<std::pair<std::string, std::string>> closures{};
  std::vector<std::pair<std::string, double>> stages_ms{};
};

/// A frame of a 3-D scene, but for `id` and `ms`.
using DrawScene = std::function<KeptFrame(const Sensor& sensor, const FrameRequest& request)>;

class FrameMaker {
 public:
  /// `scene`: one image, or numbered files. Tolerance and stage are those of each request in place of those of `image`.
  /// Numbers of frames follow `first_id`.
  FrameMaker(SceneSource scene, SimulateOptions image, std::uint64_t first_id = 0);
  explicit FrameMaker(DrawScene draw, std::uint64_t first_id = 0);

  /// The last frame once more where the same is asked for. Throws as LiveSimulation::image, or what draws. Not to be
  /// called from two threads at once.
  std::shared_ptr<const KeptFrame> frame(const Sensor& sensor, const FrameRequest& request);
  /// One of the last frames, null for one that is no longer kept.
  std::shared_ptr<const KeptFrame> kept(std::uint64_t id) const;
  /// The scene of a frame, its planes in the unit of its quantity.
  std::shared_ptr<const mtf::io::Scene> scene(const Sensor& sensor, std::int64_t number);
  /// Numbers of a sequence; empty for one image.
  const std::vector<std::int64_t>& numbers() const { return numbers_; }
  int plans_compiled() const { return live_ ? live_->plans_compiled() : 0; }

 private:
  SceneSource source_of(std::int64_t number) const;
  KeptFrame of_image(const Sensor& sensor, const FrameRequest& request);

  DrawScene draw_;
  SceneSource source_;
  std::optional<FrameNames> files_;
  std::vector<std::int64_t> numbers_;
  SimulateOptions image_;
  std::optional<LiveSimulation> live_;
  FrameRequest made_for_;
  std::int64_t file_number_ = -1;
  std::deque<std::shared_ptr<const KeptFrame>> kept_;
  Sensor last_sensor_;  ///< of the last of them
  FrameRequest last_request_;
  std::uint64_t count_ = 0;
  std::shared_ptr<const mtf::io::Scene> scene_;
  Sensor scene_sensor_;
  std::int64_t scene_number_ = -1;
};

}  // namespace apps::live
