// SPDX-License-Identifier: Apache-2.0
#pragma once

// The whole sensor, from the scene's radiance at the aperture, photons s^-1 m^-2 sr^-1 weighted by the camera's curves
// (scene_radiance.h), to the display, by stages in the order of the physics. Outputs may be taken on the way:
//   `radiance` after the optics and the sampling at the pitch, `irradiance` after the cone of light,
//   `electrons` before the converter, `dn` after it, `display` after correction, postsample filters and gain
//   (a thermal detector has watts for photons and volts for electrons, no dark current, shot noise and full well:
//   `volts`; the power that it absorbs, before lag and noise, is `watts`)
// Each stage is one row in chain/steps, in the order of the chain; chain_stages() lists them for a sensor. A stage
// whose table is not in the sensor file does not run, nor do the stages after the one whose output is wanted. With
// [microscan] the sampling is finer than the pitch: the stages from `shutter` to the correction run for each position,
// and the frames are put together.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mtf/plan/sensor_plan.h"
#include "radiometry/chain/sensor_settings.h"
#include "radiometry/light/spectral_signal.h"
#include "radiometry/output_stage.h"
#include "radiometry/performance/sensitivity.h"

namespace radiometry {

/// A sensor, with the contents of the files that its settings name.
struct Sensor {
  SensorSettings settings;
  SpectralCamera curves;  ///< band, and the curves that were given as files
  Path path;              ///< between scene and aperture
  /// The path through [atmosphere] with other numbers; empty where the file has none, or gives no line of sight.
  std::function<Path(const AtmosphereSettings&)> air;
  Spectrum emissivity = constant_spectrum("blackbody", 1.0);  ///< of a scene of temperatures
  /// Maps of the whole detector in place of random ones, where they are given.
  std::shared_ptr<const mtf::Image> responsivity, offset, vignetting;
};

/// Throws UsageError for settings that need or exclude each other: what no table can say by itself.
void require_consistent(const mtf::System<double>& system, const Sensor& sensor);

/// A component of [[presample]] that counts the thermal time constant under an image that moves.
struct MovingBolometer {
  std::string label;
  double time_constant_s = 0.0;
};
/// The first one; nothing where none moves.
std::optional<MovingBolometer> moving_bolometer(const mtf::System<double>& system);

/// Throws UsageError for a detector or for curves that make no electrons of any light in the band. Whoever reads the
/// curves from files checks them so.
void require_response(const Sensor& sensor);

/// Camera and pixel of a sensor as the camera equation takes them. A factor that is given as a curve is 1 there. Throws
/// UsageError where an f-number, an integration time or [detector] is missing, and as cone_sr.
Camera<double> camera_of(const mtf::System<double>& system, const Sensor& sensor);
Pixel<double> pixel_of(const mtf::System<double>& system, const Sensor& sensor);
/// The converter of a sensor with [adc]. Throws UsageError when it has neither electrons_per_count nor a full well.
Adc adc_of(const Sensor& sensor);

/// The number of samples a pitch that plans have to be compiled with: the steps of [microscan], or 1 without.
int samples_a_pitch(const Sensor& sensor);

/// Throws UsageError for a stage that a sensor whose last one is `last` does not have.
void require_output_stage(OutputStage stage, OutputStage last, bool has_converter, bool thermal);

/// The last output stage of a sensor: display where anything follows the converter, dn with [adc], else electrons or
/// volts.
OutputStage last_output_stage(const mtf::System<double>& system, const Sensor& sensor);
/// The unit that the signal has between light and converter, "e-" or "V".
std::string_view signal_unit(const Sensor& sensor);
/// The unit of the image of a sensor at a stage, "ph.s^-1.m^-2.sr^-1", "ph.s^-1.m^-2", "e-" (of a thermal detector
/// "W.m^-2.sr^-1", "W.m^-2", "W", "V"), "counts" or "levels" (of the display), and its quantity. Where the camera has
/// curves of the wavelength, radiance and irradiance are weighted by them, and the name of the quantity says so.
std::string_view output_unit(const Sensor& sensor, OutputStage stage);
std::string_view output_quantity(const Sensor& sensor, OutputStage stage);

/// One stage of the chain of a sensor, in words.
struct ChainStage {
  std::string name;
  bool on = false;
  std::string what;  ///< what it does, with numbers; of a stage that is off, the table that would switch it on
};

/// Adds to the time of that name; times are in the order in which they came first.
template <class Name>
void add_time(std::vector<std::pair<Name, double>>& times, std::string_view name, double ms) {
  for (auto& [known, sum] : times) {
    if (known != name) continue;
    sum += ms;
    return;
  }
  times.emplace_back(name, ms);
}

/// One frame that has gone through the chain.
struct ChainFrame {
  mtf::Image image;
  Spilled spilled{};                             ///< by [blooming]
  Clipped well, adc;                             ///< all pixels that are held at an end of the range
  HeldPixels held;                               ///< those that light has brought there
  HeldPixels held_defects;                       ///< those that are defective, or blinking in the high state
  std::shared_ptr<const TwoPoint> correction{};  ///< that it has
  std::int64_t noise_rows = 1;  ///< the first row and every so-many-th after it have noise of each pixel
  std::vector<std::pair<std::string_view, double>> timing_ms;  ///< of the stages that ran, in their order
};

/// What one frame of a sequence leaves to the next, for a rolling shutter, lag and a shutter that closes. A state
/// belongs to one sequence.
struct ChainState {
  ShutterState shutter;
  LagState lag;
  /// The last one of the shutter of a thermal camera. A caller with a schedule gives it before each frame; else the
  /// first frame stands for a closing that was not run.
  std::optional<ShutterClosing> closing;
  std::optional<std::uint32_t> last;  ///< number of the frame before
};

struct CompiledChain;

/// A sensor ready for frames of one size: what is the same in all of them is made once. Copies share it; run() is const
/// and re-entrant.
class Chain {
 public:
  /// `plan` is that of `system` for scenes of weighted radiance, with PlanOptions::separate_readout and
  /// samples_a_pitch(). `origin` is the first pixel of the image on the detector, whose format is [frame] format, or as
  /// large as the image needs. `before` is a chain of the same sequence, whose two-point correction this one takes, as
  /// a camera is corrected once: where both have [correction] and the same pixels; maps of pixels that are the same are
  /// shared. With `keep_shading` the image has the [vignetting] of that correction, too, as bright on the mean as its
  /// own: the correction takes it away, and would leave that of another sensor. Saturation is that of the kept shading.
  /// Throws UsageError for a sensor without [detector], for a plan with other filters, for maps that do not cover the
  /// image, and for settings that contradict each other.
  Chain(const mtf::SensorPlan& plan, const mtf::System<double>& system, const Sensor& sensor, Origin origin = {},
        int threads = 0, const Chain* before = nullptr, bool keep_shading = false);

