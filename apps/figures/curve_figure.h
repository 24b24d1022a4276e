// SPDX-License-Identifier: Apache-2.0
#pragma once

// How OTF values are shown to people: the columns of tables, the figure, and the lines with the figures of merit.

#include <cmath>
#include <string>
#include <vector>

#include "apps/figures/curve_values.h"
#include "apps/figures/plot.h"

namespace apps {

inline double modulus(const mtf::Complex<double>& h) { return std::hypot(h.re, h.im); }

/// Components, then the products of presample and of the other lists that have components, then the system.
std::vector<const OtfColumn*> columns_of(const CurveValues& values);

/// MTF of every component (thin) and of the system (thick), with lines at Nyquist and at the cutoff. Products of lists
/// are drawn where they are neither the system nor a single component.
Figure curve_figure(const mtf::System<double>& system, const CurveValues& values);

/// Cutoff, Nyquist, Q and the MTF of every component at Nyquist, a line each.
std::string curve_footer(const mtf::System<double>& system, const Direction& direction, const KeyFigures& figures);

}  // namespace apps
