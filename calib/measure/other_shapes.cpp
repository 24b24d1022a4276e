// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/other_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/measure/correction/edge_response.h"
#include "calib/measure/correction/esf_correction.h"
#include "calib/measure/edge_figures.h"
#include "calib/measure/edge_terms.h"

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

void add_sharper_end(const EdgePixels& pixels, const CorrectedFit& corrected, const EdgeFacts& facts,
                     FitSettings settings, EdgeMeasurement& measurement) {
  constexpr double kNyquist_cy_px = 0.5;
  constexpr int kRounds = 2;
  const EdgeFit& own = corrected.fit;
  settings.unknowns = own.unknowns;
  const Vector at = movement(corrected.joint, 0.0);
  EdgeModel sharper = own.model;
  JointFit joint = corrected.joint;
  for (int round = 0; round < kRounds; ++round) {
    const std::array<double, kShapes> more = EdgeResponse(sharper, joint).towards_sharper(kNyquist_cy_px);
    Vector step = Vector::Zero();
    for (int k = 0; k < kShapes; ++k) step[kFirstShape + k] = at[kFirstShape + k] + more[static_cast<std::size_t>(k)];
    sharper = own.model;
    move(sharper, step);
    joint =
        solve_jointly(evaluate(pixels, sharper, settings), sharper, own.unknowns, Detail::none, facts.width_px, 0.0);
    joint.value.setZero();  // the response of the sharper model itself
    joint.contrast_ratio = 1.0;
    EdgeMeasurement described;
    describe(EdgeResponse(sharper, joint), described);
    widen_to_end(described, measurement);
  }
}

}  // namespace calib
