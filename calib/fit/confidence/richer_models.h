// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the errors of a fit leave out: they hold for the sensor as it was given. A lens of f/8 out of focus by 0.4 waves
// is fitted by f/14 in focus, known to 1.5 %, and the residuals do not show it where there is noise. So the fit is made
// again with one more unknown of those that sensors have and files leave out:
//   defocus   in a sensor with diffraction and no focus term or random wavefront, but for point sources in a band,
//   which take minutes jitter    where there is none motion    along x or y, whichever the data look along, where there
//   is no motion but jitter
// What becomes of each parameter is what the data say of it where that is not known to be 0. Where chi-square falls by
// more than chance explains, the sensor does not describe the data. A fitted blur that is known by its size alone, as a
// `gaussian`, stands for all causes, and needs none of this.

#include <functional>

#include "calib/fit/fit.h"

namespace calib {

/// Makes one fit as fit() does, without richer models, the edges with the gradients that they have in `plain`. `gain`:
/// how much chi-square falls by the last parameter, from its value 0, in units of the noise.
using RicherFit = std::function<FitResult(const FitData&, std::span<const FitParameter>, const FitOptions&,
                                          const FitResult& plain, double& gain)>;

/// Adds the richer models to a fit that converged, and takes back the verdict that its model is right where one of them
/// describes the data better.
void add_richer_models(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options,
                       const RicherFit& fit_richer, FitResult& result);

}  // namespace calib