  /// Measures now what the first image at that stage would measure; call it before frames run in parallel.
  void prepare(OutputStage stage, int threads = 0) const;
  /// The image at a stage of frame number `frame`. `radiance` is used up. `state` is that of the sequence, whose frames
  /// come in rising order (numbers left out are time that passes); without one a frame stands for itself. The first
  /// image of a sensor with [correction] at `display` measures its flat frames, which takes 2 x frames of them. With
  /// `whole_levels` a display of levels to 255 may come rounded to whole ones, halves upwards, as files of 8 bits have
  /// them. Throws UsageError for a stage beyond last_output_stage() and a plane of another size, RuntimeError as
  /// Plan::run.
  ChainFrame run(mtf::Image radiance, std::uint32_t frame, OutputStage stage, double border_value = 0.0,
                 int threads = 0, ChainState* state = nullptr, bool whole_levels = false) const;
  /// The same of a scene that comes again and is not used up (mtf/engines/kept_scene.h): its only plane is the
  /// radiance. `noise_rows`: of rows that nobody will look at shot and read noise may be left out; see
  /// ChainFrame::noise_rows for whether they were. The pixels of the others are the same, but for bad ones that take
  /// values from their neighbours.
  ChainFrame run(mtf::KeptScene& radiance, std::uint32_t frame, OutputStage stage, double border_value = 0.0,
                 int threads = 0, ChainState* state = nullptr, std::int64_t noise_rows = 1,
                 bool whole_levels = false) const;

