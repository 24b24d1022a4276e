// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pixels are evaluated again about the corrected edge spread function and at the moved geometry: residuals, noise
// and the line spread are taken there, so that a reference far from the truth (a blur with contrast reversal, a
// sharpened image) is not mistaken for noise and does not turn the edge.

#include "calib/measure/correction/esf_correction.h"
#include "calib/measure/region_fit.h"

namespace calib {

/// The reference step plus the joint fit's changes of shape and its splines, less what moving by `taken` does.
StepProfile corrected_profile(const StepProfile& reference, const JointFit& joint, const Vector& taken);

/// The state of the model moved by the joint fit, in plateaus, geometry and shape: residuals and noise are those about
/// the corrected step, the equations are about the reference of the new shape, so that solve_jointly() starts over
/// from it. `reference` is that of the model and becomes that of the moved one.
FitState refine(const EdgePixels& pixels, EdgeModel& model, StepProfile& reference, const JointFit& joint,
                const FitSettings& settings);

/// The step by which a joint fit moves the model; `shift_px`: the location of its response (EdgeResponse).
Vector movement(const JointFit& joint, double shift_px);

/// A fit with the correction of its edge spread function.
struct CorrectedFit {
  EdgeFit fit;
  JointFit joint{};
  /// Variance of the pixels about the model, half way up the step.
  double misfit() const { return joint.chi2_per_dof * fit.state.noise.at(0.5); }
};
/// Of the residuals about the corrected step.
NoiseCorrelation residual_correlation(const EdgePixels& pixels, const CorrectedFit& corrected,
                                      const FitSettings& settings);
/// The joint solution, refined as long as that brings the model nearer to the pixels and either residuals and noise
/// disagree or the correction moved the edge.
CorrectedFit correct(const EdgePixels& pixels, EdgeFit fit, const EdgeFacts& facts, FitSettings settings);

}  // namespace calib
