// SPDX-License-Identifier: Apache-2.0
#pragma once

// The Fourier transform of a polygon, by triangles instead of edges. The mean of exp(-2 pi i f.x) over a triangle is
// twice the divided difference of exp(-2 pi i a) at the three phases a = f.vertex (Hermite and Genocchi), so nothing is
// divided by |f|^2: f = 0 and edges across f need no case of their own.

#include <span>
#include <string>

#include "mtf/frame.h"

namespace mtf {

/// Divided difference of z -> exp(z) at z = -2 pi i a for two to four phases a (cycles): real and imaginary part.
/// Absolute error a few 2^-53, plus that of the phases.
Complex<double> phase_divided_difference(std::span<const double> cycles);

struct Point {
  double x = 0.0, y = 0.0;
};

/// Why the closed line through the vertices is no polygon with an inside (fewer than three, repeated, crossing or
/// touching itself, thinner than rounding allows), or "".
std::string polygon_fault(std::span<const Point> vertices);

/// Whether the polygon is its own image under (x, y) -> (sx x, sy y), sx, sy = 1 or -1.
bool polygon_mirrored(std::span<const Point> vertices, double sx, double sy);

}  // namespace mtf
