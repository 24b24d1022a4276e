// SPDX-License-Identifier: Apache-2.0
#pragma once

// A pinhole camera on a grid of samples. With focal length f, pitch p and s samples a pitch, the centre of sample (i,
// j) lies at x = (i + 1/2) p/s, y = (j + 1/2) p/s from the outer corner of the detector, +x right along columns and +y
// down along rows, and sees along
//   ahead + (x - w/2)/f right + (y - h/2)/f down,   w x h the size of the detector,
// with ahead, right and down of length 1 and at right angles: distances along such a direction are depths, and its
// length times a depth is a range. The optical axis meets the middle of the detector; nothing is distorted.

#include <cstdint>

#include "radiometry/scene/vectors.h"

namespace radiometry::render {

using scene::Point, scene::Vector;

/// What a sensor says of its field of view.
struct Lens {
  double focal_length_mm = 0.0;
  double pitch_x_um = 0.0, pitch_y_um = 0.0;
  std::int64_t columns = 0, rows = 0;
  double samples_per_pitch = 2.0;  ///< along each axis
};

struct Pose {
  Point position{};
  Point look_at{};
  /// What is up in the image, as far as it is not along the line of sight. The vertical along a vertical line of sight
  /// stands for north, +y.
  Vector up{0.0, 0.0, 1.0};
};

struct Camera {
  Point position{};
  Vector ahead{}, right{}, down{};
  std::int64_t width = 0, height = 0;  ///< in samples
  double step_x = 0.0, step_y = 0.0;   ///< of the tangent of the angle, between samples
  double axis_x = 0.0, axis_y = 0.0;   ///< where the optical axis is, in samples from the outer corner

  /// Tangents of the angles from the axis; `x` and `y` in samples from the outer corner, centres are at halves.
  double tangent_x(double x) const { return (x - axis_x) * step_x; }
  double tangent_y(double y) const { return (y - axis_y) * step_y; }
  Vector direction(double x, double y) const {
    using scene::operator+, scene::operator*;
    return ahead + tangent_x(x) * right + tangent_y(y) * down;
  }
};

/// A detector of columns x rows pitches has as many samples as cover it. Throws mtf::UsageError for numbers that are
/// not finite or not above 0, more than 2^28 samples, and a line of sight without direction or along `up`.
Camera camera_of(const Lens& lens, const Pose& pose);

}  // namespace radiometry::render
