// SPDX-License-Identifier: Apache-2.0
#pragma once

// Curves as JSON: what `mtf curve --format json` prints, and what the live view sends to its page.

#include "apps/sensor/otf_curves.h"
#include "apps/text/json.h"

namespace apps {

/// {"name", "unit", "angle_deg", "nyquist", "cutoff", "q", "frequency", "components", one member a list, "system"};
/// OTFs have real and imaginary parts.
Json curves_json(const OtfCurves& curves);

}  // namespace apps
