// SPDX-License-Identifier: Apache-2.0
#pragma once

// The inside of a compiled chain (chain.h): what is the same for every frame and is made once, one frame on its way
// through the stages, and the table of the stages.

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "mtf/device/device_image.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/chain/chain.h"
#include "radiometry/stages/detector/saturation.h"
#include "radiometry/stages/noise/frame_flicker.h"

namespace radiometry {

[[noreturn]] inline void refuse(const char* where, const std::string& why) {
  throw mtf::UsageError(std::string(where) + ": " + why);
}

/// A map of the pixels of a detector; null stands for 1 at each of them.
using SharedMap = std::shared_ptr<const mtf::Image>;

/// number x map + added at each pixel. Where light or lens change, most often the number alone does, and maps are kept.
struct Linear {
  double number = 1.0;
  SharedMap map{};
  double added = 0.0;
};

/// In the precision of pixels, as images take it here and on a device.
inline mtf::DeviceLinear in_float(const Linear& linear, bool is_offset) {
  const double number = is_offset && !linear.map ? linear.number + linear.added : linear.number;
  const double added = is_offset && !linear.map ? 0.0 : linear.added;
  return {linear.map, static_cast<float>(number), static_cast<float>(added)};
}

/// image = gain x image + offset. The image has steps x steps samples for each pixel of the maps.
void multiply_add(mtf::Image& image, const Linear& gain, const Linear& offset, int threads, std::int64_t steps = 1);

/// Counts, while a frame goes through the chain, the pixels that are held at an end of the range: those that light has
/// brought there, and apart from them the stuck ones, which are defective or blinking.
class HeldCounter {
 public:
  /// Begins a frame of that size, without stuck pixels.
  void begin(const mtf::Image& image) {
    stuck_.clear();
    pixels_ = image.size();
    width_ = image.width();
  }
  /// Marks these pixels as stuck: that an end of the range holds them says nothing of the light.
  template <class Pixels>
  void mark(const Pixels& pixels) {
    for (const auto& pixel : pixels) stuck_.push_back(pixel.y * width_ + pixel.x);
    std::sort(stuck_.begin(), stuck_.end());
    stuck_.erase(std::unique(stuck_.begin(), stuck_.end()), stuck_.end());
  }
  /// Adds the pixels of the frame to those that light may bring to an end, and the stuck ones apart.
  void count(HeldPixels& held, HeldPixels& stuck) const {
    const auto apart = static_cast<std::int64_t>(stuck_.size());
    held.pixels += pixels_ - apart;
    stuck.pixels += apart;
  }

  struct Counts {
    Clipped all, stuck;
    Clipped light() const { return {all.low - stuck.low, all.high - stuck.high}; }
  };
  /// Runs a stage on an image, and first on a copy of the stuck pixels, so that they are counted apart.
  template <class Stage>
  Counts run(mtf::Image& image, const Stage& stage) const {
    Counts counts;
    if (!stuck_.empty()) {
      mtf::Image values(static_cast<std::int64_t>(stuck_.size()), 1);
      std::transform(stuck_.begin(), stuck_.end(), values.data(), [&](std::int64_t i) { return image.data()[i]; });
      counts.stuck = stage(values.view());
    }
    counts.all = stage(image.view());
    return counts;
  }

 private:
  std::vector<std::int64_t> stuck_;  // indices of pixels, rising
  std::int64_t pixels_ = 0, width_ = 0;
};

struct FrameRun;
struct DetectorSource;

/// What a stage does with a sensor, or why the sensor leaves it out.
struct StageWords {
  bool on = false;
  std::string what;
};

/// A row of the table of stages: all that a stage is. A stage that its words leave out does not run.
struct StageRow {
  /// The stages that run together: a part ends where the output may be taken or [microscan] begins or ends.
  enum class Part { optics, detector, conversion, correction, display };