  /// Numbers of frames: `count` of them from `first` on.
  struct Batch {
    std::uint32_t first = 0, step = 1;
    std::int64_t count = 1;
  };
  /// Frames of a scene that comes again, each of which stands for itself: bit for bit what run() gives for one after
  /// the other, in one submission where a device does all of the work on them. Their times are shares of the whole.
  std::vector<ChainFrame> run_batch(mtf::KeptScene& radiance, const Batch& batch, OutputStage stage,
                                    double border_value = 0.0, int threads = 0, bool whole_levels = false) const;
  /// How many frames are best run so: 1 where the processor does a part of the work. Call prepare() first.
  std::int64_t batch_size(OutputStage stage) const;

  /// Electrons for one unit of weighted radiance, on the axis.
  double electrons_per_radiance() const;

 private:
  /// `kept`: the scene in place of `radiance`, or null.
  ChainFrame run_scene(mtf::Image radiance, mtf::KeptScene* kept, std::uint32_t frame, OutputStage stage,
                       double border_value, int threads, ChainState* state, std::int64_t noise_rows,
                       bool whole_levels) const;

  std::shared_ptr<const CompiledChain> compiled_;
};

/// The budget of a pixel on the axis that sees a surface of that temperature (and of the emissivity that [scene] gives,
/// its surroundings reflected) through the path. It counts all that [detector], [nonuniformity], [noise], [noise_3d]
/// and [adc] say, whether or not it is simulated, and what [correction] leaves of the spatial noise. Row, column and
/// 3-D noise count as other and offset noise. Throws UsageError as camera_of, pixel_of and band_radiances.
Budget<double> budget_of(const mtf::System<double>& system, const Sensor& sensor, double temperature_k);

/// Rms of [flicker] over the detector, e-; 0 without it.
double flicker_rms_e(const mtf::System<double>& system, const SensorSettings& settings);

/// D* in cm sqrt(Hz) / W of that budget's temporal noise, at the middle of the band and with the quantum efficiency
/// there; NaN for a thermal detector without noise_bandwidth.
double dstar_of(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget);
/// The same as a row of the budget, which says the wavelength.
BudgetRow dstar_row(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget);
/// All rows of a budget, the D* last. Those of a thermal detector are in volts, with each noise as NETD too.
std::vector<BudgetRow> budget_rows(const mtf::System<double>& system, const Sensor& sensor,
                                   const Budget<double>& budget);

/// Every stage in its order; those that are off name the table that would switch them on.
std::vector<ChainStage> chain_stages(const mtf::System<double>& system, const Sensor& sensor);

/// The stages up to an output stage that need more of an image than the pixels of a tile, each with its reason, as in
/// "veiling glare (adds the mean of the whole image)"; "" where the image can be made in tiles (chain_tiles.h).
std::string whole_image_stages(const mtf::System<double>& system, const Sensor& sensor, OutputStage stage);

/// The tolerance that a converter asks for: a tenth of a count, relative to a scene of standard deviation `std` in
/// weighted radiance, at most 1e-2; nothing without [adc] or contrast. A tolerance is the rms error of the mean image.
std::optional<double> adc_tolerance(const mtf::System<double>& system, const Sensor& sensor, double std);

}  // namespace radiometry
