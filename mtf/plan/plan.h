// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a system, two sample grids and one tolerance to a compiled, immutable plan that filters images.
//
//   Plan plan = compile(system, {scene.view(), 3.75_um}, {.tolerance = 1e-4});
//   std::puts(plan.explain().c_str());
//   Image sampled(plan.out().width, plan.out().height);
//   plan.run(scene.view(), sampled.view());
//
// The tolerance is the rms error over the output pixels, before noise, relative to the scene's standard deviation. The
// reference is the exact OTF applied to the periodic canvas of mtf/border.h and evaluated at the detector centres.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/border.h"
#include "mtf/device/device.h"
#include "mtf/engines/kept_scene.h"
#include "mtf/error.h"
#include "mtf/frame.h"
#include "mtf/grid.h"
#include "mtf/image.h"
#include "mtf/otf/factored_otf.h"
#include "mtf/rigor.h"
#include "mtf/system.h"

namespace mtf {

/// A scene in memory: one plane of samples, and how far they lie apart.
struct SceneView {
  ImageView<const float> samples;
  AxisPair<double> step;      ///< length at the focal plane, object angle, or detector pixels; one, or x and y apart
  double border_value = 0.0;  ///< of what lies beyond the scene with Border::constant
};

/// The scene's samples at the focal plane of that frame.
SampleGrid grid_of(const SceneView& scene, const Frame<double>& frame);

/// What the plan knows of the scene before it runs; predictions hold for scenes like it.
struct SceneSummary {
  double std = 1.0;           ///< > 0
  double largest = 1.0;       ///< largest |value|, also of a constant border: the float32 storage error
  double canvas_norm = 2.0;   ///< canvas_norm of mtf/engines/statistics.h, in units of value
  double flat_rows = 0.0;     ///< share of the rows that are uniform
  double flat_columns = 0.0;  ///< share of the columns, counted in groups of 16 that are all uniform
  double error = 0.0;         ///< of the values as they come, at most: a table they were made with
  double deviation = 0.0;     ///< largest |value - mean|; 0: not known, at most 2 largest
};

/// Summary of a plane, or nothing when it is uniform: every tolerance is met then, but for the light that enters from a
/// constant border of another value.
std::optional<SceneSummary> summarise(ImageView<const float> scene, Border border, double border_value);

/// The tolerance asked for is below what can be kept for this scene and system.
class UnreachableTolerance : public UsageError {
 public:
  UnreachableTolerance(const std::string& what, double reachable) : UsageError(what), reachable_(reachable) {}
  double reachable() const {
    return reachable_;
  }  ///< a tolerance that is accepted; infinity when there is none below 1

