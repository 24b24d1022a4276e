// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which terms the model needs besides the two plateaus, a straight line and the shape: illumination gradients and bends
// of the edge, chosen by F-tests on how much each lowers chi2.

#include "calib/measure/edge_fit.h"
#include "calib/measure/measure.h"

namespace calib {

/// Dark and bright value, offset, angle, shape.
Unknowns basic_unknowns();
/// Adds the shifts t^2 .. t^order.
Unknowns with_order(Unknowns unknowns, int order);
Unknowns with_gradients(Unknowns unknowns);
/// All terms of the plateaus.
Unknowns with_shading(Unknowns unknowns);
/// Leaves out the unknowns of the shape that are on their bounds.
Unknowns without_bounds(Unknowns unknowns, const EdgeModel& model);

struct Terms {
  bool gradients = false;
  int order = 1;
};
/// `state` has the equations of all terms; `extent_px` is how far from the edge there are pixels. The order is chosen
/// only when the options leave it open.
Terms choose_terms(const FitState& state, const EdgeModel& model, double extent_px, const MeasureOptions& options,
                   int least_order = 1);

/// Whether the data show the cusp of diffraction, S > 0, significantly. Where they do not, it is left out: with S >= 0
/// as the only condition, noise would make blurs without diffraction seem sharper on average than they are. But where S
/// is so uncertain that most of the blur may or may not be diffraction (`unclear`), leaving it out would state an MTF
/// at low frequencies that the data do not know. All of the shape stays unknown then, and the joint solution may take
/// it beyond its bounds: an estimate that ends at a bound is biased, and its standard deviation is too small.
enum class Diffraction { shown, absent, unclear };
Diffraction diffraction_in(const FitState& state, const EdgeModel& model, const Unknowns& unknowns);

/// Sets the kind of the curve and the number of its coefficients.
void set_order(EdgeCurve& curve, int order, bool circle);

}  // namespace calib
