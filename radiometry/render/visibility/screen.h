// SPDX-License-Identifier: Apache-2.0
#pragma once

// The triangles of a scene on the screen of a camera: which of them is in front at n x n points of each sample.
//
// The points are Chebyshev's of equal weight along each axis: their mean is that over the square of the sample for
// polynomials of the third degree (n = 2) and the fifth (n = 4), so that it blurs as the square does: at a quarter of a
// cycle a sample, Nyquist's frequency at two samples a pitch, 0.8990 and 0.9003, where the square has 0.9003 and points
// evenly spread have 0.924 and 0.906.
//
// A corner has the coordinates (X, Y, W): it is seen at x = X/W, y = Y/W, in samples from the outer corner, W is its
// depth along the axis. A place (x, y, 1) is a sum of the coordinates of three corners. The triangle covers it where no
// weight of that sum is negative, and the sum of the weights is one over the depth there, so that corners behind the
// camera need no clipping (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997). The
// weight of a corner vanishes along the edge of the other two, E = a x + b y + c, where (a, b, c) is the cross product
// of their coordinates. Two triangles that share an edge have the same numbers with opposite signs, and E is worked out
// by the same steps for both: no place between them is missed, so that nothing shows through a closed surface.
//
// Coordinates and edges are in double precision; within 64 points E and the depth are continued in single precision,
// 4e-6 of a sample and 2e-7 of the depth. A point costs a few instructions, where the traversal of a tree costs some
// hundred: four points a sample take less time than one ray of Embree's (bench_render).

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/render/camera.h"
#include "radiometry/render/render_scene.h"

namespace radiometry::render {

/// Where point i of n is along a sample, from its edge.
constexpr double point_in_sample(int n, int i) {
  constexpr std::array<double, 1> one{0.5};
  constexpr std::array<double, 2> two{0.21132486540518712, 0.7886751345948129};
  constexpr std::array<double, 4> four{0.10267276385411728, 0.4062037629574601, 0.5937962370425399, 0.8973272361458828};
  const auto k = static_cast<std::size_t>(i);
  return n == 1 ? one[k] : n == 2 ? two[k] : four[k];
}

/// What is seen at the points of a band of rows.
struct ScreenRows {
  std::int64_t stride = 0;            ///< from a row to the next
  std::vector<float> nearness{};      ///< one over the depth; 0 where nothing is seen
  std::vector<std::uint32_t> side{};  ///< scene::index(side); kNone where nothing is seen
};

class Screen {
 public:
  static constexpr std::int64_t kRows = 16;  ///< of points, in a band

  /// Finds where the triangles are on the screen of a camera, which draw() needs; memory is used again. The sides
  /// without a temperature, which are the insides of solids, are not drawn.
  /// `likely`: of each side, kNone where it is not likely to be seen (empty: none is). What is seen does not depend on
  /// it; the likely ones are drawn first, and what they hide costs next to nothing. Scene and `likely` have to
  /// outlive the last draw().
  void place(const RenderScene& scene, const Camera& camera, int n, std::span<const std::uint32_t> likely, int threads);

  std::int64_t bands() const { return (height_ + kRows - 1) / kRows; }
  /// Fills rows [kRows * band, kRows * (band + 1)), the last ones of which may lie beyond the image. From any number of
  /// threads at once. Of equally near triangles the first of the scene is seen.
  void draw(std::int64_t band, ScreenRows& out) const;

 private:
  struct Corner {
    double x, y, w;
  };
  /// The columns and rows of points that a triangle may cover.
  struct Seen {
    std::uint32_t triangle, side;
    float most;  ///< nearness of its nearest corner
    std::int32_t x0, x1, y0, y1;
  };
  void place_corners(const Camera& camera, int threads);
  /// Writes those of the triangles from `begin` to `end` that may be seen to `out`; returns how many there are.
  std::size_t find_seen(std::uint32_t begin, std::uint32_t end, Seen* out) const;

  static constexpr std::int32_t kTile = 16;  ///< columns
  bool hidden(const Seen& seen, const std::vector<float>& least) const;
  void find_least(const ScreenRows& rows, std::int64_t count, std::vector<float>& least) const;

  const RenderScene* scene_ = nullptr;
  std::span<const std::uint32_t> likely_{};
  int n_ = 1;
  std::int64_t width_ = 0, height_ = 0;   ///< in points
  std::vector<Corner> corner_{};          ///< of each vertex
  std::vector<Seen> seen_{};              ///< as many as there are triangles; some of each chunk of them are in use
  std::vector<std::size_t> first_{};      ///< of the bands, in `of_band_`
  std::vector<std::uint32_t> of_band_{};  ///< numbers in `seen_`
};

}  // namespace radiometry::render