 private:
  double reachable_;
};

/// Message for a tolerance that cannot be kept, and what limits it. `in_float`: what transforms in float could keep.
UnreachableTolerance unreachable_tolerance(double asked, double reachable, const std::optional<SceneSummary>& scene,
                                           double in_float = 0.0);

/// The methods of filtering and sampling. All FFT methods inverse-transform on the detector grid only.
enum class Method {
  identity,       ///< nothing to do
  separable,      ///< taps along the rows, then along the columns
  low_rank,       ///< a sum of such pairs, for point spreads that nearly factor
  direct_square,  ///< one two-dimensional kernel on a square, a disc
  direct_disc,    ///< or a diamond |x| + |y| <= r of samples, mirrored samples added first
  direct_diamond,
  fft_float,    ///< real transforms in float
  fft_cut,      ///< the same, only the columns below the cutoff
  fft_double,   ///< real transforms in double
  fft_device,   ///< real transforms in float on a device (mtf/device), transfers included
  field_modes,  ///< an OTF that changes over the image: the mean OTF and modes of the image (mtf/field)
  field_tiles   ///< the same, the modes in tiles
};
inline constexpr std::array<std::string_view, 12> kMethodNames{
    "identity",  "separable", "low_rank",   "direct_square", "direct_disc", "direct_diamond",
    "fft_float", "fft_cut",   "fft_double", "fft_device",    "field_modes", "field_tiles"};

class SceneSpectrum;
struct Channel;
struct SamplesOtf;

struct PlanOptions {
  double tolerance = 1e-4;
  std::optional<Method> method{};  ///< insist on it; otherwise the cheapest that keeps the tolerance
  Border border = Border::reflect;
  Rigor rigor = Rigor::estimate;
  SceneAperture aperture{};
  std::optional<SceneSummary> scene{};              ///< made by compile() where it is given a scene in memory
  std::shared_ptr<const SceneSpectrum> spectrum{};  ///< of this very scene: what an omission costs it, not any scene
  int threads = 0;                                  ///< for making the OTF; 0 = all cores
  OtfProgress progress = {};  ///< where slow components take long: how many of their values were made; may throw
  DeviceChoice device{};      ///< which the plan uses where that is faster; none: the processor alone
  std::shared_ptr<const Image> range_m{};  ///< of each sample, where defocus is by range (mtf/field/sample_ranges.h)
  bool separate_readout = false;  ///< noise comes between readout and postsample filters: a plan for each (SensorPlan)
};

/// Predicted error, each part as rms relative to the scene's std; the parts add linearly.
struct PredictedError {
  double dropped = 0.0;     ///< components left out
  double table = 0.0;       ///< interpolation of radial factors
  double band = 0.0;        ///< average over the wavelengths of the band
  double cut = 0.0;         ///< frequencies left out
  double wrap = 0.0;        ///< canvas shorter than the defined one
  double kernel = 0.0;      ///< taps left out
  double modes = 0.0;       ///< modes over the field left out, and interpolation between places of the image
  double flat = 0.0;        ///< contrast that the filter brings to uniform lines, left out
  double arithmetic = 0.0;  ///< float32 transforms and storage
  double total() const { return dropped + table + band + cut + wrap + kernel + modes + flat + arithmetic; }
};

/// One method and its parameters, as the plan judged them.
struct Candidate {
  Method method{};
  std::string detail;        ///< "17 x 15 taps, rank 2"; "cosine 1024, fold to 256"
  PredictedError predicted;  ///< where the method can do the work at all
  double cost_ms = 0.0;      ///< of a run on one thread, one channel: predicted
  bool measured = false;     ///< or measured (Rigor::measure)
  std::int64_t bytes = 0;    ///< filter, and buffers of one run
  bool on_device = false;    ///< PlanOptions::device does it
  bool possible = false;     ///< keeps the tolerance
  std::string reason;        ///< why not, or why another was chosen; "" for the chosen one
};

/// Name of direct_diamond where a device does it.
inline constexpr std::string_view kDiamondOnDevice = "diamond_device";

/// With the place where the work is done.
inline std::string_view name_of(const Candidate& candidate) {
  const bool moved = candidate.on_device && candidate.method == Method::direct_diamond;
  return moved ? kDiamondOnDevice : kMethodNames[static_cast<std::size_t>(candidate.method)];
}

/// Something a plan leaves out because the tolerance does not need it.
struct Omission {
  std::string what;
  double bound = 0.0;     ///< rms relative to the scene's std
  double saved_ms = 0.0;  ///< a run, estimated; 0 when only planning got cheaper
};

/// How a plan treats an OTF that changes over the field (mtf/field/field_modes.h).
struct FieldReport {
  std::size_t points = 0;      ///< places of the image at which OTFs were made; 0 for an isoplanatic system
  std::size_t modes = 0;       ///< besides the mean OTF, of a tile at most; 0: one OTF serves all pixels
  std::size_t tiles = 0;       ///< of field_tiles
  double one_otf_error = 0.0;  ///< predicted rms error where the OTF of the optical axis serves all pixels
  /// Of defocus by range: the nearest and the farthest, along the optical axis, and the least sum of weights of a
  /// pixel; points are ranges, and the one OTF is that of the mean defocus.
  struct Ranges {
    double nearest_m = 0.0, farthest_m = 0.0, least_weight = 1.0;
  };
  std::optional<Ranges> ranges{};
};

/// What a plan decided, for reports.
struct PlanReport {
  std::string method;      ///< name of the chosen one
  bool on_device = false;  ///< PlanOptions::device does it
  std::vector<Candidate> candidates;
  std::vector<Omission> omitted;
  SampleGrid in, out;
  std::int64_t whole_pitches_x = 0, whole_pitches_y = 0;  ///< that the scene holds; out may be less (format)
  std::array<std::int64_t, 2> size{};                     ///< transform lengths x, y
  std::array<std::string, 2> axes;                        ///< "cosine 1024, fold to 256"
  std::array<std::int64_t, 2> kept{};                     ///< frequencies k >= 0 in use, per axis
  std::array<std::int64_t, 2> available{};
  std::vector<Dropped> dropped;
  std::vector<std::string> merged;
  std::vector<std::string> notes;
  int wavelengths = 1;
  FieldReport field;
  PredictedError predicted;
  double tolerance = 0.0;
  double largest_gain = 1.0;                  ///< of |otf| over the frequencies in use
  std::int64_t otf_bytes = 0, run_bytes = 0;  ///< run_bytes: one channel and thread, besides input and output
};

/// Detector grid of a system over a scene: min(format, whole pitches in the scene) from the shared corner. Throws
/// UsageError when the scene is smaller than one pixel.
SampleGrid detector_grid(const System<double>& system, const SampleGrid& scene);

class DeviceImage;

class Plan {
 public:
  const PlanReport& report() const;
  const SampleGrid& in() const { return report().in; }
  const SampleGrid& out() const { return report().out; }
  /// Several lines: what was dropped, merged, chosen, and the predicted error in its parts.
  std::string explain() const;
  /// Gain of the mean.
  double dc() const;

