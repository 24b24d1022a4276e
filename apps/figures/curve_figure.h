// SPDX-License-Identifier: Apache-2.0
#pragma once

// How OTF values are shown: the figure, the lines with the figures of merit, JSON.

#include <cmath>
#include <string>

#include "apps/figures/plot.h"
#include "apps/sensor/otf_curves.h"
#include "apps/text/json.h"

namespace apps {

inline double modulus(const mtf::Complex<double>& h) { return std::hypot(h.re, h.im); }

/// MTF of every component (thin) and of the system (thick), with lines at Nyquist and at the cutoff. Products of lists
/// are drawn where they are neither the system nor a single component.
Figure curve_figure(const OtfCurves& curves);

/// Cutoff, Nyquist frequency, Q and the MTF of every component at Nyquist in the direction of the curves, by lines.
std::string curve_footer(const mtf::System<double>& system, const OtfCurves& curves);

/// As `mtf curve --format json` prints them and the live view sends them to its page: {"name", "unit", "angle_deg",
/// "nyquist", "cutoff", "q", "frequency", "components", one member a list, "system"}; OTFs have real and imaginary
/// parts.
Json curves_json(const OtfCurves& curves);

}  // namespace apps
