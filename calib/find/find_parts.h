// SPDX-License-Identifier: Apache-2.0
#pragma once

// The steps of find_edges: image -> cells -> gradients -> smooth segments -> regions. Coordinates are in cells from the
// corner of the image, the centre of cell (i, j) is (i + 0.5, j + 0.5).

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "calib/find/find_edges.h"

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

/// The two sides of a segment.
struct Surroundings {
  double blur = 0.0;      ///< half width of the edge's own blur
  double free = 0.0;      ///< distance on both sides up to which there is no other structure
  double contrast = 0.0;  ///< between the medians just beyond the blur, in parts of the image's range
  double noise_sd = 0.0;  ///< of a pixel there, no less than the image's
};
/// Absent when the gradient does not fall to `floor` on both sides: no edge by itself, or a side without data.
std::optional<Surroundings> survey(const Cells& cells, const Gradients& gradients, const Segment& segment, double floor,
                                   double farthest);

/// How many cells of a rectangle have a gradient above a threshold, from an integral image.
class Structure {
 public:
  Structure(const Gradients& gradients, double threshold);
  std::int64_t count(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) const;

 private:
  std::int64_t width_ = 0;
  std::vector<std::uint32_t> sum_;
};

/// A region in cells with one edge in it.
struct Region {
  std::int64_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< up to, not including, x1, y1
  double length = 0.0;                          ///< of the edge in it
  double half_width = 0.0;
  bool whole = false;  ///< the image holds nothing else
};

struct RegionLimits {
  double min_length = 0.0, half_width = 0.0;  ///< in cells; half_width 0 = as suits
};
/// The best rectangle around the segment that holds no other structure; absent when there is none of this length.
std::optional<Region> place_region(const Gradients& gradients, const Structure& structure, double threshold,
                                   const Segment& segment, const Surroundings& surroundings,
                                   const RegionLimits& limits);

}  // namespace calib::find
