// SPDX-License-Identifier: Apache-2.0
#pragma once

// The reference step fitted to the pixels of a region: the stages from a first model to the converged one, without
// single bad pixels, and without those so far from the edge that shading is curved there.

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_facts.h"
#include "calib/measure/edge_fit.h"
#include "calib/measure/edge_region.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/measure.h"

namespace calib {

struct EdgeFit {
  EdgeModel model;
  FitState state;  ///< of all pixels, at the model
  Unknowns unknowns;
  Diffraction diffraction = Diffraction::absent;
};

struct RegionFit {
  EdgePixels pixels;  ///< those that were fitted
  EdgeFit fit;
  EdgeFacts facts;
  FitSettings settings;  ///< with what the fit found out about the noise
};
RegionFit fit_region(EdgeRegion data, const MeasureOptions& options);

}  // namespace calib
