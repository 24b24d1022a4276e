// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of compiling a plan that stand on their own: the methods that are proposed, judged and chosen from, and the
// prediction of errors.

#include <functional>
#include <limits>
#include <memory>

#include "mtf/engines/engine.h"
#include "mtf/engines/fft/axis.h"
#include "mtf/engines/fft/spectral.h"
#include "mtf/engines/taps/taps.h"
#include "mtf/otf/factored_otf.h"
#include "mtf/plan/plan.h"

namespace mtf {

// How the tolerance is shared out; what is left over is for arithmetic.
inline constexpr double kDropShare = 0.05, kTableShare = 0.02, kWrapShare = 0.25, kBandShare = 0.05;

inline constexpr double kFloatUnit = 0x1p-24;  ///< half a unit in the last place of floats of 1 to 2

/// Compiles one part of the presample OTF by scale, for tiles (mtf/otf/split.h). Errors as compile().
Plan compile_part(const System<double>& system, const SampleGrid& scene, const SampleGrid& detector,
                  const PlanOptions& options, const ScaleSplit& split);

/// Norm of the defined canvas (canvas_norm of mtf/engines/statistics.h), in units of the scene's std. Without a scene:
/// that of a canvas whose parts are as contrasty as the image.
double canvas_norm_of(const PlanOptions& options, const SampleGrid& in);

/// What all methods for one plan share.
struct PlanTask {
  const FactoredOtf& sampler;
  SampleGrid in, out;
  const PlanOptions& options;
  ScaleSplit split;
  double canvas_norm = 1.0;    ///< canvas_norm_of the scene
  double norm = 1.0;           ///< the same, where all of it lies in the part of the scene that the detector sees
  double alias = 1.0;          ///< sqrt(frequencies that may alias onto one)
  double spectrum_gain = 1.0;  ///< largest factor between the rms_error of the scene's spectrum and the image's
};

/// One method and its parameters: judged, not yet built.
struct MethodCandidate {
  Candidate report;
  /// The least tolerance that this method could keep for this scene; infinity when it does not depend on the tolerance.
  double reachable = std::numeric_limits<double>::infinity();
  /// Makes the engine, sharing with `earlier` (may be null) what is the same.
  std::function<std::shared_ptr<const Engine>(const Engine* earlier)> make;
  std::optional<std::array<AxisTransform, 2>> axes;  ///< x and y of the FFT methods
  double largest_gain = 1.0;                         ///< bound of |H|, of the other methods
  double predicted_ms = 0.0;                         ///< cost_ms before anything was measured
  Lines lines = Lines::rows;                         ///< which the FFT methods transform first
  double lines_saved_ms = 0.0;                       ///< by lines that are uniform
  double error_per_otf = 0.0;                        ///< rms error relative to std that an OTF error of 1 may become
};

/// Both axes of an FFT method, all frequencies in use.
struct Layout {
  AxisTransform x, y;
  double wrap = 0.0;  ///< error of canvases shorter than the defined ones
};

/// Basis and canvas of each axis: the cheapest, and after it the one that has no wrap-around at any tolerance where
/// that is dearer.
std::vector<Layout> fft_layouts(const PlanTask& task);

/// Both axes in the fourier basis, whatever the border.
Layout fourier_layout(const PlanTask& task);

std::vector<MethodCandidate> fft_candidates(const PlanTask& task);
/// `fft_ms`: cost of the cheapest FFT method; methods that are far slower are not judged.
std::vector<MethodCandidate> tap_candidates(const PlanTask& task, double fft_ms);

inline std::string_view name_of(Method method) { return kMethodNames[static_cast<std::size_t>(method)]; }

/// Methods that share their engine, or all methods.
enum class Family { all, identity, taps, fft };
Family family(std::string_view method_name);
std::vector<MethodCandidate> all_candidates(const PlanTask& task, Family family);

/// The cheapest that keeps the tolerance (of the method asked for, if any), by prediction or, with `measure`, by timing
/// those that might be; null when there is none. Says in each candidate why it was not taken.
MethodCandidate* choose(std::vector<MethodCandidate>& candidates, const PlanTask& task, bool measure);

/// Throws what is to be said when none was chosen: UnreachableTolerance, or UsageError for a method that cannot.
[[noreturn]] void refuse(const std::vector<MethodCandidate>& candidates, const PlanOptions& options);

/// What a report says of the candidate that was chosen from `candidates` and of its engine (null: nothing to do).
void describe(const MethodCandidate& chosen, const std::vector<MethodCandidate>& candidates, const Engine* engine,
              const PlanTask& task, PlanReport& report);

/// "cosine 1024, fold to 256".
std::string axis_text(const AxisTransform& job);

/// Bound of |H_used - H| that comes from the components that the sampler left out.
double dropped_error(const FactoredOtf& sampler);

/// Whether the prediction keeps the tolerance. Without a scene only rounding can be said to break it.
bool keeps_tolerance(const MethodCandidate& candidate, const PlanOptions& options);

/// Frequencies that alias onto one detector frequency, at most.
double aliases(const AxisTransform& job);

/// What storing samples as float32 costs, rms relative to the scene's std.
double storage_error(const PlanOptions& options);

/// rms rounding of float32 relative to the scene's std. `canvas_rms`: of the canvas about the mean, in units of std.
double arithmetic_error(const AxisTransform& x, const AxisTransform& y, double canvas_rms, double gain,
                        const PlanOptions& options);

/// The least tolerance, rounded up to three digits, that leaves room for a given rounding, for an error of the band
/// average that cannot be made less, and for the share of a shortened canvas.
double reachable_tolerance(double arithmetic, double band, double wrap_share);

/// Throws UsageError, before anything is allocated, when that and one output plane exceed the machine's memory.
void require_memory(double bytes, const SampleGrid& out);

/// Bytes of OTF and buffers of an FFT method.
double spectral_bytes(const AxisTransform& x, const AxisTransform& y, const Parities& parities);

// Predicted run times, for choosing between methods: one thread, one channel, on the kind of machine that the constants
// were measured on. Only their ratios matter; Rigor::measure times the best few instead.

/// Milliseconds of an FFT method.
double fft_cost_ms(const AxisTransform& x, const AxisTransform& y, const Parities& parities);

/// Milliseconds of separable taps of a rank, and of `used` taps of a direct kernel.
double separable_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t rank);
double direct_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t used, bool mirrored);

