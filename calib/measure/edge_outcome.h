// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a region holds one edge that can be measured, and if not, what to change.

#include <string>
#include <vector>

#include "calib/edge/edge_pixels.h"
#include "calib/measure/edge_facts.h"
#include "calib/measure/measure.h"

namespace calib {

struct Outcome {
  Trouble trouble = Trouble::none;
  std::string reason;
  bool refused() const { return trouble != Trouble::none; }
};

/// Before anything is fitted: enough pixels with data, few of them clipped, any contrast at all.
Outcome judge_region(const RegionFacts& facts, const Roi& roi, const MeasureOptions& options);
/// After the fit: an edge with enough contrast, length and plateau.
Outcome judge_edge(const EdgeFacts& facts);
/// After the correction, which describes uneven light and light that is scattered far: one edge, neither side clipped.
Outcome judge_structure(const EdgeFacts& facts);
/// Of the curves: whether they can be those of a step.
Outcome judge_response(const EdgeMeasurement& measurement);

/// What is worth knowing though there is a result. `sparse`: missing pixels are nothing to warn of.
std::vector<std::string> warnings_of(const EdgeFacts& facts, const EdgeMeasurement& measurement, bool sparse);

}  // namespace calib
