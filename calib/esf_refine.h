// SPDX-License-Identifier: Apache-2.0
#pragma once

// One more look at the pixels with what the correction found: residuals, noise and the line spread are taken about the
// corrected edge spread function, at the moved geometry, so that a reference far from the truth (a blur with contrast
// reversal, a sharpened image) does not pass for noise or turn the edge.

#include "calib/esf_correction.h"

namespace calib {

/// The step with the joint fit's changes of shape and its splines.
StepProfile corrected_profile(const StepProfile& reference, const JointFit& joint);

/// The state of the model moved by the joint fit; its equations are again about the reference `state.profile`, so that
/// solve_jointly() starts over from it. Moves the model's levels and geometry.
FitState refine(const EdgePixels& pixels, EdgeModel& model, const FitState& state, const JointFit& joint,
                const FitRounds& rounds);

/// The part of a joint fit that moves levels and geometry.
Vector movement(const JointFit& joint);

}  // namespace calib