  /// Filters one plane. Sizes have to be those of in() and out() (UsageError). NaN or infinite pixels: RuntimeError
  /// with their number and first position. A plane of zero contrast comes out as dc x value, exactly. `out` may lie in
  /// the memory of `in`, from its start: all of an input is read before any of its output is written. A plan made with
  /// a scene's spectrum keeps its promise for that scene. Where a device fails that was not insisted on, the processor
  /// does the work, with the same promise (Device::failure); else DeviceError.
  void run(ImageView<const float> in, ImageView<float> out, double border_value = 0.0, int threads = 0) const;
  /// All planes in one pass over the OTF.
  void run(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out, double border_value = 0.0,
           int threads = 0) const;

  /// The same of a scene that comes again, of whose transforms the later runs are spared (kept_scene.h).
  void run(KeptScene& scene, std::span<const ImageView<float>> out, double border_value = 0.0, int threads = 0) const;

  /// The same of a scene of one plane whose image may stay on the device that filters it. Then it is returned and `out`
  /// is not written; null where the image is in `out`. What happens to it later may throw DeviceError.
  std::unique_ptr<DeviceImage> run_on_device(ImageView<const float> in, ImageView<float> out, double border_value,
                                             int threads) const;
  std::unique_ptr<DeviceImage> run_on_device(KeptScene& scene, ImageView<float> out, double border_value,
                                             int threads) const;

  /// The plan of another system on the same grids and options. FFT plans are shared where the sizes stay, and the
  /// method stays unless it has become impossible or clearly dearer.
  Plan with(const System<double>& system) const;

 private:
  struct Impl;
  /// Takes samples of row y of a plane from column x on (Channel::take).
  using Take = std::function<void(std::size_t plane, std::int64_t y, std::int64_t x, std::span<const float> samples)>;
  /// `kept`: of each plane, or none. With `take` nothing is written to `out`.
  void run_planes(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out,
                  double border_value, int threads, std::span<KeptPlane> kept, const Take& take = {},
                  std::unique_ptr<DeviceImage>* stays = nullptr) const;
  friend Plan compile(const System<double>&, const SampleGrid&, const SampleGrid&, const PlanOptions&);
  friend Plan compile_over_field(const System<double>&, const SampleGrid&, const SampleGrid&, const PlanOptions&);
  friend Plan compile_over_range(const System<double>&, const SampleGrid&, const SampleGrid&, const PlanOptions&);
  friend Plan compile_over_samples(const SamplesOtf&, const SampleGrid&, const SampleGrid&, const PlanOptions&);
  void run_engine(const std::vector<Channel>& channels, int threads) const;
  void run_modes(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out, double border_value,
                 int threads, std::span<KeptPlane> kept) const;
  void run_samples(ImageView<const float> in, ImageView<float> out, int threads) const;
  struct Recompile;
  friend Plan compile_stages(const System<double>&, std::span<const Stage>, const SampleGrid&, const SampleGrid&,
                             const PlanOptions&, const Recompile&);
  std::shared_ptr<const Impl> impl_;
};

/// The presample OTF and the sampling at the pitch, for a scene that is in memory: options.scene is its summary,
/// whatever it was before, and the detector grid is that of the system. Errors as below.
Plan compile(const System<double>& system, const SceneView& scene, PlanOptions options);

/// The same for scenes that are known by their grid, and by options.scene where it is given. Throws UsageError for an
/// invalid system, a tolerance that is not in (0, 1) or that cannot be kept for this scene (UnreachableTolerance, with
/// a value that can), a method that cannot do the work, and sizes that do not fit memory.
Plan compile(const System<double>& system, const SampleGrid& scene, const SampleGrid& detector,
             const PlanOptions& options);

/// Readout and postsample filters on the detector grid, same size in and out. The border rule is the scene's.
Plan compile_post(const System<double>& system, const SampleGrid& detector, std::span<const Stage> stages,
                  const PlanOptions& options);

}  // namespace mtf
