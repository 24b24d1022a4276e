// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which terms the data ask for beyond levels, a straight line and the shape: illumination gradients and bends of the
// edge, by F-tests on what each takes off chi2.

#include "calib/measure/edge_fit.h"
#include "calib/measure/measure.h"

namespace calib {

/// Levels, offset, angle, shape.
Unknowns basic_unknowns();
/// With the shifts t^2 .. t^order.
Unknowns with_order(Unknowns unknowns, int order);
Unknowns with_gradients(Unknowns unknowns);
/// Those of the shape that are on their bounds left out.
Unknowns without_bounds(Unknowns unknowns, const EdgeModel& model);

struct Terms {
  bool gradients = false;
  int order = 1;
};
/// `state` has the equations of all terms; `reach_px` is how far from the edge pixels go. The order is chosen only when
/// the options leave it open.
Terms choose_terms(const FitState& state, const EdgeModel& model, double reach_px, const MeasureOptions& options,
                   int least_order = 1);

/// Whether a side's level bends with the distance from the edge, as uneven light makes it: told from the outer part of
/// the pixels, where the tails of a blur are all but straight. Neither gradients nor a correction may take the bend.
bool levels_bend(const FitState& state, const EdgeModel& model, double width_px, double reach_px);

/// Whether the cusp of diffraction, S, is there beyond doubt. S >= 0 alone would make blurs without one sharper on
/// average than they are.
bool shows_diffraction(const FitState& state, const EdgeModel& model, const Unknowns& unknowns);

/// Gives the curve room for the coefficients of an order.
void set_order(EdgeCurve& curve, int order, bool circle);

}  // namespace calib
