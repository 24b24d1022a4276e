// SPDX-License-Identifier: Apache-2.0
#pragma once

// Arithmetic of vectors in three dimensions.

#include <cmath>

#include "radiometry/scene/mesh.h"

namespace radiometry::scene {

/// A difference of points in metres, or a direction of length 1.
using Vector = Point;

constexpr Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
constexpr Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
constexpr Vector operator*(double s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
constexpr double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
constexpr Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }
inline Vector unit(const Vector& a) { return (1.0 / length(a)) * a; }
inline bool finite(const Vector& a) { return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]); }

}  // namespace radiometry::scene
