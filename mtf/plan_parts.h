// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of compiling a plan that stand on their own: the OTF in the engine's layout, and the prediction of errors.

#include "mtf/engines/spectral.h"
#include "mtf/plan.h"

namespace mtf {

// How the tolerance is shared out; what is left over is for arithmetic.
inline constexpr double kDropShare = 0.05, kTableShare = 0.02, kCutShare = 0.01, kWrapShare = 0.25, kBandShare = 0.05;

/// H on the engine's frequencies, times its scale.
OtfBlocks make_otf(const OtfSampler& sampler, const SpectralEngine& engine, int threads);

/// Largest |H| of the blocks, the scale taken off.
double largest_gain(const OtfBlocks& otf, double scale);

/// Frequencies that alias onto one detector frequency, at most.
double aliases(const AxisJob& job);

/// rms rounding of float32 relative to the scene's std. `canvas_rms`: of the canvas about the mean, in units of std.
double arithmetic_error(const AxisJob& x, const AxisJob& y, double canvas_rms, double gain, const PlanOptions& options);

/// Throws UsageError, naming the tolerance to use, when the prediction exceeds the tolerance. `arithmetic` is that of
/// the shortest canvas, which a larger tolerance may choose.
void refuse_unreachable(const PredictedError& predicted, double arithmetic, double tolerance,
                        const PlanOptions& options);

/// Throws UsageError, before anything is allocated, when OTF, buffers and one output plane exceed the machine's memory.
void require_memory(const AxisJob& x, const AxisJob& y, bool real, const SampleGrid& out);

}  // namespace mtf