  std::string_view name;
  Part part = Part::detector;
  std::string_view timing = name;  ///< name of its time in reports
  bool in_sequence = false;        ///< acts only on the frames of a sequence
  /// Why it needs more of an image than the pixels of a tile; empty for a stage that acts on each pixel for itself.
  std::string_view whole_image = {};
  /// Throws UsageError for settings that it needs or excludes, of a sensor with [detector]; null for none.
  void (*require)(const mtf::System<double>& system, const Sensor& sensor) = nullptr;
  /// Makes a map of the pixels for the step (FrameRun::map), once for a sensor; an empty image where the source asks
  /// for none. Null for a stage without one.
  mtf::Image (*map)(const DetectorSource& source, int threads) = nullptr;
  /// Null for a step that is always needed and that the rows before it describe.
  StageWords (*words)(const mtf::System<double>& system, const Sensor& sensor) = nullptr;
  /// Acts on a frame. Null where a later row has the effect of this one too.
  void (*step)(FrameRun& run, mtf::Image& image) = nullptr;
  /// The same on the device where the frame is, to the bit; null: the frame comes back first.
  void (*step_on_device)(FrameRun& run, mtf::DeviceImage& image) = nullptr;
  /// Whether this frame may stay there for it; null: it may.
  bool (*stays)(const FrameRun& run) = nullptr;
  /// What becomes of the value of a constant border, where that is not the step's.
  void (*border)(FrameRun& run) = nullptr;
};

/// Every row, in the order of the chain.
std::vector<StageRow> stage_table();

/// The rows that run for a sensor with [detector], in their order.
std::vector<StageRow> stages_to_run(const mtf::System<double>& system, const Sensor& sensor);

/// True where the image of an output stage has gone through that part of the chain.
bool goes_through(StageRow::Part part, OutputStage stage);

struct PixelMaps;

/// All that the maps of a detector are made from.
struct DetectorSource {
  std::optional<NonuniformitySettings> nonuniformity{};
  std::optional<Narcissus> narcissus{};
  std::optional<Defects> defects{};
  std::optional<Blinking> blinking{};
  std::shared_ptr<const mtf::Image> responsivity{}, offset{};  ///< maps that are given
  FocalPlane plane{};
  Origin origin{};
  std::int64_t width = 0, height = 0;
  std::uint64_t seed = 0;

  bool operator==(const DetectorSource&) const = default;
};

/// All that maps of pixels are made from.
struct MapSource {
  DetectorSource detector{};
  std::optional<Vignetting> vignetting{};
  std::shared_ptr<const mtf::Image> given_vignetting{};
  double focal_length_mm = 0.0, gain = 0.0, dark_e = 0.0;
  Directions<double> warm{};
  double cone_sr = 0.0, around_sr = 0.0;
  bool shutter = false, closes = false;  ///< of a thermal camera
  /// The maps whose vignetting these have, scaled to the mean of the vignetting of the settings; null: that itself.
  std::shared_ptr<const PixelMaps> shading{};

  bool operator==(const MapSource&) const = default;
};

/// The part of a map of the whole detector that an image has; empty where there is no map.
mtf::Image part_of(const SharedMap& whole, const char* key, const DetectorSource& source);

inline bool same_shading(const MapSource& a, const MapSource& b) {
  return a.vignetting == b.vignetting && a.given_vignetting == b.given_vignetting &&
         a.focal_length_mm == b.focal_length_mm;
}

/// What differs from pixel to pixel whatever the light.
struct DetectorMaps {
  SharedMap responsivity{};
  SharedMap own_light{};  ///< what narcissus leaves of the camera's own light, times the responsivity
  std::map<std::string_view, SharedMap> of_stages{};  ///< by StageRow::name, of the rows that have one
  std::vector<DefectivePixel> defects{};
  std::vector<BlinkingPixel> blinking{};
};

/// What differs from pixel to pixel, for the pixels of an image or of a tile of one.
struct PixelMaps {
  MapSource made_from;
  std::shared_ptr<const DetectorMaps> detector{};  ///< never null
  Linear corners{};                                ///< vignetting
  Linear light{};                                  ///< electrons for one unit of weighted radiance
  Linear glow{};                                   ///< mean electrons of warm optics, stop and dark current

  /// Of the first pixel on the detector.
  Origin origin() const { return made_from.detector.origin; }
};

struct CompiledChain {
  /// `columns`, `rows`: the detector where [frame] has no format. Throws as Chain, but for maps.
  CompiledChain(const mtf::SensorPlan& filters, const mtf::System<double>& system, const Sensor& sensor,
                std::int64_t columns, std::int64_t rows);

