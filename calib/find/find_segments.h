// SPDX-License-Identifier: Apache-2.0
#pragma once

// The first steps of find_edges: image -> cells -> gradients -> smooth segments. Coordinates are in cells from the
// corner of the image, the centre of cell (i, j) is (i + 0.5, j + 0.5).

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "calib/edge/edge_curve.h"
#include "mtf/image.h"

namespace calib::find {

/// Means of the numbers in squares of `size_px` pixels; NaN where there is none. Cells of one pixel, unless most pixels
/// are masked (Bayer planes: two pixels) or the image is huge.
struct Cells {
  std::int64_t width = 0, height = 0;
  int size_px = 1;
  std::vector<float> value;  ///< from 0, the smallest, to 1, the largest
  double valid = 0.0;        ///< share of cells with a value
  double range = 0.0;        ///< largest - smallest value in the image's unit
  double noise_sd = 0.0;     ///< of a cell, from 0 to 1 as `value`; robust against structure in less than half of them
  double rounding = 0.0;     ///< of float32, likewise: smaller steps are no structure, whatever the noise
  double pixels_a_cell = 1.0;

  float at(std::int64_t x, std::int64_t y) const { return value[static_cast<std::size_t>(y * width + x)]; }
};
Cells make_cells(mtf::ImageView<const float> image);

/// Gradients of the cells smoothed by binomials (sd of one cell); masked cells are left out of the averages.
struct Gradients {
  std::int64_t width = 0, height = 0;
  std::vector<float> magnitude;         ///< of `value` per cell; 0 where unknown
  std::vector<std::uint8_t> direction;  ///< towards brighter, 256 parts of a turn from +x towards +y
  double threshold = 0.0;               ///< noise stays below

  float at(std::int64_t x, std::int64_t y) const { return magnitude[static_cast<std::size_t>(y * width + x)]; }
};
Gradients make_gradients(const Cells& cells);

/// A smooth piece of an edge: u = c0 + c1 s + c2 s^2 for s0 <= s <= s1, u along the normal, s along (-normal.y,
/// normal.x).
struct Segment {
  Point origin, normal;  ///< normal towards brighter
  std::array<double, 3> coefficient{};
  double s0 = 0.0, s1 = 0.0;
  double peak = 0.0;  ///< mean magnitude of the gradient on the ridge

  double length() const { return s1 - s0; }
  double offset(double s) const { return coefficient[0] + s * (coefficient[1] + s * coefficient[2]); }
  /// The point of the curve at s, moved by d along the normal.
  Point at(double s, double d = 0.0) const {
    const double u = offset(s) + d;
    return {origin.x + normal.x * u - normal.y * s, origin.y + normal.y * u + normal.x * s};
  }
  double along(Point p) const { return -normal.y * (p.x - origin.x) + normal.x * (p.y - origin.y); }
  double across(Point p) const { return normal.x * (p.x - origin.x) + normal.y * (p.y - origin.y) - offset(along(p)); }
};

/// Every segment of at least `min_length` cells, one after the other: a large image of clutter has millions.
using TakeSegment = std::function<void(const Segment&)>;
void make_segments(const Gradients& gradients, double min_length, const TakeSegment& take);

}  // namespace calib::find
