// SPDX-License-Identifier: Apache-2.0
#pragma once

// The scene as the sun sees it: along its direction everything is a plane picture, in which a triangle covers what is
// behind it. Shadows end at the outlines of the picture: at edges that one triangle has alone, or that several have of
// which not exactly one lies on either side, as where a surface turns away from the sun.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "radiometry/scene/facets.h"

namespace radiometry::render {

using scene::Point, scene::Vector;

class SunPicture {
 public:
  /// Metres across the direction to the sun, from the middle of the scene.
  using Place = std::array<double, 2>;
  struct Box {
    Place low, high;
    static Box none();
    void take(const Place& p);
    void take(const Box& other);
    bool meets(const Box& other) const {
      return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1];
    }
  };

  /// `to_sun`: of length 1. `facets` outlives it.
  SunPicture(const scene::Facets& facets, const Vector& to_sun, int threads);

  const Vector& to_sun() const { return to_sun_; }
  /// Of the picture; with the direction to the sun they are a right-handed frame.
  const std::array<Vector, 2>& axes() const { return axes_; }
  const Place& place(std::uint32_t vertex) const { return place_[vertex]; }
  /// Whether the edge from corner `k` of a triangle to the next is an outline.
  bool outline(std::uint32_t triangle, std::size_t k) const { return (outline_[triangle] >> k & 1U) != 0U; }
  /// Whether a triangle runs counter-clockwise, as its front faces the sun.
  bool faces(std::uint32_t triangle) const { return (outline_[triangle] & kFaces) != 0U; }
  /// Gives `take` each triangle whose box meets `box`, and stops where it returns false.
  template <class Take>
  void visit(const Box& box, const Take& take) const {
    visit(box, take, 0, 0, order_.size());
  }

 private:
  static constexpr std::size_t kLeaf = 8;  // triangles
  static constexpr std::uint8_t kFaces = 8U;

  void find_outlines();
  void build_tree(int threads);
  template <class Take>
  bool visit(const Box& box, const Take& take, std::size_t node, std::size_t first, std::size_t last) const {
    if (!box_[node].meets(box)) return true;
    if (last - first > kLeaf) {
      const std::size_t middle = first + (last - first) / 2;
      return visit(box, take, 2 * node + 1, first, middle) && visit(box, take, 2 * node + 2, middle, last);
    }
    return std::all_of(order_.begin() + static_cast<std::ptrdiff_t>(first),
                       order_.begin() + static_cast<std::ptrdiff_t>(last), take);
  }

  const scene::Facets* facets_;
  Vector to_sun_;
  std::array<Vector, 2> axes_{};
  std::vector<Place> place_;           ///< of each vertex
  std::vector<std::uint8_t> outline_;  ///< of each triangle: bit k, and kFaces
  std::vector<std::uint32_t> order_;   ///< of triangles, as the leaves of the tree have them
  std::vector<Box> box_;               ///< of nodes: the halves of node k are 2 k + 1 and 2 k + 2
};

}  // namespace radiometry::render