/// The filter of a sampler's OTF on a device, both axes in the fourier basis and without obstacle (device_filter.h).
std::shared_ptr<const SpectralFilter> make_device_spectral_filter(const FactoredOtf& sampler, const AxisTransform& x,
                                                                  const AxisTransform& y,
                                                                  const std::shared_ptr<const Device>& device,
                                                                  int threads);

// The spectral engine with one OTF: what a plan of an FFT method runs.

/// Of everything between the images, which are float32: in double_precision only their storage rounds.
enum class Precision { single_precision, double_precision };

/// What is to be done by transforms.
struct SpectralWork {
  AxisTransform x, y;
  Precision precision = Precision::single_precision;
  Lines lines = Lines::rows;  ///< columns: where both axes are in the same basis
};

/// The filter of a sampler's OTF, which for double_precision should have no tables (table_share = 0). x in the cosine
/// basis needs y in it, and both `odd` where the OTF is not even along them. Shares the transforms of `earlier` (may
/// be null) where that one has the same axes, lines and precision.
std::shared_ptr<const SpectralFilter> make_spectral_filter(const FactoredOtf& sampler, const SpectralWork& work,
                                                           fft::Rigor rigor, int threads, const Engine* earlier);

/// The OTF on the frequencies of an engine, times its scale.
OtfBlocks<float> make_otf_blocks(const FactoredOtf& sampler, const SpectralEngine<float>& engine, int threads);

}  // namespace mtf
