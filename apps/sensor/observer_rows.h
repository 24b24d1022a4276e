// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an observer makes of the noise of a budget: MRTD and MDTD (radiometry/performance/target_at_range.h) as two more
// rows of `mtf budget`, for photon and thermal detectors alike. The noise is the NETD and the spatial NETD of the
// budget; the observer has the defaults of a study. Studies have the same figures as the metrics `mrtd` and `mdtd`,
// with any observer and derivatives.

#include <vector>

#include "radiometry/chain/chain.h"

namespace apps {

/// Who the observer of these rows is, and what air lies before the sensor.
std::vector<std::string> observer_lines(const radiometry::Sensor& sensor);

/// Both at half of the Nyquist frequency, bars and a square of 1 / Nyquist; `system` has the electron rate of its band.
/// A row without a value says why.
std::vector<radiometry::BudgetRow> observer_rows(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                                                 const radiometry::Budget<double>& budget);

}  // namespace apps
