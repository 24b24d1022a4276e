// SPDX-License-Identifier: Apache-2.0
#pragma once

// The reference step fitted to the pixels of a region: the stages from a first model to the converged one, without
// single bad pixels.

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_facts.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/edge_region.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/measure.h"

namespace calib {

struct EdgeFit {
  EdgeModel model;
  FitState state{};  ///< of all pixels, at the model
  Unknowns unknowns;
  Diffraction diffraction = Diffraction::absent;
};

struct RegionFit {
  EdgeRegion data;       ///< less the pixels
  EdgePixels pixels{0};  ///< those that were fitted
  EdgeFit fit{};
  EdgeFacts facts{};
  FitSettings settings{};    ///< with what is found out about the noise
  std::size_t outliers = 0;  ///< left out
  std::size_t cut = 0;       ///< pixels at a limit of the values that count as values beyond it
};
RegionFit fit_region(EdgeRegion data, const MeasureOptions& options);
/// The same with noise that the pixels share.
void fit_again(RegionFit& region, const NoiseCorrelation& correlation, const MeasureOptions& options);

}  // namespace calib
