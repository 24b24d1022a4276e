// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/other_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/edge/edge_response.h"
#include "calib/measure/edge_figures.h"
#include "calib/measure/edge_terms.h"
#include "calib/measure/esf_correction.h"

namespace calib {

void add_other_shapes(const EdgePixels& pixels, const EdgeFit& fit, const EdgeFacts& facts, FitSettings settings,
                      EdgeMeasurement& measurement) {
  constexpr double kWorse = 9.0;  // chi2
  settings.max_iterations = 8;
  settings.tolerance = 0.3;
  const double variance = fit.model.shape.blur_px2();
  for (const auto& [s_px, q_px2] : {std::array{0.0, 0.0}, {0.0, 1.0}, {0.5 * std::sqrt(variance), 1.0}}) {
    EdgeFit other = fit;
    const double rest_px2 = variance - q_px2 / 12.0 - 0.1 * s_px * s_px;
    other.model.shape = {.s_px = s_px, .v_px2 = std::max(2.0 * kLeastVariance_px2, rest_px2), .q_px2 = q_px2};
    other.unknowns.set(kFirstShape, s_px > 0.0).reset(kFirstShape + 2);
    settings.unknowns = other.unknowns;
    other.state = fit_reference(pixels, other.model, settings);
    if (chi2_of(other.state.sums, fit.state.weight) > fit.state.normal.chi2 + kWorse) continue;
    const JointFit joint = solve_jointly(other.state, other.model, without_bounds(other.unknowns, other.model),
                                         Detail::none, facts.width_px, 0.0);
    EdgeMeasurement described;
    describe(EdgeResponse(other.model, joint), described);
    add_difference(described, measurement);
  }
}

}  // namespace calib
