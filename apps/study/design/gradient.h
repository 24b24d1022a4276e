// SPDX-License-Identifier: Apache-2.0
#pragma once

// Derivatives of the metrics, objectives and constraints of a design by its axes, through the same code as their
// values.

#include "apps/study/design/design_light.h"
#include "apps/study/design/evaluator.h"

namespace study {

/// `light`: of the design; null for one that cannot be (all derivatives are NaN). `parameters`: of the design, in their
/// units. The series of the OTF are taken to `tolerance`, whatever the study's. Numbers that enter only the band
/// integrals of radiance (is_spectral) are differentiated by differences of fourth order.
Gradient gradient_of(const Study& study, const VariantSensor& variant, const DesignLight* light,
                     std::span<const double> parameters, double tolerance = 1e-9);

}  // namespace study
