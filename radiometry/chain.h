// SPDX-License-Identifier: Apache-2.0
#pragma once

// The whole sensor, in the order of the physics (DESIGN section 2):
//   scene radiance, photons s^-1 m^-2 sr^-1 at the aperture, weighted by the camera's curves (scene_radiance.h)
//     -> distortion -> presample OTF, sampling at the pitch -> veiling glare, ghost          stage `radiance`
//     -> cone of light, transmission, vignetting                                             stage `irradiance`
//     -> shutter -> mean electrons of light + warm optics + stop (narcissus), x responsivity, + dark current -> lag
//     -> defects, blinking -> shot noise -> full well or blooming -> nonlinearity -> readout OTF
//     -> offsets, read, 1/f, row, column, 3-D noise                                           stage `electrons`
//     -> gain, offset, rounding, saturation                                                   stage `dn`
//     -> two-point correction, bad pixels -> postsample filters -> automatic gain, polarity   stage `display`
// Each stage is a free function on one frame, and a row of the table in chain_stages.cpp. A stage whose table is not in
// the sensor file does not run, nor do the stages after the one whose output is wanted. With [microscan] the sampling
// is finer than the pitch: the stages from `shutter` to the correction run for each position, and the frames are put
// together.

#include <memory>
#include <string>
#include <vector>

#include "mtf/plan/sensor_plan.h"
#include "radiometry/light/spectral_signal.h"
#include "radiometry/output_stage.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/sensor_settings.h"

namespace radiometry {

/// A sensor with all that the files named in its settings hold.
struct Sensor {
  SensorSettings settings;
  SpectralCamera curves;                                      ///< band, and the curves that were given as files
  Path path;                                                  ///< between scene and aperture
  Spectrum emissivity = constant_spectrum("blackbody", 1.0);  ///< of a scene of temperatures
  /// Maps of the whole detector in place of random ones, where they are given.
  std::shared_ptr<const mtf::Image> responsivity, offset, vignetting;
};

/// Throws UsageError for settings that need or exclude each other: what no table can say by itself.
void require_consistent(const mtf::System<double>& system, const Sensor& sensor);

/// Throws UsageError for a detector or for curves that make no electrons of any light in the band. Whoever reads the
/// curves from files checks them so.
void require_response(const Sensor& sensor);

/// Camera and pixel of a sensor as the camera equation takes them. What a curve gives is 1 there. Throws UsageError for
/// what is missing: an f-number, an integration time, [detector]; and as cone_sr.
Camera<double> camera_of(const mtf::System<double>& system, const Sensor& sensor);
Pixel<double> pixel_of(const mtf::System<double>& system, const Sensor& sensor);
/// Converter of a sensor with [adc]. Throws UsageError when it has neither electrons_per_count nor a full well.
Adc adc_of(const Sensor& sensor);

/// Samples a pitch that plans are to be compiled with: the steps of [microscan], else 1.
int samples_a_pitch(const Sensor& sensor);

/// Throws UsageError for a place that a sensor whose last one is `last` does not have.
void require_output_stage(OutputStage stage, OutputStage last, bool has_converter);

/// The last place that a sensor has: display where anything follows the converter, dn with [adc], else electrons.
OutputStage last_output_stage(const mtf::System<double>& system, const Sensor& sensor);
/// Where the camera has curves of the wavelength, radiance and irradiance are weighted by them: their quantity says so.
/// Unit of its image at a stage: "ph.s^-1.m^-2.sr^-1", "ph.s^-1.m^-2", "e-", "counts", "levels"; and the quantity.
std::string_view output_unit(const Sensor& sensor, OutputStage stage);
std::string_view output_quantity(const Sensor& sensor, OutputStage stage);

/// One stage as a sensor file gives it, for people.
struct ChainStage {
  std::string name;
  bool on = false;
  std::string what;  ///< with numbers; for a stage that is off the table that would switch it on
};

/// One frame that came out.
struct ChainFrame {
  mtf::Image image;
  Spilled spilled{};                                           ///< by [blooming]
  Clipped well, adc;                                           ///< pixels held at the ends, whatever held them
  HeldPixels held;                                             ///< the same by light: of pixels as they should be,
  HeldPixels held_defects;                                     ///< of those defective, or blinking and high by now
  std::vector<std::pair<std::string_view, double>> timing_ms;  ///< of the stages that ran, in their order
};

/// What one frame of a sequence leaves to the next, for a rolling shutter and lag. A state belongs to one sequence.
struct ChainState {
  ShutterState shutter;
  LagState lag;
  std::optional<std::uint32_t> last;  ///< number of the frame before
};

struct CompiledChain;

/// A sensor ready for frames of one size: what is the same in all of them is made once. Copies share; run() is const
/// and re-entrant.
class Chain {
 public:
  /// `plan`: of `system` for scenes of weighted radiance, with PlanOptions::separate_readout and samples_a_pitch().
  /// `origin`: the first pixel of the image on the detector, whose format is [frame] format, or what the image needs.
  /// `before`: a chain of the same sequence; its two-point correction is this one's too, as that of a camera which was
  /// corrected once. Throws UsageError for a sensor without [detector], for maps that do not cover the image, and for
  /// settings that contradict each other.
  Chain(const mtf::SensorPlan& plan, const mtf::System<double>& system, const Sensor& sensor, Origin origin = {},
        int threads = 0, const Chain* before = nullptr);

  /// Measures now what the first image at that place would: before frames run at once.
  void prepare(OutputStage stage, int threads = 0) const;
  /// The image at a stage of frame number `frame`. `radiance` is used up. `state`: of the sequence, whose frames come
  /// in rising order (numbers left out are time that passes); without one a frame stands for itself. The first image of
  /// a sensor with [correction] at `display` measures its flat frames, which takes 2 x frames of them. Throws
  /// UsageError for a stage beyond last_output_stage() and a plane of another size, RuntimeError as Plan::run.
  ChainFrame run(mtf::Image radiance, std::uint32_t frame, OutputStage stage, double border_value = 0.0,
                 int threads = 0, ChainState* state = nullptr) const;

  /// Electrons for one unit of weighted radiance, on the axis.
  double electrons_per_radiance() const;

 private:
  std::shared_ptr<const CompiledChain> compiled_;
};

/// The budget of a pixel on the axis that looks at a surface of that temperature (and of the emissivity that [scene]
/// gives, its surroundings reflected) through the path: all that [detector], [nonuniformity], [noise], [noise_3d] and
/// [adc] say, whether or not it is simulated, and what [correction] leaves of the spatial noise. Row, column and 3-D
/// noise count as other and offset noise. Throws UsageError as camera_of, pixel_of and band_radiances.
Budget<double> budget_of(const mtf::System<double>& system, const Sensor& sensor, double temperature_k);

/// Rms of [flicker] over the detector, e-; 0 without.
double flicker_rms_e(const mtf::System<double>& system, const SensorSettings& settings);

/// D* in cm sqrt(Hz) / W of that budget's temporal noise, at the middle of the band: the quantum efficiency there.
double dstar_of(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget);
/// The same as a row of the budget, which says the wavelength.
BudgetRow dstar_row(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget);

/// Every stage in its order, those that are off with the table that would switch them on.
std::vector<ChainStage> chain_stages(const mtf::System<double>& system, const Sensor& sensor);

/// The tolerance that a converter asks for: a tenth of a count, relative to a scene of standard deviation `std` in
/// weighted radiance, at most 1e-2; nothing without [adc] or contrast. A tolerance is the rms error of the mean image.
std::optional<double> adc_tolerance(const mtf::System<double>& system, const Sensor& sensor, double std);

}  // namespace radiometry