  mtf::SensorPlan plan;
  std::vector<StageRow> stages;
  SensorSettings settings;
  OutputStage last = OutputStage::electrons;
  std::uint64_t seed = 0;
  FocalPlane detector;
  Camera<double> camera;
  Pixel<double> pixel;
  std::optional<Adc> adc;
  std::optional<Response> response;
  double gain = 0.0;        ///< electrons (volts of a thermal detector) for one unit of weighted radiance on the axis
  Directions<double> warm;  ///< mean electrons of warm optics and stop on the axis; volts less those of the shutter,
                            ///< but for `events`, which take them off after the lag
  double dark_e = 0.0;      ///< mean electrons of the dark current
  double read_e = 0.0;      ///< rms of read, reset and other noise, or of a thermal pixel and its readout
  FrameFlicker slow;        ///< 1/f noise of a pixel from frame to frame; strength 0: none
  SpectralCamera curves;
  CameraEmission emission;              ///< of frame 0
  std::optional<ShutterEvents> events;  ///< of a thermal camera whose shutter closes now and then
  double frame_time_s = 0.0;
  double focal_length_mm = 0.0;
  /// Of the image; null where it comes in tiles, each of which has its own.
  std::shared_ptr<const PixelMaps> maps;

  double glow_e() const { return warm.total_e() + dark_e; }

  /// The maps of the two-point correction, measured by the first chain of a sequence when it first needs them.
  std::shared_ptr<const TwoPoint> correction(int threads) const;
  /// The same; null where they are not measured yet, or at this moment.
  std::shared_ptr<const TwoPoint> known_correction() const;
  TwoPoint measure(int threads) const;
  std::shared_ptr<const CompiledChain> corrected_by;  ///< the first chain of a sequence; null: this one
  mutable std::mutex measuring;
  mutable std::shared_ptr<const TwoPoint> measured;
};

/// Of width x height pixels from `origin` on.
MapSource map_source(const CompiledChain& chain, const Sensor& sensor, Origin origin, std::int64_t width,
                     std::int64_t height);

/// The maps of a source of that chain. `before`: others, of which those are taken that would be the same, or null.
/// Throws UsageError for pixels beyond the detector, and for a map of a sensor that does not cover the detector.
PixelMaps pixel_maps(const CompiledChain& chain, const MapSource& source, int threads,
                     const PixelMaps* before = nullptr);

/// What light of the camera itself gives to each pixel: it is multiplied by `sensitivity`, and `added` comes on top.
/// Where a thermal camera has a shutter, vignetting (`corners`) narrows the cone of light, and the housing is seen in
/// its place.
Linear glow_of(const CompiledChain& chain, const Directions<double>& light, const Linear& corners,
               const SharedMap& sensitivity, double added, int threads);

/// The light of the camera itself at a frame beside that of frame 0, before the lag: what has warmed since then.
Directions<double> warming_of(const CompiledChain& chain, std::uint32_t frame);
/// What the closed shutter gave when it closed last.
Directions<double> last_closed(const CompiledChain& chain, std::uint32_t frame, ChainState* state);

/// One frame, or a tile of one, on its way through the chain.
struct FrameRun {
  const CompiledChain& chain;
  const PixelMaps& maps;
  int threads;
  NoiseKey key{};
  std::uint32_t number = 0;         ///< of the frame in its sequence
  mtf::KeptScene* kept = nullptr;   ///< the scene, where it comes again: until a stage has made an image of it
  ChainState* state = nullptr;      ///< of the sequence; null: the frame stands for itself
  double border = 0.0;              ///< value of a constant border at this place of the chain
  std::uint32_t frames_passed = 1;  ///< since the frame before; frames that were left out are time that has passed
  std::int64_t noise_rows = 1;      ///< shot and read noise are wanted in the first row and each so-many-th after it
  bool whole_levels = false;        ///< are enough of a display of levels to 255
  ChainFrame frame{};
  HeldCounter counter{};
  SharedMap map{};                                ///< of the stage that runs
  mtf::Stopwatch watch{};                         ///< since the last lap
  bool may_stay = false;                          ///< on the device that filters it, until a stage has no step there
  mtf::Image given{};                             ///< the scene of a frame that has stayed there, unless it is kept
  std::unique_ptr<mtf::DeviceImage> on_device{};  ///< the frame, while it is there
  std::vector<ChainFrame> others{};               ///< of a batch, beside `frame`, once they are back

  /// Notes the time since the last lap; times of a stage that runs for several positions add up.
  void lap(std::string_view stage);
  void run(StageRow::Part part, mtf::Image& image);
  /// How many frames are on their way together: a batch stays on the device to its end.
  std::int64_t frames() const { return on_device ? on_device->frames() : 1; }
  /// Brings back what is on a device.
  void bring_back(mtf::Image& image);
  /// The stages after the sampling and the optics, up to an output stage.
  void run_to(OutputStage stage);
};

}  // namespace radiometry
